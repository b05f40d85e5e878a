"""Contact between nodes: forces of a potential, depths, pins, symmetry, bits and the balance of energy."""

import numpy as np
import pytest
import trimesh

from tests.support.runs import one_sheet_run
from tests.support.sheet import plain_fabric
from weavesim.engine.sheet_model import CONTACT_SHARE
from weavesim.engine.state import State
from weavesim.engine.stepper import Stepper
from weavesim.engine.surface.samples import BLUNT_SHARE
from weavesim.errors import InputError
from weavesim.fabric.bending import IsotropicBending
from weavesim.fabric.cell.weaves import PlainWeave
from weavesim.fabric.fabric import Stabilisation
from weavesim.fabric.shear import LinearShear
from weavesim.kernels.rows import CornerRow, MotionRow
from weavesim.process.dynamics import Dynamics
from weavesim.process.strokes import Stroke
from weavesim.run.relaxation import relax
from weavesim.sheet.blank import Blank
from weavesim.sheet.samples import surface_points
from weavesim.sheet.symmetry import Symmetry
from weavesim.tools.mesh_tool import MeshShape
from weavesim.tools.shapes import Capsule, Plane, Sphere, rotation_matrix
from weavesim.tools.tool import Tool


@pytest.fixture
def cloth(fabric):
    """Soft, so that a tenth of a second takes few steps."""
    return fabric(
        areal_density=0.5, thickness=1.0e-3, unit_cell=PlainWeave.straight(stiffness_per_width=2000.0),
        shear=LinearShear(modulus=1.0e5), bending=IsotropicBending(modulus=1.0e6), transverse_shear_modulus=1.0e5,
        stabilisation=Stabilisation(),
    )  # fmt: skip


RADIUS = 0.02


def over_a_ball(cloth, samples: str, **solver):
    """A patch of 4 x 3 elements, bent over a ball and turned at random, just in contact with it; and its motion."""
    ball = Tool("ball", Sphere(RADIUS, origin=(0.0, 0.0, -RADIUS - 0.5 * cloth.thickness)))
    blank = Blank.rectangle((-0.01, -0.008), (0.01, 0.007), 0.005, yarn_angle=15.0)
    simulation = one_sheet_run(
        name="ball", blank=blank, fabric=cloth, tools=[ball], duration=1e-3, threads=1,
        dynamics=Dynamics(contact_samples=samples), **solver,
    )  # fmt: skip
    sheet, rng = simulation.model.sheet, np.random.default_rng(0)
    rows = sheet.read_motion(simulation.state.sheet.motion).astype(np.float64)
    flat = blank.node_position[:, :2]
    polar = np.linalg.norm(flat, axis=1) / RADIUS
    normal = np.column_stack([flat / RADIUS * np.sinc(polar / np.pi)[:, None], np.cos(polar)])
    position, director, remainder = (rows[MotionRow[n].vector] for n in ("position", "director", "remainder"))
    count = blank.node_count
    position[:count] = (RADIUS + 0.5 * cloth.thickness - 5e-6) * normal - [0.0, 0.0, RADIUS + 0.5 * cloth.thickness]
    position[:count] += 2e-6 * rng.normal(size=(count, 3))
    director[:count] = normal + 0.02 * rng.normal(size=(count, 3))
    director[:count] /= np.linalg.norm(director[:count], axis=1, keepdims=True)
    rounded = position.astype(sheet.precision.numpy)
    remainder[:] = position - rounded
    position[:] = rounded
    sheet.write_motion(simulation.state.sheet.motion, rows.astype(sheet.precision.numpy))
    return simulation, (position + remainder)[:count], director[:count].copy(), np.array(ball.shape.origin)


