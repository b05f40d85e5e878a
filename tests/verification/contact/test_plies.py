"""Contact between plies: known answers of stacks that press, slide and collide (docs/plies.md)."""

import numpy as np
import pytest

from tests.support.stacked_plies import (
    FABRIC,
    THICKNESS,
    momentum,
    nodes,
    pass_rows,
    ply,
    run_stack,
    square,
    stack_setup,
)
from weavesim import Simulation, Tool
from weavesim.process import (
    Coulomb,
    PressureFriction,
    StribeckFriction,
    Stroke,
    ViscousFilm,
    YarnAngleFriction,
)
from weavesim.process.strokes import Fixed
from weavesim.sheet.blank import Blank
from weavesim.tools import Plane, rotation_matrix

REDUCED = 0.5 * FABRIC.areal_density


def test_two_free_plies_collide(manual):
    """Linear momentum is kept to round-off, and the ledger closes; the plies separate with what they came with."""
    sheets = [
        ply("lower", square(0.03, 0.01), (0.0, 0.0, 1.0)),
        ply("upper", square(0.03, 0.01, THICKNESS + 2e-4, angle=34.0), (0.3, 0.0, -1.0)),
    ]
    run = run_stack(sheets, Coulomb(0.3), duration=4e-4, dynamics={"contact_damping_ratio": 0.0})
    linear, angular = momentum(run)
    impulse = run.model.sheets[0].node_mass.sum()  # times 1 m/s
    start = run.model.sheets[1].node_mass.sum() * np.array([0.3, 0.0, -1.0]) + impulse * np.array([0.0, 0.0, 1.0])
    np.testing.assert_allclose(linear, start, atol=1e-12 * impulse)
    assert np.isfinite(angular).all()
    assert nodes(run.model.sheets[1], run.state.sheets[1])[1][:, 2].mean() > 0.3
    last = run.history[-1]
    assert last["ply_friction_loss"] > 0.0
    assert max(abs(entry["balance_error"]) for entry in run.history[-2:]) < 0.01 * last["supplied"]
    case = manual(
        "Contact", "Two free plies collide",
        known="Squares of 60 mm, meshes at 34 degrees, closing at 2 m/s with friction: linear momentum is kept to "
        "round-off, and the ledger closes within 1 % of the energy.",
    )  # fmt: skip
    error = np.abs(linear - start).max() / impulse
    case.table(["change of momentum, relative", "error of the balance, relative"],
               [[error, abs(last["balance_error"]) / last["supplied"]]])  # fmt: skip


@pytest.mark.parametrize("ratio", [0.3, 1.0])
def test_what_dashpots_take_from_plies_that_part_is_booked(ratio):
    """Equal meshes on each other: a bounce of single springs, which dashpots hold back at its end."""
    sheets = [
        ply("lower", square(0.02, 0.01), (0.0, 0.0, 1.0)),
        ply("upper", square(0.02, 0.01, THICKNESS + 1e-4), (0.0, 0.0, -1.0)),
    ]
    run = run_stack(sheets, Coulomb(0.0), duration=3e-4, dynamics={"contact_damping_ratio": ratio})
    last = run.history[-1]
    assert last["ply_damping_loss"] > 0.3 * last["supplied"] and last["ply_contact"] == 0.0
    assert abs(last["balance_error"]) < 0.006 * last["supplied"]


@pytest.mark.parametrize(("size", "angle"), [(0.01, 0.0), (0.01 / 1.7, 30.0)])
def test_without_friction_both_momenta_are_kept(size, angle, manual):
    sheets = [
        ply("lower", square(0.03, 0.01), (0.0, 0.0, 1.0)),
        ply("upper", square(0.02, size, THICKNESS + 1e-4, angle, (0.004, 0.002)), (0.3, 0.1, -1.0)),
    ]
    setup = stack_setup(sheets, Coulomb(0.0), duration=3e-4, dynamics={"contact_damping_ratio": 0.2})
    run = Simulation(setup)
    before = momentum(run)
    spin = _spin_momentum(run)
    run.run()
    scale = run.model.sheets[0].node_mass.sum()
    linear, angular = momentum(run)
    np.testing.assert_allclose(linear, before[0], atol=1e-12 * scale)
    # contact makes no couples on directors, whose own momentum is booked by the shell
    turned = angular + _spin_momentum(run) - spin - before[1]
    np.testing.assert_allclose(turned, 0.0, atol=2e-4 * scale * 0.03)
    case = manual(
        "Contact", f"Two free plies collide without friction, the smaller with elements of {1e3 * size:.2g} mm",
        known="A square of 40 mm meets one of 60 mm with elements of 10 mm, off its middle, at 2 m/s, the finer mesh "
        "turned by 30 degrees: linear and angular momentum are kept.",
    )  # fmt: skip
    case.table(["change of momentum, relative", "of angular momentum, over the mass, 1 m/s and 30 mm"],
               [[np.abs(linear - before[0]).max() / scale, np.abs(turned).max() / (0.03 * scale)]])  # fmt: skip


