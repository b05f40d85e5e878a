"""Momentum, energy, repeatability of runs."""

import re
from functools import partial

import numpy as np
import pytest
import trimesh

from tests.support.runs import one_sheet_run
from weavesim.errors import RunError
from weavesim.fabric.bending import BendingCurve, YarnBending
from weavesim.fabric.cell.membrane import LinearMembrane
from weavesim.fabric.cell.weaves import PlainWeave
from weavesim.fabric.fabric import Fabric, Stabilisation
from weavesim.fabric.presets import assumed_fabric, glass_polypropylene
from weavesim.fabric.shear import LinearShear, MomentCurve, ShearFriction
from weavesim.kernels.lane_types import CPU_LANE_COUNT
from weavesim.kernels.rows import MotionRow
from weavesim.process.dynamics import Dynamics
from weavesim.process.loads import NodalLoads
from weavesim.process.strokes import Stroke
from weavesim.ranges import QUANTITIES
from weavesim.run.frame import Outcome
from weavesim.run.simulation import Simulation
from weavesim.sheet.blank import Blank
from weavesim.tools.mesh_tool import MeshShape
from weavesim.tools.shapes import Capsule, Plane, Sphere, Union, rotation_matrix
from weavesim.tools.tool import Tool


def momenta(simulation: Simulation) -> tuple[np.ndarray, np.ndarray]:
    """Momentum [kg m/s], and angular momentum about the origin [kg m^2/s] with that of the directors."""
    model = simulation.model.sheet
    motion = model.read_motion(simulation.state.sheet.motion)[:, : model.blank.node_count].astype(np.float64)
    position = motion[MotionRow.position.vector] + motion[MotionRow.remainder.vector]
    velocity, spin = motion[MotionRow.velocity.vector], motion[MotionRow.spin.vector]
    mass, inertia = simulation.model.sheet.node_mass[:, None], simulation.model.sheet.node_inertia[:, None]
    return (mass * velocity).sum(axis=0), (mass * np.cross(position, velocity) + inertia * spin).sum(axis=0)


def thrown_sheet(fabric: Fabric, duration: float, **given) -> Simulation:
    """A free sheet that turns, bends, shears and stretches."""
    blank = Blank.rectangle((-0.02, -0.015), (0.02, 0.015), 0.005, yarn_angle=20.0, distortion=0.2)
    x, y, _ = blank.node_position.T
    waves = np.column_stack([np.sin(100.0 * y), np.cos(120.0 * x), np.sin(150.0 * x) + np.cos(90.0 * y)])
    velocity = np.cross([30.0, -20.0, 200.0], blank.node_position) + [1.0, 2.0, -1.0] + 3.0 * waves
    settings = {"precision": "float64", "lane_count": 1, "threads": 1, "frame_count": 10}
    return one_sheet_run(
        name="thrown", blank=blank, fabric=fabric, duration=duration, initial_velocity=velocity, **(settings | given)
    )


def test_free_sheet_keeps_its_momenta():
    simulation = thrown_sheet(glass_polypropylene(), 1e-3)
    momentum, angular = momenta(simulation)
    simulation.run()
    assert simulation.stepper.step_count > 500
    assert simulation.frame.energies["internal"] > 0.1 * simulation.frame.energies["initial_kinetic"]
    spin = simulation.model.sheet.read_motion(simulation.state.sheet.motion)[
        MotionRow.spin.vector, : simulation.setup.sheet.blank.node_count
    ]
    share_of_directors = np.abs((simulation.model.sheet.node_inertia[:, None] * spin).sum(axis=0)).max()
    later, angular_later = momenta(simulation)
    assert np.abs(later - momentum).max() < 1e-12 * np.abs(momentum).max()
    assert np.abs(angular_later - angular).max() < 1e-10 * np.abs(angular).max()
    # the check would notice if the directors were left out
    assert share_of_directors > 1e-6 * np.abs(angular).max()


