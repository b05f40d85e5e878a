"""Tools that follow a path and turn, with known answers: drums, a flap, and dies that are turned with the sheet."""

import math

import numpy as np
import pytest

from tests.support.capstan import FORCE, RADIUS, THICKNESS, TIGHTENING, strip
from weavesim import Dynamics, Setup, Sheet, Simulation, Solver, Support, Tool
from weavesim.fabric.bending import IsotropicBending
from weavesim.fabric.cell import LinearMembrane
from weavesim.fabric.fabric import Stabilisation
from weavesim.fabric.shear import LinearShear
from weavesim.process.motions.paths import PathMotion, Rotation
from weavesim.process.strokes import ForceDriven, Stroke
from weavesim.sheet.blank import Blank
from weavesim.tools.shapes import Capsule, Plane, Union, rotation_matrix

SOLVER = Solver(precision="float64", lane_count=1, threads=1)
FRICTION = 0.25
Y = (0.0, 1.0, 0.0)


def cloth(fabric, modulus=1.0e4):
    return fabric(
        areal_density=0.5, thickness=THICKNESS, unit_cell=LinearMembrane(warp_stiffness=2.0e4, weft_stiffness=2.0e4),
        bending=IsotropicBending(modulus=modulus), transverse_shear_modulus=1.0e5 if modulus < 1e6 else 1.0e7,
        shear=LinearShear(modulus=4.0e6), stabilisation=Stabilisation(),
    )  # fmt: skip


def balance(energies) -> float:
    return abs(energies["balance_error"]) / energies["tool_work"]


@pytest.mark.parametrize("degrees", [90, 180])
def test_a_drum_turns_under_a_belt(degrees, fabric, frames, manual):
    """Its torque is what the tensions of the belt leave, which differ by exp(mu theta)."""
    turn = math.radians(degrees)
    belt = strip(cloth(fabric), turn)
    belt = belt.model_copy(update={"supports": (Support("hold", belt.supports[0].nodes),)})
    spin = Rotation.smooth((1.0, 0.0, 0.0), (0.0, 0.0, 0.0), 40.0, 4.0, 0.02, start_time=2.0 * TIGHTENING)
    drum = Tool("drum", Capsule(RADIUS, 0.1), PathMotion(rotation=spin), friction=FRICTION)
    setup = Setup(
        "drum", sheets=(belt,), tools=(drum,), dynamics=Dynamics(damping=20.0), duration=0.2, frame_count=80,
        solver=SOLVER,
    )  # fmt: skip
    simulation = Simulation(setup)
    simulation.run([frames])
    sliding = [frame for frame in frames.all if 0.1 < frame.time < 0.19]
    held = float(np.mean([frame.support_force[0, 1] for frame in sliding]))
    torque = -float(np.mean([frame.tool_moment[0, 0] for frame in sliding]))
    ratio, expected = held / FORCE, math.exp(FRICTION * turn)
    arm = RADIUS + 0.5 * THICKNESS
    expected_torque = FORCE * (expected - 1.0) * arm
    energies = simulation.frame.energies
    assert ratio == pytest.approx(expected, rel=0.005)
    assert torque == pytest.approx(expected_torque, rel=0.01)
    assert balance(energies) < 1.0e-3
    # all of the work is friction, but for what the belt's spring gained
    assert energies["friction_loss"] == pytest.approx(energies["tool_work"], rel=0.01)
    case = manual(
        "Process", f"A drum that turns under a belt, {degrees} degrees",
        known="One end of the belt is held, a dead load pulls at the other, and the drum turns towards it at 4 rad/s: "
        "the tension grows by exp(mu theta), with mu = 0.25, and the torque is the difference of tensions times the "
        "radius of the belt's middle, 20.25 mm. Elements of 2 mm.",
    )  # fmt: skip
    case.table(
        ["ratio of tensions, expected", "got", "torque, expected [N mm]", "got", "balance error / work"],
        [[f"{expected:.5g}", f"{ratio:.5g}", f"{1e3 * expected_torque:.4g}", f"{1e3 * torque:.4g}",
          f"{balance(energies):.1e}"]],
    )  # fmt: skip


SPEED, LOAD = 0.05, 0.1