def _spin_momentum(run) -> np.ndarray:
    from weavesim.kernels.rows import MotionRow

    total = np.zeros(3)
    for model, own in zip(run.model.sheets, run.state.sheets, strict=True):
        motion = model.read_motion(own.motion)[:, : model.blank.node_count].astype(np.float64)
        total += model.node_inertia @ motion[MotionRow.spin.vector]
    return total


@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_friction_stops_a_ply(precision, manual):
    """Rest after V rho_r/(mu p), slip half of V times that, and all its energy as heat, each within 1 %."""
    speed, pressure, coefficient = 1.0, 1000.0, 0.3
    sheets = [
        ply("lower", square(0.05, 0.01), (-0.5 * speed, 0.0, 0.0), pressure),
        ply("upper", square(0.05, 0.01, THICKNESS), (0.5 * speed, 0.0, 0.0), -pressure),
    ]
    rest = speed * REDUCED / (coefficient * pressure)
    run = run_stack(
        sheets, Coulomb(coefficient), duration=1.2 * rest, dynamics={"contact_damping_ratio": 0.3},
        solver={"precision": precision}, frame_count=24,
    )  # fmt: skip
    rows = pass_rows(run, 0)
    inner = rows["slip"] > 1e-4
    assert rows["slip"][inner].mean() == pytest.approx(0.5 * speed * rest, rel=0.01)
    last = run.history[-1]
    assert last["ply_friction_loss"] == pytest.approx(0.5 * REDUCED * speed**2 * 0.01, rel=0.01)
    moving = np.array([entry["kinetic"] for entry in run.history])
    time = np.array([entry["time"] for entry in run.history])
    # the kinetic energy of a constant deceleration is a parabola: its root falls linearly to zero at rest
    half = time < 0.8 * rest
    slope, start = np.polyfit(time[half], np.sqrt(moving[half]), 1)
    assert -start / slope == pytest.approx(rest, rel=0.01)
    assert abs(last["balance_error"]) < 1e-5 * last["supplied"]
    if precision == "float64":
        case = manual(
            "Contact", "Friction stops a ply",
            known="Two free squares of 0.743 kg/m^2 each under 1 kPa slide on each other at 1 m/s with mu = 0.3: rest "
            "after V rho_r/(mu p), half of V times that as slip, and all the energy of the relative motion as heat.",
        )  # fmt: skip
        case.table(
            ["", "known", "weavesim"],
            [
                ["time to rest [ms]", 1e3 * rest, -1e3 * start / slope],
                ["slip [mm]", 0.5e3 * speed * rest, 1e3 * rows["slip"][inner].mean()],
                ["heat [mJ]", 0.5e3 * REDUCED * speed**2 * 0.01, 1e3 * last["ply_friction_loss"]],
            ],
        )


def test_a_viscous_film_slows_a_ply_exponentially(manual):
    """rho_r dv/dt = -eta v/h."""
    viscosity, film, speed, pressure = 20.0, 1e-4, 1.0, 200.0
    rate = viscosity / film / REDUCED
    sheets = [
        ply("lower", square(0.05, 0.01), (-0.5 * speed, 0.0, 0.0), pressure),
        ply("upper", square(0.05, 0.01, THICKNESS), (0.5 * speed, 0.0, 0.0), -pressure),
    ]
    run = run_stack(sheets, ViscousFilm(viscosity, film), duration=1.0 / rate, solver={"time_step": 5e-8})
    share = run.model.passes[0].viscous_share
    middle = [nodes(model, own)[1][:, 0] for model, own in zip(run.model.sheets, run.state.sheets, strict=True)]
    relative = np.median(middle[1]) - np.median(middle[0])
    expected = speed * np.exp(-share * rate * run.state.time)
    assert relative == pytest.approx(expected, rel=0.02)
    case = manual(
        "Contact", "A film of resin slows a ply",
        known="Two free squares slide on each other at 1 m/s on a film of viscosity eta and thickness h: their "
        "relative velocity falls as exp(-eta t/(h rho_r)).",
    )  # fmt: skip
    case.table(["share of the viscosity that the step carries", "known velocity [m/s]", "velocity [m/s]"],
               [[share, expected, relative]])  # fmt: skip