@pytest.mark.parametrize("in_plane", [0.0, 5.0e-3])
@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_free_vibration_keeps_its_energy(precision, in_plane):
    """The ledger takes everything at one instant: what is left is the error of the time integration.

    That of a nonlinear sheet, of second order in the step: a quarter of the stable step leaves a tenth or less.

    With in-plane bending of the yarns the mean angles are a step behind: what that costs is booked as damping.
    """
    straight = PlainWeave.straight(stiffness_per_width=2.0e5)
    fabric = glass_polypropylene().model_copy(
        update={
            "unit_cell": straight, "shear": LinearShear(modulus=2.0e7), "in_plane_bending_stiffness": in_plane,
        }
    )  # fmt: skip
    for time_step, tolerance in ((None, 5e-3), (1.45e-6, 5e-4)):
        simulation = thrown_sheet(fabric, 0.02, frame_count=100, precision=precision, time_step=time_step)
        simulation.run()
        assert simulation.stepper.step_count > 2000
        supplied = simulation.frame.energies["initial_kinetic"]
        error = np.array([entry["balance_error"] for entry in simulation.history]) / supplied
        internal = np.array([entry["internal"] for entry in simulation.history]) / supplied
        assert internal.max() > 0.1
        assert np.abs(error).max() < tolerance
        lost = simulation.frame.energies["damping_loss"] / supplied
        assert (lost > 0.05) if in_plane else (lost == 0.0)


def test_noise_keeps_its_energy(fabric):
    """Random velocities excite the highest modes, for which the step is almost too large; it must not follow them."""
    laws = fabric(
        unit_cell=LinearMembrane(warp_stiffness=1e5, weft_stiffness=1e5), shear=LinearShear(modulus=1e6),
        stabilisation=Stabilisation(),
    )  # fmt: skip
    blank = Blank.rectangle((0.0, 0.0), (0.04, 0.04), 0.01)
    velocity = np.zeros((blank.node_count, 3))
    velocity[:, :2] = np.random.default_rng(0).normal(scale=0.1, size=(blank.node_count, 2))
    simulation = one_sheet_run(
        name="noise", blank=blank, fabric=laws, duration=1.0, initial_velocity=velocity, precision="float64",
        lane_count=1, threads=1,
    )  # fmt: skip
    start = simulation.frame.energies
    for _ in range(5):
        simulation.stepper.advance(100)
        energies = simulation.ledger.frame(1).energies
        # the step is as large as it may be, but for the margins of a step that is kept
        assert 0.9 < simulation.state.step / simulation.stepper.stable_step() <= 1.0
        total, first = (e["kinetic"] + e["internal"] for e in (energies, start))
        assert total == pytest.approx(first, rel=1e-3)
    assert simulation.stepper.step_count == 10_000


def test_momentum_is_kept_with_a_changing_step(frames):
    """A locking curve makes the stable step shrink and grow during the run."""
    curve = MomentCurve(
        angle=(0.0, 0.5), moment_values=(0.0, 2000.0), locking_angle=0.01, locking_width=0.02, locking_stiffness=6.0e5
    )
    fabric = glass_polypropylene().model_copy(update={"shear": curve})
    # it locks at half a degree
    simulation = thrown_sheet(fabric, 4e-4, accept_unusual=True)
    momentum, angular = momenta(simulation)
    steps = set()
    frames.frame = lambda frame: steps.add(simulation.state.step)
    simulation.run([frames])
    assert len(steps) > 3
    later, angular_later = momenta(simulation)
    assert np.abs(later - momentum).max() < 1e-12 * np.abs(momentum).max()
    assert np.abs(angular_later - angular).max() < 1e-10 * np.abs(angular).max()


def falling_sheet(distortion: float = 0.1, **given) -> Simulation:
    """A sheet pressed between a ball and a plane, with friction: contact, wrinkles, moving tool.

    Without ``distortion`` its kernels are those of many tests, also in lanes, which take longest to compile.
    """
    blank = Blank.rectangle((-0.03, -0.03), (0.03, 0.03), 0.005, yarn_angle=30.0, distortion=distortion)
    fabric = given.pop("fabric", None) or glass_polypropylene()
    half = 0.5 * fabric.thickness
    tools = (
        Tool("plane", Plane(origin=(0.0, 0.0, -half - 0.004)), friction=0.3),
        Tool("ball", Sphere(radius=0.02, origin=(0.003, 0.0, 0.02 + half)), Stroke((0.0, 1e-3), (0.0, -0.006))),
    )
    settings = {"frame_count": 5, "duration": 5e-4, "accept_unusual": True}  # tools close too far, which stresses more
    return one_sheet_run(name="falling", blank=blank, fabric=fabric, tools=tools, **(settings | given))


