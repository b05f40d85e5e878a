"""Stages are the same run as a script of its parts; what is elastic springs back to where it was."""

import numpy as np
import pytest

from tests.support.bent_strips import bent_strip
from weavesim.engine.model import Model
from weavesim.engine.setup import Setup, Solver
from weavesim.engine.stepper import Stepper
from weavesim.fabric.bending import IsotropicBending
from weavesim.fabric.cell import LinearMembrane
from weavesim.fabric.presets import glass_polypropylene
from weavesim.kernels.rows import ToolDriveRow
from weavesim.process.dynamics import Dynamics
from weavesim.process.loads import NodalLoads
from weavesim.process.stages import AtRest, SheetLoads, Stage
from weavesim.process.strokes import Fixed, Stroke
from weavesim.process.supports import Support
from weavesim.run.simulation import Simulation
from weavesim.sheet.blank import Blank
from weavesim.sheet.sheet import Sheet
from weavesim.tools import Sphere
from weavesim.tools.tool import Tool

PART = 1.0e-3
UP, BACK = Stroke((0.0, PART), (0.0, 5.0e-4)), Stroke((0.0, PART), (0.0, -2.0e-4))
GRAVITY, SIDEWAYS = (0.0, 0.0, -9.81), (0.0, 3.0, -9.81)


def lifted(motion, gravity, damping, **given):
    """A held strip that a ball lifts."""
    fabric = glass_polypropylene()
    blank = Blank.rectangle((0.0, 0.0), (0.08, 0.04), 0.01)
    held = Support("held", np.flatnonzero(blank.node_position[:, 0] < 1e-9))
    ball = Sphere(0.02, origin=(0.05, 0.02, -0.02 - 0.5 * fabric.thickness))
    return Setup(
        "lifted", sheets=[Sheet(blank, fabric, supports=[held])], tools=[Tool("ball", ball, motion, friction=0.2)],
        dynamics=Dynamics(gravity=gravity, damping=damping), solver=Solver(threads=1), frame_count=6, **given,
    )  # fmt: skip


def bits(state):
    return {name: array.numpy().tobytes() for name, array in state.arrays()}


def test_three_stages_are_a_script_of_three_parts(manual):
    stages = (
        Stage("up", PART),
        Stage("back", PART, moves={"ball": BACK}, damping=200.0),
        Stage("still", PART, moves={"ball": Fixed()}, gravity=SIDEWAYS),
    )
    staged = Simulation(lifted(UP, GRAVITY, 10.0, stages=stages))
    staged.run()

    script = Simulation(lifted(UP, GRAVITY, 10.0, duration=PART))
    script.run()
    state = script.state
    for number, (gravity, damping) in enumerate(((GRAVITY, 200.0), (SIDEWAYS, 200.0)), start=2):
        time, place = state.time, float(state.tool_displacement.numpy()[0])
        motion = Stroke((time, time + PART), (place, place - 2.0e-4)) if number == 2 else Stroke((time,), (place,))
        drive = state.tool_drive.numpy()
        drive[ToolDriveRow.stroke_time], drive[ToolDriveRow.carrying] = time, 0.0
        state.tool_drive.assign(drive)
        Stepper(Model(lifted(motion, gravity, damping, duration=PART)), state).advance_to(number * PART)
    found, wanted = bits(staged.state), bits(state)
    different = [name for name, content in found.items() if content != wanted[name]]
    assert not different and found.keys() == wanted.keys()
    assert np.abs(staged.frame.position[:, 2]).max() > 1e-4
    case = manual(
        "Process", "Three stages and a script of three parts",
        known="A ball lifts a strip, goes back under more damping, and stands still while gravity turns: in three "
        "stages, and in a script that makes a set-up of each part on the state of the part before.",
    )  # fmt: skip
    case.table(
        ["", "expected", "got"],
        [["arrays of the state that differ in any bit", "0", f"{len(different)} of {len(found)}"],
         ["steps", f"{state.step_count}", f"{staged.state.step_count}"]],
    )  # fmt: skip


RIGIDITY, MOMENT = 2.0e-3, 2.0e-2
LENGTH, WIDTH, COUNT = 0.05, 0.01, 10


def test_an_elastic_strip_is_straight_again(fabric, manual):
    """Bent by a couple in one stage, and left alone in the next."""
    thickness = 5.0e-4
    strip = fabric(
        areal_density=0.5, thickness=thickness,
        unit_cell=LinearMembrane(warp_stiffness=2.0e4, weft_stiffness=2.0e4),
        bending=IsotropicBending(modulus=12.0 * RIGIDITY / thickness**3), transverse_shear_modulus=1.0e6,
    )  # fmt: skip
    blank, free, couple = bent_strip(LENGTH, WIDTH, COUNT, MOMENT)
    x = blank.node_position[:, 0]
    s = np.linspace(0.0, 1.0, 21)
    ramp = NodalLoads(None, couple, tuple(0.2 * s), tuple(s * s * (3.0 - 2.0 * s)))
    stages = (Stage("bend", 0.3, loads=[SheetLoads(ramp)]), Stage("release", 1.0, AtRest(1e-6, 1e-4), loads=[]))
    simulation = Simulation(Setup(
        "elastic", sheets=[Sheet(blank, strip, free=free)], stages=stages, frame_count=20,
        dynamics=Dynamics(damping=100.0, director_damping=100.0),
        solver=Solver(precision="float64", lane_count=1, threads=1),
    ))  # fmt: skip
    simulation.run()

    def curvature(frame):
        row = np.flatnonzero(blank.node_position[:, 1] < 1e-9)
        row = row[np.argsort(x[row])]
        turn = np.unwrap(np.arctan2(frame.director[row, 0], frame.director[row, 2]))
        return np.abs(np.diff(turn)) * COUNT / LENGTH

    held, last = simulation.stages.frames["bend"], simulation.frame
    bent, left = curvature(held), curvature(last)
    stored, wanted = held.energies["bending"], 0.5 * MOMENT**2 / RIGIDITY * LENGTH * WIDTH
    assert bent == pytest.approx(np.full(COUNT, MOMENT / RIGIDITY), rel=0.01)
    assert left.max() < 0.01 * MOMENT / RIGIDITY
    assert simulation.stages.ended[-1]["ended_by"] == "rest"
    assert stored == pytest.approx(wanted, rel=0.02)
    damped = last.energies["damping_loss"] - held.energies["damping_loss"]
    assert damped == pytest.approx(held.energies["internal"], rel=0.02)
    assert abs(last.energies["balance_error"]) < 0.01 * last.energies["load_work"]
    case = manual(
        "Process", "Springback of an elastic strip",
        known="A strip with M = B kappa, B = 2 mN m, is bent by M = 20 mN to 10 1/m in one stage; in the next no load "
        "acts, and it is straight again at rest: what it stored, M^2 L W / (2 B), is damped.",
    )  # fmt: skip
    case.table(
        ["", "expected", "got"],
        [["bent [1/m]", f"{MOMENT / RIGIDITY:.4g}", f"{bent.min():.4g} to {bent.max():.4g}"],
         ["stored [µJ]", f"{1e6 * wanted:.4g}", f"{1e6 * stored:.4g}"],
         ["released [1/m]", "0", f"at most {left.max():.2g}"],
         ["damped, of all that was stored", "1", f"{damped / held.energies['internal']:.4g}"]],
    )  # fmt: skip