def plates(height: float, stack: float) -> tuple[Tool, ...]:
    """A plate under the stack, and one that comes down by ``stack`` [m] from ``height``."""
    turned = rotation_matrix((1.0, 0.0, 0.0), np.pi)
    down = Stroke((0.0, 1e-3, 1.0), (0.0, stack, stack))
    return (
        Tool("table", Plane(origin=(0.0, 0.0, -0.5 * THICKNESS)), Fixed(), friction=0.0),
        Tool("press", Plane(origin=(0.0, 0.0, height), rotation=turned), down, axis=(0.0, 0.0, -1.0), friction=0.0),
    )


@pytest.mark.parametrize("meshes", [(0.01, 0.0), (0.01, 45.0), (0.006, 30.0)], ids=["equal", "turned", "finer"])
def test_every_interface_of_a_stack_carries_the_pressure(meshes, manual):
    """Three plies between plates: every interface carries the force, and the height gives way as the penalties say."""
    size, angle = meshes
    half = 0.03 if angle == 0.0 else 0.02
    sheets = [
        ply("1", square(0.03, 0.01)),
        ply("2", square(half, size, THICKNESS, angle)),
        ply("3", square(0.03, 0.01, 2 * THICKNESS)),
    ]
    press = 4e-5
    run = run_stack(
        sheets, Coulomb(0.0), duration=8e-3, dynamics={"contact_damping_ratio": 0.5, "damping": 4000.0},
        tools=plates(2.5 * THICKNESS, press),
    )  # fmt: skip
    force = -run.frame.tool_reaction[:, 2]
    assert force[0] == pytest.approx(-force[1], rel=0.01) and force[0] > 10.0
    for interface in (0, 1):
        carried = sum(
            each.place.side * pass_rows(run, k)["force"][2].sum()
            for k, each in enumerate(run.model.passes)
            if each.place.interface == interface
        )
        assert carried == pytest.approx(force[0], rel=0.01)
    last = run.history[-1]
    assert abs(last["balance_error"]) < 0.01 * last["supplied"]
    if angle == 0.0:
        area = 0.06**2
        pressure = force[0] / area
        steps = [sheet.reference_step for sheet in run.model.sheets]
        tools = 2.0 * pressure * steps[0] ** 2 / (0.05 * FABRIC.areal_density)
        interfaces = 2.0 * pressure / run.model.passes[0].area_stiffness
        assert tools + interfaces == pytest.approx(press, rel=0.02)
        case = manual(
            "Contact", "A stack between plates",
            known="Three plies are pressed together by 0.04 mm: every interface carries the force of the plates, and "
            "the stack gives way by p dt0^2/(s_c rho) at each plate and p/k_a at each interface. With the middle ply "
            "turned by 45 degrees, or finer by 1:1.7 and turned by 30 degrees, the forces are equal too.",
        )  # fmt: skip
        case.table(["pressure [kPa]", "predicted approach [um]", "approach [um]"],
                   [[1e-3 * pressure, 1e6 * (tools + interfaces), 1e6 * press]])  # fmt: skip


def on_incline(slope: float, coefficient: float, size: float):
    """A ply that lies on a held one under gravity that is tilted by ``slope`` [rad], after 20 ms."""
    gravity = (9.81 * np.sin(slope), 0.0, -9.81 * np.cos(slope))
    below = square(0.04, size)
    held = ply("lower", below, free=np.zeros((below.node_count, 6), dtype=bool))
    return run_stack(
        [held, ply("upper", square(0.02, size, THICKNESS))], Coulomb(coefficient), duration=0.02, frame_count=4,
        dynamics={"gravity": gravity, "contact_damping_ratio": 0.5},
    )  # fmt: skip