@pytest.mark.parametrize(
    ("precision", "lane_count", "error"), [("float64", 1, 1e-6), ("float64", 16, 1e-6), ("float32", 16, 2e-3)]
)
def test_forces_between_nodes_are_those_of_the_springs_energy(cloth, precision, lane_count, error, manual):
    """On corners and on directors: the elements' own are taken off by a run in which only nodes meet the tool."""
    corners = {}
    for samples in ("nodes", "surface"):
        solver = {"precision": precision, "lane_count": lane_count}
        simulation, position, director, centre = over_a_ball(cloth, samples, **solver)
        ahead = simulation.stepper.look_ahead()
        corners[samples] = simulation.model.sheet.corner_rows(ahead.sheet.corner_force).astype(np.float64)
    rows = corners["surface"] - corners["nodes"]
    quads, sheet = simulation.model.sheet.blank.quads, simulation.model.sheet
    force, couple = np.zeros_like(position), np.zeros_like(position)
    for corner in range(4):
        np.add.at(force, quads[:, corner], rows[corner, CornerRow.force.span].T)
        np.add.at(couple, quads[:, corner], rows[corner, CornerRow.couple.span].T)

    def energy(x: np.ndarray, d: np.ndarray) -> float:
        total = 0.0
        for place in sheet.samples.places:
            points = surface_points(x[quads], d[quads], np.tile(place, (len(quads), 1)))[0]
            depth = 0.5 * cloth.thickness - (np.linalg.norm(points - centre, axis=1) - RADIUS)
            total += 0.5 * float((sheet.samples.stiffness * np.maximum(depth, 0.0) ** 2).sum())
        return total

    rng, step = np.random.default_rng(1), 1e-8
    scale_force, scale_couple = np.linalg.norm(force), np.linalg.norm(couple)
    assert scale_force > 0.0
    assert scale_couple > 0.0
    worst = 0.0
    for _ in range(5):
        way, turn = rng.normal(size=(2, *position.shape))
        for dx, dd, found, scale in (
            (way, 0.0 * turn, (force * way).sum(), scale_force), (0.0 * way, turn, (couple * turn).sum(), scale_couple),
        ):  # fmt: skip
            reach = step if scale is scale_force else 1e3 * step
            difference = energy(position + reach * dx, director + reach * dd)
            difference -= energy(position - reach * dx, director - reach * dd)
            worst = max(worst, abs(found + difference / (2.0 * reach)) / scale)
    assert worst < error
    # the ball bears what the corners get, and no more
    reaction = simulation.frame.tool_reaction  # of the start, without contact
    assert np.all(reaction == 0.0)
    taken = ahead.tool_force.numpy()[0]
    nodes = 0.5 * cloth.thickness - (np.linalg.norm(position - centre, axis=1) - RADIUS)
    away = (position - centre) / np.linalg.norm(position - centre, axis=1, keepdims=True)
    at_nodes = ((sheet.contact_stiffness * np.maximum(nodes, 0.0))[:, None] * away).sum(axis=0)
    assert taken == pytest.approx(-(force.sum(axis=0) + at_nodes), rel=max(10.0 * error, 1e-6), abs=error * scale_force)
    if lane_count == 16:
        case = manual(
            "Contact", "Forces between nodes have a potential",
            known="At samples between its nodes the surface of a sheet meets a ball by springs. Their forces on "
            "corners and couples on directors are minus the derivatives of their energy, by differences. A patch "
            "of 5 mm elements over a ball of 20 mm, directors turned at random by 0.02.",
        )  # fmt: skip
        case.table(["precision", "largest error over the norm of the forces"], [[precision, worst]])