def loaded_shell(**given) -> Simulation:
    """A curved sheet between tools of several rotated parts and of triangles, pulled and turned at its nodes."""
    flat = Blank.rectangle((-0.03, -0.03), (0.03, 0.03), 0.005, yarn_angle=30.0, distortion=0.1)
    x, y, _ = flat.node_position.T
    blank = Blank.from_mesh(np.column_stack([x, y, 3.0 * x**2 - 2.0 * x * y]), flat.quads, yarn_angle=30.0)
    fabric, turn = glass_polypropylene(), rotation_matrix((0.0, 1.0, 0.2), 0.3)
    punch = Union(
        (Sphere(radius=0.02), Capsule(radius=0.015, half_length=0.02)), origin=(0.0, 0.0, 0.023), rotation=turn
    )
    plate = trimesh.creation.box((0.1, 0.1, 0.02))
    die = MeshShape.from_triangles(
        plate.vertices, plate.faces, spacing=2e-3, origin=(0.0, 0.0, -0.0109 - fabric.thickness)
    )
    tools = (Tool("punch", punch, Stroke((0.0, 1e-3), (0.0, -0.008))), Tool("die", die, friction=0.3))
    force = 0.02 * np.column_stack([x, y, np.zeros_like(x)]) / 0.03
    loads = NodalLoads(force=force, couple=1e-4 * force[:, ::-1], times=(0.0, 3e-4), shares=(0.0, 1.0))
    settings = {"frame_count": 5, "duration": 5e-4, "accept_unusual": True}  # tools close too far, which stresses more
    return one_sheet_run(name="shell", blank=blank, fabric=fabric, tools=tools, loads=loads, **(settings | given))


def snapshot(simulation: Simulation) -> dict[str, np.ndarray]:
    return {name: array.numpy().copy() for name, array in simulation.state.arrays()}


def rubbing(fabric: Fabric) -> Fabric:
    """The fabric with friction in shear, raised by tension, and in bending."""
    curve = BendingCurve.from_kawabata(rigidity=3e-3, hysteresis=5e-3, slip_curvature=2.0)
    return fabric.model_copy(
        update={
            "shear_friction": ShearFriction(stiffness=300.0, limit=(0.5,), crossover_friction_length=1e-4),
            "bending": YarnBending(warp=curve, weft=curve, twist=1e-3),
        }
    )


FRAMED = {
    "plain weave": (glass_polypropylene, "initial"),
    "friction inside, current thickness": (lambda: rubbing(glass_polypropylene()), "current"),
    "twill": (lambda: assumed_fabric("twill"), "initial"),
    "twill, friction inside": (lambda: rubbing(assumed_fabric("twill")), "initial"),
}


def framed_sheet(name: str, **given) -> Simulation:
    make, contact_thickness = FRAMED[name]
    return falling_sheet(fabric=make(), dynamics=Dynamics(contact_thickness=contact_thickness), **given)