def rolled(fabric, frames, share: float):
    """Mean force along x of a drum under a load that runs over a sheet, and turns at a ``share`` of rolling [N]."""
    half = 0.5 * THICKNESS
    blank = Blank.rectangle((0.0, 0.0), (0.02, 0.002), 0.001)
    every = np.arange(blank.node_count)
    sheet = Sheet(blank, cloth(fabric), supports=(Support("table", every, displacements="xy", rotations=""),))
    time, way = 0.24, SPEED * 0.24
    centre = (0.004, 0.001, RADIUS + half)
    angle = math.degrees(share * way / (RADIUS + half))
    path = PathMotion(
        (0.0, time), ((0.0, 0.0, 0.0), (way, 0.0, 0.0)), Rotation(Y, centre, (0.0, time), (0.0, angle), at_rest=False),
        ForceDriven.constant(LOAD, 0.01, 0.03, in_touch=True), at_rest=False,
    )  # fmt: skip
    along_y = rotation_matrix((0.0, 0.0, 1.0), 0.5 * math.pi)
    tools = (
        Tool("table", Plane(origin=(0.0, 0.0, -half)), friction=0.0),
        Tool("drum", Capsule(RADIUS, 0.02, origin=centre, rotation=along_y), path, FRICTION, axis=(0.0, 0.0, -1.0)),
    )
    setup = Setup("rolled", sheets=(sheet,), tools=tools, duration=time, frame_count=100, solver=SOLVER)
    simulation = Simulation(setup)
    simulation.run([frames])
    late = [frame for frame in frames.all if frame.time > 0.05]
    assert np.mean([frame.tool_reaction[1, 2] for frame in late]) == pytest.approx(LOAD, rel=0.01)
    pose = frames.all[-1].place(1)
    # the axis of the drum has gone all the way, whatever the drum turned by
    moved = pose.moved(np.array([centre]))[0] - np.array(centre)
    np.testing.assert_allclose(moved[:2], [way, 0.0], atol=1e-6)
    return float(np.mean([frame.tool_reaction[1, 0] for frame in late])), simulation.frame.energies


def test_a_drum_that_rolls_does_not_rub(fabric, frames, manual):
    """The friction of a turning tool takes the velocity of its surface: none where it rolls, both ways beside that."""
    rows = []
    for label, share, expected in (("slides", 0.0, -1.0), ("rolls", 1.0, 0.0), ("spins", 2.0, 1.0)):
        force, energies = rolled(fabric, frames, share)
        # a drum that rolls climbs over each line of nodes, and loses what it falls behind it
        assert force / (FRICTION * LOAD) == pytest.approx(expected, abs=0.12 if share == 1.0 else 0.02)
        supplied = energies["tool_work"] + energies["driving_force_work"]
        error = abs(energies["balance_error"]) / max(supplied, 1e-3 * LOAD * SPEED)
        assert error < 1.0e-3
        rows.append([label, f"{expected:.0f}", f"{force / (FRICTION * LOAD):.4f}", f"{error:.1e}"])
    case = manual(
        "Process", "A drum that slides, rolls, and spins",
        known="A drum under 0.1 N runs over a held sheet at 50 mm/s and turns at none, all and twice of the rate at "
        "which it rolls: the force of friction on it is -1, 0, 1 times mu N. A drum that rolls climbs over each line "
        "of nodes, 1 mm apart, and loses what it falls behind it.",
    )  # fmt: skip
    case.table(["drum", "force / (mu N), expected", "got", "balance error / work"], rows)


FREE, LENGTH, MODULUS = 0.02, 0.04, 1.0e9


def test_a_flap_lifts_a_strip(fabric, frames, manual):
    """The moment about its hinge is that of a cantilever at 5 degrees, and its work is what the strip stores."""
    half, width = 0.5 * THICKNESS, 0.005
    blank = Blank.rectangle((-0.03, 0.0), (FREE, width), 0.0025)
    held = np.flatnonzero(blank.node_position[:, 0] < FREE - LENGTH + 1e-9)
    own = cloth(fabric, MODULUS)
    turn = Rotation(Y, (0.0, 0.0, -half), (0.0, 0.15, 0.3, 0.5), (0.0, -5.0, -5.0, -40.0))
    flap = Tool("flap", Plane(origin=(0.0, 0.0, -half)), PathMotion(rotation=turn), friction=0.0)
    setup = Setup(
        "flap", sheets=(Sheet(blank, own, supports=(Support("clamp", held),)),), tools=(flap,),
        dynamics=Dynamics(damping=200.0), duration=0.5, frame_count=250, solver=SOLVER,
    )  # fmt: skip
    simulation = Simulation(setup)
    simulation.run([frames])
    stiffness = MODULUS * THICKNESS**3 / 12.0 * width
    angle = math.radians(5.0)
    expected = 3.0 * stiffness * FREE * math.tan(angle) * FREE / LENGTH**3
    resting = [frame for frame in frames.all if 0.25 < frame.time < 0.3]
    moment = float(np.mean([frame.tool_moment[0, 1] for frame in resting]))
    energies = simulation.frame.energies
    # angles about -y lift the strip; the sheet resists with a moment about +y
    angles = np.array([math.atan2(frame.tool_pose[0, 6], frame.tool_pose[0, 0]) for frame in frames.all])
    moments = np.array([frame.tool_moment[0, 1] for frame in frames.all])
    work = float(np.sum(0.5 * (moments[1:] + moments[:-1]) * np.diff(angles)))
    assert moment == pytest.approx(expected, rel=0.02)
    assert math.degrees(angles[-1]) == pytest.approx(40.0)
    assert work == pytest.approx(energies["tool_work"], rel=2.0e-3)
    assert balance(energies) < 1.0e-3
    case = manual(
        "Process", "A flap that lifts a strip",
        known="A strip that is clamped 20 mm behind the hinge of a flap, and reaches 20 mm over it, touches the flap "
        "with its tip: the moment about the hinge is 3 E I w a / L^3 with w = a tan(5 degrees), a = 20 mm, L = 40 mm. "
        "Then the flap goes on to 40 degrees; the moment over the angle, from the frames, is the work in the ledger.",
    )  # fmt: skip
    case.table(
        ["moment at 5 degrees [N mm]", "got", "moment over angle [mJ]", "in the ledger", "balance error / work"],
        [[f"{1e3 * expected:.4g}", f"{1e3 * moment:.4g}", f"{1e3 * work:.4g}", f"{1e3 * energies['tool_work']:.4g}",
          f"{balance(energies):.1e}"]],
    )  # fmt: skip