@pytest.mark.parametrize("size", [0.01, 0.005])
def test_nodes_and_samples_share_a_weight(cloth, size, manual):
    """On a plane both are as deep: what a pressure indents is less by the share of the samples."""
    blank = Blank.rectangle((-0.02, -0.01), (0.02, 0.01), size, height=0.5 * cloth.thickness)
    # couples on the directors cancel between elements, and would turn those of a free edge
    free = np.ones((blank.node_count, 6), dtype=bool)
    free[blank.boundary_loop(), 3:] = False
    simulation = one_sheet_run(
        name="rest", blank=blank, fabric=cloth, tools=[Tool("plane", Plane())], duration=1.0, precision="float64",
        lane_count=1, threads=1, free=free, dynamics=Dynamics(gravity=(0.0, 0.0, -9.81), contact_samples="surface"),
    )  # fmt: skip
    relax(simulation, tolerance=1e-5)
    depth = 0.5 * cloth.thickness - simulation.frame.position[:, 2]
    expected = 9.81 * simulation.model.reference_step**2 / (CONTACT_SHARE * (1.0 + BLUNT_SHARE))
    assert depth == pytest.approx(expected, rel=1e-4)
    energies = simulation.frame.energies
    assert energies["contact"] == pytest.approx(0.5 * energies["gravity_work"], rel=1e-3)
    weight = 9.81 * simulation.model.sheet.node_mass.sum()
    assert simulation.frame.tool_reaction[0] == pytest.approx([0.0, 0.0, -weight], rel=1e-4, abs=1e-9)
    if size == 0.005:
        case = manual(
            "Contact", "Nodes and samples share a weight",
            known="A sheet at rest on a plane that it meets between its nodes too, the directors of its edge held: all "
            "lie at the same depth, g dt0^2/(s (1 + s_b)), s_b the stiffness of the samples over that of the nodes.",
        )  # fmt: skip
        case.table(["expected depth [um]", "depth [um]"], [[1e6 * expected, 1e6 * depth.mean()]])


def pinned(samples: str, tool_of):
    """A pin with a round end of 3 mm comes up in the middle of an element of 8 mm; the edge keeps its height."""
    fabric = plain_fabric(
        areal_density=0.5, thickness=1.0e-3, unit_cell=PlainWeave.straight(stiffness_per_width=1e5),
        shear=LinearShear(modulus=1.0e5), bending=IsotropicBending(modulus=1.0e6), transverse_shear_modulus=1.0e6,
    )  # fmt: skip
    blank = Blank.rectangle((-0.02, -0.02), (0.02, 0.02), 0.008)
    free = np.ones((blank.node_count, 6), dtype=bool)
    free[blank.boundary_loop(), 2] = False
    pin = Tool("pin", tool_of(0.003, 0.5 * fabric.thickness), Stroke((0.0, 0.04), (0.0, 0.004)), friction=0.1)
    simulation = one_sheet_run(
        name="pin", blank=blank, fabric=fabric, free=free, duration=0.05, threads=1, frame_count=5, tools=[pin],
        dynamics=Dynamics(damping=200.0, director_damping=1e3, contact_samples=samples), accept_unusual=True,
    )  # fmt: skip
    simulation.run()
    return simulation


def analytic_pin(radius: float, half_thickness: float):
    """Under a sheet at zero."""
    upright = rotation_matrix((0.0, 1.0, 0.0), 0.5 * np.pi)
    return Capsule(radius=radius, half_length=0.02).placed((0.0, 0.0, -0.02 - radius - half_thickness), upright)


def mesh_pin(radius: float, half_thickness: float):
    angle = np.linspace(0.0, 0.5 * np.pi, 17)
    end = radius * np.column_stack([np.cos(angle), np.sin(angle)]) - [0.0, radius + half_thickness]
    end[-1, 0] = 0.0
    # in millimetres: trimesh leaves out triangles that are small
    pin = trimesh.creation.revolve(1e3 * np.concatenate([[[0.0, -0.04], [radius, -0.04]], end]), sections=64)
    return MeshShape.from_triangles(1e-3 * pin.vertices, pin.faces)