def incline_row(size: float) -> list[object]:
    """Below the friction angle it stays, above it accelerates by g (sin - mu cos): a row of the manual."""
    coefficient = 0.4
    run = on_incline(np.arctan(0.8 * coefficient), coefficient, size)
    position, velocity = nodes(run.model.sheets[1], run.state.sheets[1])
    moved = (position - run.model.sheets[1].blank.node_position)[:, 0].mean()
    creep = velocity[:, 0].mean()
    assert abs(moved) < 1e-7 and abs(creep) < 1e-5
    assert pass_rows(run, 0)["slip"].max() < 1e-7
    slope = np.arctan(1.25 * coefficient)
    run = on_incline(slope, coefficient, size)
    got = nodes(run.model.sheets[1], run.state.sheets[1])[1][:, 0].mean() / run.state.time
    expected = 9.81 * (np.sin(slope) - coefficient * np.cos(slope))
    assert got == pytest.approx(expected, rel=0.01)
    return [1e3 * size, 1e9 * moved, 1e6 * creep, expected, got, f"{100.0 * (got / expected - 1.0):+.2g} %"]


def test_a_ply_on_an_incline():
    incline_row(0.01)


@pytest.mark.verification
def test_study_of_a_ply_on_an_incline(manual):
    """On three meshes."""
    rows = [incline_row(size) for size in (0.02, 0.01, 0.005)]
    case = manual(
        "Contact", "A ply on an incline",
        known="A ply on a held one, mu = 0.4: at tan(angle) = 0.8 mu it stays where it is, and at 1.25 mu it "
        "accelerates by g (sin - mu cos). After 20 ms.",
    )  # fmt: skip
    case.table(
        ["element size [mm]", "moved at 0.8 mu [nm]", "velocity then [um/s]",
         "known acceleration at 1.25 mu [m/s^2]", "got", "deviation"],
        rows,
    )  # fmt: skip


def test_the_middle_ply_is_pulled_out_with_the_friction_of_both_faces(manual):
    from weavesim import Drive, Support

    pressure, coefficient = 500.0, 0.25
    bottom = square(0.03, 0.01)
    middle = square(0.05, 0.01, THICKNESS)
    top = square(0.03, 0.01, 2 * THICKNESS)
    edge = np.flatnonzero(middle.node_position[:, 0] > 0.05 - 1e-9)
    pull = Support(
        "pull", edge, (Drive(Stroke((0.0, 2e-3, 1.0), (0.0, 2.5e-4, 0.2)), (1.0, 0.0, 0.0)),), displacements="x"
    )
    fixed = np.ones((len(bottom.node_position), 6), dtype=bool)
    fixed[:, :2] = False
    sheets = [
        ply("bottom", bottom, pressure=pressure, free=fixed),
        ply("middle", middle, supports=(pull,)),
        ply("top", top, pressure=-pressure, free=fixed),
    ]
    run = run_stack(
        sheets, Coulomb(coefficient), duration=0.012, dynamics={"contact_damping_ratio": 0.5}, frame_count=8
    )
    # the ply vibrates as it is pulled: the work of friction over the way is its mean force
    early, last = run.history[4], run.history[-1]
    way = 0.2 * (last["time"] - early["time"])
    drag = (last["ply_friction_loss"] - early["ply_friction_loss"]) / way
    assert drag == pytest.approx(2.0 * coefficient * pressure * 0.06**2, rel=0.01)
    assert abs(last["balance_error"]) < 0.01 * last["supplied"]
    case = manual(
        "Contact",
        "The middle of three plies is pulled out",
        known="Under a normal force N the drag is 2 mu N; here it is the work of friction over the way.",
    )
    case.table(["2 mu N [N]", "drag [N]"], [[2.0 * coefficient * pressure * 0.06**2, drag]])


@pytest.mark.parametrize("lane_count", [1, 16])
def test_the_same_bits_for_any_number_of_threads(lane_count):
    def end(threads: int) -> list[bytes]:
        sheets = [
            ply("lower", square(0.05, 0.006), pressure=1e4),
            ply("upper", square(0.04, 0.005, THICKNESS, 20.0), (1.0, 0.0, 0.0), pressure=-1e4),
        ]
        run = run_stack(
            sheets, Coulomb(0.2), duration=1.5e-4,
            solver={"threads": threads, "precision": "float32", "lane_count": lane_count},
        )  # fmt: skip
        assert pass_rows(run, 0)["push"].max() > 0.0
        return [array.numpy().tobytes() for _, array in run.state.arrays() if array.size]

    assert end(1) == end(3)