ACROSS = math.radians(30.0)


def bent(fabric, angle_of_sheet: float, angle_of_tools: float, moved_by):
    """A sheet between two rods below and one above that comes down; both turned in their plane."""
    half = 0.5 * THICKNESS
    turn = rotation_matrix((0.0, 0.0, 1.0), angle_of_sheet)
    flat = Blank.rectangle((-0.03, -0.012), (0.03, 0.012), 0.004)
    blank = Blank.from_mesh(
        flat.node_position @ np.array(turn).T, flat.quads,
        warp_direction=np.tile(np.array(turn)[:, 0], (flat.element_count, 1)),
        material_coordinates=flat.material_coordinates,
    )  # fmt: skip
    along_y = rotation_matrix((0.0, 0.0, 1.0), 0.5 * math.pi)
    rod = {"radius": 0.006, "half_length": 0.03, "rotation": along_y}
    low, high = -0.006 - half, 0.006 + half
    die = Union((Capsule(**rod, origin=(-0.018, 0.0, low)), Capsule(**rod, origin=(0.018, 0.0, low))))
    rotation = None
    if angle_of_tools:
        rotation = Rotation((0.0, 0.0, 1.0), (0.0, 0.0, 0.0), (0.0,), (math.degrees(angle_of_tools),))
    tools = (
        Tool("die", die, PathMotion(rotation=rotation) if rotation else moved_by(0.0, None), 0.2),
        Tool("punch", Capsule(**rod, origin=(0.0, 0.0, high)), moved_by(0.004, rotation), 0.2, axis=(0.0, 0.0, -1.0)),
    )
    setup = Setup(
        "bent", sheets=(Sheet(blank, cloth(fabric, MODULUS)),), tools=tools, duration=0.06, frame_count=1,
        dynamics=Dynamics(damping=50.0), solver=SOLVER,
    )  # fmt: skip
    simulation = Simulation(setup)
    simulation.run()
    return simulation.frame, np.array(turn)


def by_stroke(way, rotation):
    stroke = Stroke((0.0, 0.06), (0.0, way))
    return PathMotion(rotation=rotation, along=stroke) if rotation else stroke


def by_path(way, rotation):
    return PathMotion((0.0, 0.06), ((0.0, 0.0, 0.0), (0.0, 0.0, -way)), rotation, at_rest=False)


def test_dies_that_are_turned_form_what_turned_sheets_become(fabric, manual):
    """Rods turned by 30 degrees under a sheet, against a sheet turned by -30 degrees; by strokes, and by paths."""
    turned_sheet, turn = bent(fabric, -ACROSS, 0.0, by_stroke)
    expected = turned_sheet.position @ turn
    rows = []
    for label, moved_by in (("stroke", by_stroke), ("path", by_path)):
        frame, _ = bent(fabric, 0.0, ACROSS, moved_by)
        error = float(np.abs(frame.position - expected).max())
        force = float(frame.tool_reaction[1, 2] / turned_sheet.tool_reaction[1, 2] - 1.0)
        assert frame.tool_reaction[1, 2] > 0.1
        assert error < 1e-9 and abs(force) < 1e-6
        # within the plane, what turns the rods back is what the sheet feels
        np.testing.assert_allclose(turn @ frame.tool_reaction[0], turned_sheet.tool_reaction[0], atol=1e-6)
        rows.append([label, f"{1e3 * error:.1e}", f"{force:.1e}"])
    case = manual(
        "Process", "Dies that are turned",
        known="Three-point bending by rods turned by 30 degrees in the plane of the sheet, as poses, is that of a "
        "sheet turned by -30 degrees, in double precision; the punch comes down by a stroke along its axis, or a path.",
    )  # fmt: skip
    case.table(
        ["punch comes down by", "largest difference of positions [mm]", "relative difference of its force"], rows
    )