def test_a_pin_between_nodes_is_met(manual):
    case = manual(
        "Contact", "A pin between nodes",
        known="A pin with a round end of 3 mm radius comes up by 4 mm in the middle of an element of 8 mm, under a "
        "sheet of 1 mm whose edge keeps its height. Where only nodes meet tools it comes through and bears nothing; "
        "between nodes it lifts the sheet. Of four by four samples the nearest are d = 1.41 mm off its axis, so with "
        "R = 3.5 mm it comes R - sqrt(R^2 - d^2) = 0.30 mm nearer than half a thickness, and by the penalty.",
    )  # fmt: skip
    rows = []
    for samples, name, tool_of in (
        ("nodes", "analytic", analytic_pin), ("surface", "analytic", analytic_pin), ("surface", "mesh", mesh_pin),
    ):  # fmt: skip
        run = pinned(samples, tool_of)
        force, depth = abs(float(run.frame.tool_reaction[0, 2])), run.penetration.at_surface
        rows.append([samples, name, force, 1e3 * depth])
        if samples == "nodes":
            assert force == 0.0
            assert depth > 3e-3
        else:
            assert force > 0.01
            between = 3.5e-3 - np.sqrt(3.5e-3**2 - 2.0 * 1e-3**2)
            assert depth == pytest.approx(between, abs=0.05e-3)
            assert run.frame.position[:, 2].max() > 2e-3
            energies = run.frame.energies
            assert abs(energies["balance_error"]) < 0.01 * energies["tool_work"]
    case.table(["tools are met", "pin", "force on the pin [N]", "deepest overlap with the sheet's face [mm]"], rows)


def pressed(cloth, symmetry: Symmetry, run=True, **given):
    """A ball comes into a free sheet on a ring of another tool; all of it, or what the planes leave."""
    lower = tuple(0.0 if plane in symmetry.planes else -0.04 for plane in ("x", "y"))
    blank = Blank.rectangle(lower, (0.04, 0.04), 0.008)
    ball = Sphere(RADIUS, origin=(0.0, 0.0, RADIUS + 0.5 * cloth.thickness))
    floor = Plane(origin=(0.0, 0.0, -0.012 - 0.5 * cloth.thickness))
    free = {
        "tools": [
            Tool("ball", ball, Stroke.smooth(0.0115, 0.4, 0.01), friction=0.2, axis=(0.0, 0.0, -1.0)),
            Tool("floor", floor, friction=0.2),
        ],
        "duration": 0.045, "frame_count": 3, "threads": 1, "name": "pressed", "accept_unusual": True,
        "dynamics": Dynamics(
            damping=100.0, director_damping=1e3, gravity=(0.0, 0.0, -50.0), contact_samples="surface"
        ),
    }  # fmt: skip
    simulation = one_sheet_run(blank=blank, fabric=cloth, symmetry=symmetry, **(free | given))
    if run:
        simulation.run()
    return simulation


def test_a_quarter_is_a_quarter_of_the_whole_and_balances(cloth, manual):
    case = manual(
        "Contact", "Between nodes: symmetry and energy",
        known="A ball presses a sheet onto a floor, met between nodes too: the ledger closes, and a quarter of the "
        "sheet between symmetry planes gives a quarter of the forces and the same positions.",
    )  # fmt: skip
    whole = pressed(cloth, Symmetry(()), precision="float64", lane_count=1)
    quarter = pressed(cloth, Symmetry(("x", "y")), precision="float64", lane_count=1)
    for run in (whole, quarter):
        energies = run.frame.energies
        assert energies["friction_loss"] > 0.0
        assert abs(energies["balance_error"]) < 2e-3 * max(energies["supplied"], energies["used"])
    assert quarter.frame.tool_reaction[:, 2] == pytest.approx(0.25 * whole.frame.tool_reaction[:, 2], rel=1e-3)
    x = whole.model.sheet.blank.node_position
    inside = (x[:, 0] > -1e-9) & (x[:, 1] > -1e-9)
    order = [
        np.lexsort((np.round(1e6 * p[:, 0]), np.round(1e6 * p[:, 1])))
        for p in (x[inside], quarter.model.sheet.blank.node_position)
    ]
    here, there = whole.frame.position[inside][order[0]], quarter.frame.position[order[1]]
    difference = float(np.abs(here - there).max())
    assert difference < 1e-6
    worst = max(abs(run.frame.energies["balance_error"]) / run.frame.energies["supplied"] for run in (whole, quarter))
    case.table(["largest difference of a node [nm]", "error of the balance"], [[1e9 * difference, worst]])