LAWS = {
    "pressure": (PressureFriction((0.0, 2000.0), (0.35, 0.25)), 0.0, lambda speed: 0.3),
    "yarns at 30 degrees": (YarnAngleFriction((0.0, 90.0), (0.3, 0.6)), 30.0, lambda speed: 0.4),
    "yarns at 120 degrees": (YarnAngleFriction((0.0, 90.0), (0.3, 0.6)), 120.0, lambda speed: 0.5),
    "Stribeck": (StribeckFriction((0.0, 2e-3), (0.2, 0.4), 1.0), 0.0, lambda speed: 0.2 + 0.1 * speed),
}


def test_friction_laws_give_their_own_curves_back(manual):
    """Work of friction over normal force and way, at a pressure of 1 kPa and 1 m/s, within 2 %."""
    pressure, speed, rows = 1000.0, 1.0, []
    for name, (friction, angle, law) in LAWS.items():
        upper = Blank.rectangle((-0.05, -0.05), (0.05, 0.05), 0.01, yarn_angle=angle, height=THICKNESS)
        sheets = [
            ply("lower", square(0.05, 0.01), (-0.5 * speed, 0.0, 0.0), pressure),
            ply("upper", upper, (0.5 * speed, 0.0, 0.0), -pressure),
        ]
        run = run_stack(sheets, friction, duration=4.5e-4, dynamics={"contact_damping_ratio": 0.5}, frame_count=8)
        entries = run.history
        time = np.array([entry["time"] for entry in entries])
        lost = np.array([entry["ply_friction_loss"] + entry["ply_friction_spring"] for entry in entries])
        moving = np.sqrt(np.array([entry["kinetic"] for entry in entries]) / entries[0]["kinetic"]) * speed
        # the first block ends while the springs still stretch
        way = np.trapezoid(moving[2:], time[2:])
        known = np.trapezoid(np.array([law(v) for v in moving[2:]]) * moving[2:], time[2:]) / way
        got = (lost[-1] - lost[2]) / (pressure * 0.01 * way)
        assert got == pytest.approx(known, rel=0.02), name
        rows.append([name, known, got, f"{100.0 * (got / known - 1.0):+.2g} %"])
    case = manual(
        "Contact", "Friction laws of plies",
        known="Two free squares slide on each other under 1 kPa, from 1 m/s: the work of friction over normal force "
        "and way is the law's coefficient, mu(p), mu of the angle between the warps, or mu(eta v/p) on the mean.",
    )  # fmt: skip
    case.table(["law", "known", "got", "deviation"], rows)


def test_half_a_stack_moves_as_the_whole(manual):
    """Mirror symmetry, with the plane x = 0 as a symmetry plane.

    Not to rounding: the spring of a node on an edge turns with the facet on one side of it.
    """

    def end(low: float, symmetry: tuple[str, ...]) -> list[np.ndarray]:
        blanks = [Blank.rectangle((low, -0.02), (0.03, 0.02), 0.01, height=height) for height in (0.0, THICKNESS)]
        blanks[1] = Blank.rectangle((low, -0.015), (0.03, 0.015), (0.01, 0.0075), height=1.001 * THICKNESS)
        upper = ply("upper", blanks[1])
        thrown = np.zeros((blanks[1].node_count, 3))
        thrown[:, 2] = -2.0 * (1.0 - (blanks[1].node_position[:, 0] / 0.03) ** 2)
        thrown[:, 0] = blanks[1].node_position[:, 0] * 20.0
        upper = upper.model_copy(update={"initial_velocity": thrown})
        run = run_stack(
            [ply("lower", blanks[0]), upper], Coulomb(0.3), duration=4e-4, symmetry=symmetry, solver={"time_step": 2e-6}
        )
        assert run.history[-1]["ply_friction_loss"] > 0.0
        return [
            frame.position[blank.node_position[:, 0] > -1e-9]
            for frame, blank in zip(run.frame.sheets, blanks, strict=True)
        ]

    largest = []
    for half, whole in zip(end(0.0, ("x",)), end(-0.03, ()), strict=True):
        assert half.shape == whole.shape
        order = [np.lexsort(np.round(each[:, :2], 6).T) for each in (half, whole)]
        np.testing.assert_allclose(half[order[0]], whole[order[1]], atol=3e-9)
        largest.append(1e9 * np.abs(half[order[0]] - whole[order[1]]).max())
    case = manual(
        "Contact", "Half of two plies",
        known="A ply is thrown onto another one, which has a finer mesh, with friction: half of both beside a symmetry "
        "plane moves as the whole, to the spring of a node on an edge, which turns with one of the facets beside it.",
    )  # fmt: skip
    case.table(["largest difference of the lower ply [nm]", "of the upper ply [nm]"], [largest])