# With the tools that the sheet touches in the end.
SHARED_OUT = {
    "plain weave": (partial(framed_sheet, "plain weave", distortion=0.0), 1),
    "friction inside, current thickness": (
        partial(framed_sheet, "friction inside, current thickness", distortion=0.0), 1,
    ),
    "curved, loaded, mesh and rotated parts as tools": (loaded_shell, 2),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("name", SHARED_OUT)
def test_same_bits_for_any_number_of_threads_and_any_run(name):
    make, touched_count = SHARED_OUT[name]
    results = []
    for threads in (1, 2, 3, 1):
        simulation = make(threads=threads, precision="float32")
        simulation.run()
        assert simulation.model.lane_count == CPU_LANE_COUNT
        assert simulation.stepper.step_count >= 200
        assert (np.abs(simulation.frame.tool_reaction).max(axis=1) > 1.0).sum() >= touched_count
        results.append(snapshot(simulation) | {"tool_reaction": simulation.frame.tool_reaction})
    for other in results[1:]:
        for array, value in results[0].items():
            assert np.isfinite(value).all() and np.array_equal(value, other[array]), array


@pytest.mark.slow
@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_passing_over_far_tools_changes_nothing(precision):
    """A node skipped by the bound of its gap would not have touched a tool: the same bits as if all are checked."""
    results = []
    for spare_distance in (None, np.inf):
        simulation = falling_sheet(0.0, threads=1, precision=precision)
        if spare_distance is not None:
            for laws in simulation.stepper._launches.node_laws:
                laws.spare_distance = spare_distance
        passed_over = []
        for _ in range(25):
            simulation.stepper.advance(1)
            passed_over.append((simulation.state.sheet.gap.numpy() > 0.0).mean())
        results.append(snapshot(simulation) | {"tool_reaction": simulation.take_frame().tool_reaction})
        assert max(passed_over) == 0.0 if spare_distance else max(passed_over) > 0.8 and min(passed_over) < 0.8
    assert np.abs(results[0]["tool_reaction"]).max() > 1.0
    assert "sheets/0/gap" in results[0]  # the bound itself, the only array that may differ
    for name in results[0].keys() - {"sheets/0/gap"}:
        assert np.array_equal(results[0][name], results[1][name]), name


@pytest.mark.parametrize("name", FRAMED)
def test_taking_frames_changes_nothing(name):
    make, contact_thickness = FRAMED[name]
    dynamics = Dynamics(contact_thickness=contact_thickness)
    one, many = (
        falling_sheet(frame_count=count, fabric=make(), dynamics=dynamics, threads=1, lane_count=1) for count in (1, 12)
    )
    step_counts = set()
    for simulation in (one, many):
        while simulation.stepper.step_count < 240:
            simulation.stepper.advance(1)
            if simulation is many:
                simulation.ledger.frame(1)
        step_counts.add(simulation.stepper.step_count)
    assert len(step_counts) == 1
    snapshots = [snapshot(simulation) for simulation in (one, many)]
    assert {"clock", "sheets/0/motion", "sheets/0/friction", "sheets/0/slip"} <= set(snapshots[0])
    for array, values in snapshots[0].items():
        assert np.array_equal(values, snapshots[1][array]), array


@pytest.mark.parametrize(("precision", "tolerance"), [("float32", 2e-4), ("float64", 1e-11)])
def test_lanes_give_the_same_to_round_off(precision, tolerance, sheet, curved_blank, deformed):
    forces = [
        sheet(curved_blank, glass_polypropylene(), precision=precision, lane_count=lane_count).forces(*deformed)
        for lane_count in (1, 16)
    ]
    for plain, lanes in zip(*forces, strict=True):
        assert np.abs(plain - lanes).max() <= tolerance * np.abs(plain).max()


@pytest.mark.parametrize(("precision", "tolerance"), [("float32", 2e-7), ("float64", 1e-13)])
def test_lanes_stay_together_over_a_hundred_steps(precision, tolerance):
    """The travel of the nodes is about a millimetre; the difference is in metres."""
    positions = []
    for lane_count in (1, 16):
        simulation = falling_sheet(0.0, precision=precision, lane_count=lane_count, threads=1)
        simulation.stepper.advance(5)
        positions.append(simulation.ledger.frame(1).position)
    way = np.abs(positions[0] - simulation.setup.sheet.blank.node_position).max()
    assert way > 1e-4
    assert np.abs(positions[0] - positions[1]).max() < tolerance


def test_gravity_alone_is_free_fall():
    blank = Blank.rectangle((0.0, 0.0), (0.02, 0.02), 0.005)
    simulation = one_sheet_run(
        name="fall", blank=blank, fabric=glass_polypropylene(), duration=1e-3, precision="float64", lane_count=1,
        threads=1, frame_count=1, dynamics=Dynamics(gravity=(0.0, 3.0, -9.81)),
    )  # fmt: skip
    simulation.run()
    time = simulation.frame.time
    moved = simulation.frame.position - blank.node_position
    assert np.abs(moved - 0.5 * time**2 * np.array([0.0, 3.0, -9.81])).max() < 1e-4 * 0.5 * 9.81 * time**2
    assert simulation.frame.energies["internal"] < 1e-15


@pytest.mark.parametrize(("precision", "speed"), [("float32", 1e30), ("float64", 1e100)])
def test_run_that_becomes_non_finite_stops_and_keeps_its_frames(precision, speed, frames, monkeypatch):
    """An absurd velocity: no frame with a NaN is published, and the message names an element."""
    monkeypatch.setitem(QUANTITIES, "speed", QUANTITIES["speed"]._replace(legal=(0.0, 1e101)))
    blank = Blank.rectangle((-0.02, -0.02), (0.02, 0.02), 0.005)
    velocity = np.zeros_like(blank.node_position)
    velocity[12] = (0.0, 0.0, speed)
    simulation = one_sheet_run(
        name="absurd", blank=blank, fabric=glass_polypropylene(), duration=1e-2, initial_velocity=velocity,
        precision=precision, lane_count=1, threads=1, accept_unusual=True,
    )  # fmt: skip
    with pytest.raises(RunError, match=r"non-finite after \d+ steps.*last good frame is 0.*Element \d+, at") as raised:
        simulation.run([frames])
    element = int(re.search(r"Element (\d+)", str(raised.value)).group(1))
    assert 0 <= element < blank.element_count
    assert frames.outcome is Outcome.NOT_FINITE
    assert len(frames.all) >= 1
    assert all(np.isfinite(frame.position).all() for frame in frames.all)
    assert simulation.frame is frames.all[-1]