def test_same_bits_for_any_number_of_threads_and_from_a_saved_state(cloth, tmp_path):
    runs = [pressed(cloth, Symmetry(()), threads=count, duration=0.02) for count in (1, 2, 3)]
    for run in runs[1:]:
        for (name, first), (_, other) in zip(runs[0].state.arrays(), run.state.arrays(), strict=True):
            assert np.array_equal(first.numpy(), other.numpy()), name
    stepper, state = runs[0].stepper, runs[0].state
    state.save(tmp_path / "state.npz", runs[0].model)
    loaded = State.load(tmp_path / "state.npz", runs[0].model)
    stepper.advance(2)
    again = Stepper(runs[0].model, loaded)
    again.advance(2)
    for (name, first), (_, other) in zip(state.arrays(), loaded.arrays(), strict=True):
        assert np.array_equal(first.numpy(), other.numpy()), name


def test_samples_are_passed_over_without_changing_a_bit(cloth):
    """Where they cannot touch: a run that looks at all of them in every step gets the same bits."""
    ends = {}
    for spare in (None, np.inf):
        dynamics = Dynamics(
            damping=100.0, director_damping=1e3, gravity=(0.0, 0.0, -50.0), contact_samples="surface",
            contact_allowance=0.02,
        )  # fmt: skip
        run = pressed(cloth, Symmetry(("x", "y")), run=False, dynamics=dynamics)
        asleep = []
        for surface in run.stepper._launches.surface.values():
            if spare is not None:
                surface.laws.spare_distance = spare
        while run.state.time < 0.03:
            run.stepper.advance(10)
            asleep.append(float((run.state.sheet.sample_gap.numpy() > 0.0).mean()))
        assert max(asleep) == 0.0 if spare else np.mean(asleep) > 0.3
        sheet = run.state.sheet
        assert sheet.sample_work_sum.numpy().any()
        ends[spare] = {name: array.numpy() for name, array in run.state.arrays() if not name.endswith("sample_gap")}
    assert [name for name, value in ends[None].items() if not np.array_equal(ends[np.inf][name], value)] == []


def test_samples_push_from_the_allowed_depth_on(cloth):
    """A sheet at rest on a plane that nodes alone would hold at depth d; from 0.4 d on samples push as much."""

    def resting(allowance):
        blank = Blank.rectangle((-0.02, -0.01), (0.02, 0.01), 0.01, height=0.5 * cloth.thickness)
        free = np.ones((blank.node_count, 6), dtype=bool)
        free[blank.boundary_loop(), 3:] = False
        dynamics = Dynamics(gravity=(0.0, 0.0, -9.81), contact_samples="surface", contact_allowance=allowance)
        return one_sheet_run(
            name="rest", blank=blank, fabric=cloth, tools=[Tool("plane", Plane())], duration=1.0, precision="float64",
            threads=1, free=free, dynamics=dynamics,
        )  # fmt: skip

    alone = 9.81 * resting(0.1).model.reference_step ** 2 / CONTACT_SHARE
    simulation = resting(0.4 * alone / cloth.thickness)
    relax(simulation, tolerance=1e-5)
    depth = 0.5 * cloth.thickness - simulation.frame.position[:, 2]
    assert depth == pytest.approx(0.7 * alone, rel=1e-4)
    energies = simulation.frame.energies
    share = 0.5 * (0.7**2 + 0.3**2) / 0.7
    assert energies["contact"] == pytest.approx(share * energies["gravity_work"], rel=1e-3)
    weight = 9.81 * simulation.model.sheet.node_mass.sum()
    assert simulation.frame.tool_reaction[0] == pytest.approx([0.0, 0.0, -weight], rel=1e-4, abs=1e-9)


def test_an_allowance_needs_samples():
    with pytest.raises(InputError, match="it needs contact_samples"):
        Dynamics(contact_allowance=0.04)
