"""Pressure that follows a face, with known answers."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from tests.support.runs import one_sheet_run, small_run
from weavesim.fabric.bending import IsotropicBending
from weavesim.fabric.cell import LinearMembrane
from weavesim.fabric.shear import LinearShear
from weavesim.process.dynamics import Dynamics
from weavesim.process.pressure import Pressure
from weavesim.run.relaxation import relax
from weavesim.sheet.blank import Blank

STIFFNESS = 1.0e4
CHORD, PRESSURE = 0.2, 2000.0
RADIUS, HOOP_PRESSURE = 0.05, 4000.0
RAMP = 0.02


@pytest.fixture
def film(fabric):
    """A membrane that hardly resists bending."""
    return fabric(
        areal_density=0.5, thickness=2.0e-4,
        unit_cell=LinearMembrane(warp_stiffness=STIFFNESS, weft_stiffness=STIFFNESS),
        bending=IsotropicBending(modulus=1.0e6), transverse_shear_modulus=1.0e6,
    )  # fmt: skip


def inflated(film, blank, free, pressure, **given):
    """At rest under a pressure from below, and the error of the ledger over the work before that."""
    simulation = one_sheet_run(
        name="inflated", blank=blank, fabric=film, free=free, pressures=(Pressure.ramped("bottom", pressure, RAMP),),
        duration=3.0 * RAMP, precision="float64", lane_count=1, threads=1, frame_count=20,
        dynamics=Dynamics(damping=200.0), **given,
    )  # fmt: skip
    simulation.run()
    energies = simulation.frame.energies
    assert energies["pressure_work"] > 0.9 * energies["internal"] > 0.0
    error = abs(energies["balance_error"]) / energies["pressure_work"]
    relax(simulation, tolerance=1e-4)
    return simulation, error


def test_a_clamped_strip_bulges_to_a_circular_arc(film, manual):
    rows, errors = [], []
    half = brentq(lambda a: 2.0 * STIFFNESS * (a - math.sin(a)) / CHORD - PRESSURE, 0.1, 1.5)
    radius = 0.5 * CHORD / math.sin(half)
    tension, height = PRESSURE * radius, radius * (1.0 - math.cos(half))
    for count in (10, 20, 40):
        size = CHORD / count
        blank = Blank.rectangle((-0.5 * CHORD, 0.0), (0.5 * CHORD, size), size)
        x = blank.node_position[:, 0]
        free = np.ones((blank.node_count, 6), dtype=bool)
        free[:, [1, 3, 5]] = False  # in the plane x z
        free[np.abs(x) > 0.5 * CHORD - 1e-9, :3] = False
        simulation, error = inflated(film, blank, free, PRESSURE)
        assert error < 0.01
        position = simulation.frame.position
        force = simulation.frame.fields["warp_force"]
        top = float(position[:, 2].max())
        # all nodes on the circle of the known radius through the clamps
        off = np.abs(np.hypot(position[:, 0], position[:, 2] - (height - radius)) - radius).max()
        errors.append([abs(float(force.mean()) / tension - 1.0), abs(top / height - 1.0), off / height])
        rows.append([f"{1e3 * size:g}", f"{force.mean():.5g}", f"{1e3 * top:.5g}", f"{1e3 * off:.2g}", f"{error:.1e}"])
        assert np.ptp(force) < 0.02 * tension
    assert max(errors[-1]) < 0.003
    assert errors[1][1] < 0.3 * errors[0][1]  # of second order
    case = manual(
        "Process", "A clamped strip bulges under pressure",
        known="A long strip, clamped along its edges 200 mm apart, bulges to a circular arc with T = p R and "
        f"T = K (arc / chord - 1); K = 10 kN/m, p = 2 kPa: T = {tension:.5g} N/m, height {1e3 * height:.5g} mm.",
    )  # fmt: skip
    case.table(
        ["elements [mm]", "tension [N/m]", "height [mm]", "furthest from the arc [mm]", "balance error / work"], rows
    )


def test_a_hoop_under_pressure_carries_p_times_its_radius(film, manual):
    count = 12
    angle = np.linspace(0.0, 0.5 * math.pi, count + 1)
    size = RADIUS * float(angle[1])
    ring = np.column_stack([RADIUS * np.cos(angle), RADIUS * np.sin(angle)])
    nodes = np.concatenate([np.column_stack([ring, np.full(count + 1, z)]) for z in (0.0, size)])
    first = np.arange(count)
    quads = np.column_stack([first, first + 1, first + count + 2, first + count + 1])
    across = np.column_stack([np.gradient(nodes[: count + 1, 0]), np.gradient(nodes[: count + 1, 1])])
    warp = np.column_stack([0.5 * (across[1:] + across[:-1]), np.zeros(count)])
    coordinates = np.column_stack([RADIUS * np.tile(angle, 2), nodes[:, 2]])
    blank = Blank.from_mesh(nodes, quads, warp_direction=warp, material_coordinates=coordinates)
    free = np.ones((blank.node_count, 6), dtype=bool)
    free[:, [2, 3, 4]] = False
    outwards = bool((blank.initial_director * nodes).sum() > 0.0)
    simulation, error = inflated(film, blank, free, HOOP_PRESSURE if outwards else -HOOP_PRESSURE, symmetry=("x", "y"))
    strain = HOOP_PRESSURE * RADIUS / (STIFFNESS - HOOP_PRESSURE * RADIUS)
    radius, tension = RADIUS * (1.0 + strain), HOOP_PRESSURE * RADIUS * (1.0 + strain)
    found = np.linalg.norm(simulation.frame.position[:, :2], axis=1)
    force = simulation.frame.fields["warp_force"]
    assert error < 0.01
    assert found.mean() == pytest.approx(radius, rel=2e-3) and np.ptp(found) < 1e-3 * RADIUS
    assert force == pytest.approx(np.full(count, tension), rel=5e-3)
    case = manual(
        "Process", "A closed hoop under pressure",
        known="A hoop of radius 50 mm carries T = p R: with K = 10 kN/m and p = 4 kPa its radius grows by "
        f"{100 * strain:.4g} %. A quarter of it, 12 elements, between two symmetry planes.",
    )  # fmt: skip
    case.table(
        ["quantity", "expected", "got"],
        [["radius [mm]", f"{1e3 * radius:.5g}", f"{1e3 * found.mean():.5g}"],
         ["tension [N/m]", f"{tension:.5g}", f"{force.mean():.5g}"]],
    )  # fmt: skip


def hencky(ratio):
    """w0 over a (p a / (E t))^(1/3) of a clamped membrane of Poisson's ratio ``ratio``.

    With r = a rho and N_r = (E t p^2 a^2)^(1/3) n: the slope is -rho / (2 n) times the unit of w0 over a, and
    compatibility is rho d/drho [(1/rho) d/drho (rho^2 n)] = -rho^2 / (8 n^2); at the edge N_theta = nu N_r (H. Hencky,
    Zeitschrift fuer Mathematik und Physik 63, 311, 1915, who solved it by a series).
    """

    def solved(middle):
        def rates(rho, values):
            n, g, _ = values
            return [(g - 2.0 * n) / rho, -rho / (8.0 * n**2), rho / (2.0 * n)]

        start = 1e-4
        values = [middle - start**2 / (64.0 * middle**2), 2.0 * middle - start**2 / (16.0 * middle**2), 0.0]
        return solve_ivp(rates, (start, 1.0), values, rtol=1e-10, atol=1e-12).y[:, -1]

    middle = brentq(lambda n: (end := solved(n))[1] - end[0] - ratio * end[0], 0.3, 0.8)
    return float(solved(middle)[2])


def quarter_disc(radius, count):
    """A quarter of a disc in three blocks of ``count`` x ``count`` elements: nodes (n, 2) and quads."""
    u = np.linspace(0.0, 1.0, count + 1)
    corner, side = 0.45 * radius, 0.52 * radius
    across, up = np.meshgrid(u, u, indexing="ij")
    # a square with its far corner drawn in, and between its sides and the arc
    square = np.stack([across * (side + (corner - side) * up), up * (side + (corner - side) * across)], axis=-1)
    angle = 0.25 * np.pi * u
    rim = radius * np.column_stack([np.cos(angle), np.sin(angle)])
    right = square[-1][None] + u[:, None, None] * (rim - square[-1])[None]
    blocks = [square, right, right[:, ::-1, ::-1]]
    nodes, quads = [], []
    for block in blocks:
        index = len(nodes) * (count + 1) ** 2 + np.arange((count + 1) ** 2).reshape(count + 1, count + 1)
        nodes.append(block.reshape(-1, 2))
        quads.append(np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1).reshape(-1, 4))
    points, place = np.concatenate(nodes), np.concatenate(quads)
    _, first, inverse = np.unique(np.rint(points / (1e-9 * radius)), axis=0, return_index=True, return_inverse=True)
    return points[first], inverse.ravel()[place]


def test_a_disc_under_pressure_bulges_as_hencky_found(film, manual):
    radius, pressure, ratio = 0.1, 100.0, 0.3
    tension = STIFFNESS * (1.0 - ratio**2)  # E t
    assert hencky(ratio) == pytest.approx(0.653, abs=5e-4)
    height = hencky(ratio) * radius * (pressure * radius / tension) ** (1.0 / 3.0)
    isotropic = film.model_copy(
        update={
            "unit_cell": LinearMembrane(
                warp_stiffness=STIFFNESS, weft_stiffness=STIFFNESS, coupling_stiffness=ratio * STIFFNESS
            ),
            "shear": LinearShear(modulus=tension / (1.0 + ratio) / film.thickness),
        }
    )
    tops, rows = [], []
    for count in (2, 4):
        points, quads = quarter_disc(radius, count)
        blank = Blank.from_mesh(np.column_stack([points, np.zeros(len(points))]), quads)
        free = np.ones((blank.node_count, 6), dtype=bool)
        free[np.hypot(*points.T) > radius * (1.0 - 1e-9), :3] = False
        simulation, error = inflated(isotropic, blank, free, pressure, symmetry=("x", "y"))
        assert error < 0.01
        tops.append(float(np.abs(simulation.frame.position[:, 2]).max()))
        rows.append(
            [f"{3 * count**2}", f"{1e3 * tops[-1]:.5g}", f"{100 * (tops[-1] / height - 1.0):+.2g} %", f"{error:.1e}"]
        )
    # beside the mesh, the pressure follows the face, and Hencky's does not: a share of (w0 / a)^2
    assert tops[-1] == pytest.approx(height, rel=5e-3)
    assert abs(tops[1] - height) < abs(tops[0] - height) < 0.03 * height
    case = manual(
        "Process", "A clamped disc bulges under pressure",
        known="A clamped isotropic disc without bending stiffness: $w_0=c\\,a\\,(pa/(Et))^{1/3}$ with c = 0.653 at a "
        "Poisson's ratio of 0.3, from Hencky's equations, integrated in the test. E t = 9.1 kN/m, a = 100 mm, p = 100 "
        f"Pa: {1e3 * height:.5g} mm. A quarter between two symmetry planes.",
    )  # fmt: skip
    case.table(["elements", "height [mm]", "deviation", "balance error / work"], rows)


@pytest.mark.parametrize(("precision", "lane_count"), [("float64", 1), ("float32", 16)])
def test_forces_are_those_of_the_swept_volume_and_the_work_is_booked(precision, lane_count):
    """A free sheet under pressures on both faces and a part: momentum, work and forces against quadrature."""
    part = np.array([0, 5, 6])
    pressures = (Pressure("bottom", (300.0,)), Pressure("top", (100.0,), elements=part))
    run = small_run(pressures=pressures, duration=2e-3, precision=precision, lane_count=lane_count)
    run.run()
    sheet, frame = run.model.sheet, run.frame
    run.stepper.evaluate()
    with_pressure = run.model.sheet.nodal_forces(run.state.sheet.corner_force)
    position = frame.position
    blank, expected = sheet.blank, np.zeros((sheet.blank.node_count, 3))
    upwards = np.full(blank.element_count, 300.0)
    upwards[part] -= 100.0
    gauss = np.array([-1.0, 1.0]) / math.sqrt(3.0)
    corner_xi, corner_eta = np.array([-1.0, 1.0, 1.0, -1.0]), np.array([-1.0, -1.0, 1.0, 1.0])
    for quad, value in zip(blank.quads, upwards, strict=True):
        for xi in gauss:
            for eta in gauss:
                shape = 0.25 * (1.0 + corner_xi * xi) * (1.0 + corner_eta * eta)
                along = 0.25 * (corner_xi * (1.0 + corner_eta * eta)) @ position[quad]
                across = 0.25 * (corner_eta * (1.0 + corner_xi * xi)) @ position[quad]
                expected[quad] += value * shape[:, None] * np.cross(along, across)
    # the elastic forces of a free sheet have no resultant
    total = with_pressure.sum(axis=0)
    np.testing.assert_allclose(total, expected.sum(axis=0), atol=2e-4 * np.abs(expected).sum())
    mass = float(sheet.node_mass.sum())
    assert total[2] == pytest.approx((300.0 * 13 + 200.0 * 3) / 16 * 4e-4, rel=0.05)
    energies = frame.energies
    assert energies["pressure_work"] > 0.5 * mass * (total[2] / mass * frame.time) ** 2 * 0.8
    assert abs(energies["balance_error"]) < 0.01 * energies["pressure_work"]
