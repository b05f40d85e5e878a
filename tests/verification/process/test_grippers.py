"""Springs and grippers, with known answers."""

import numpy as np
import pytest

from tests.support.runs import one_sheet_run
from weavesim.engine.setup import Setup, Solver
from weavesim.fabric.bending import IsotropicBending
from weavesim.fabric.cell import LinearMembrane
from weavesim.process.dynamics import Dynamics
from weavesim.process.grippers import Gripper
from weavesim.process.motions.paths import PathMotion
from weavesim.process.stages import Stage
from weavesim.process.strokes import Stroke
from weavesim.process.supports import Support
from weavesim.run.frame import Frame
from weavesim.run.simulation import Simulation
from weavesim.sheet.blank import Blank
from weavesim.sheet.sheet import Sheet

STIFFNESS, LENGTH, WIDTH = 2.0e4, 0.1, 0.02
SPRING, LIMIT, TRAVEL = 5.0e3, 6.0, 5.0e-3
# the strip is a spring in series
SERIES = 1.0 / (1.0 / SPRING + LENGTH / (STIFFNESS * WIDTH))


@pytest.fixture
def strip(fabric):
    """A strip along the warp whose other yarns do not matter."""
    return fabric(
        areal_density=0.5, thickness=1.0e-3, bending=IsotropicBending(modulus=1.0e7), transverse_shear_modulus=1.0e6,
        unit_cell=LinearMembrane(warp_stiffness=STIFFNESS, weft_stiffness=STIFFNESS),
    )  # fmt: skip


def pulled(strip, frames, duration, **given):
    """A strip that is held at its left end and gripped at its right one; frames and the simulation."""
    blank = Blank.rectangle((0.0, 0.0), (LENGTH, WIDTH), 0.01)
    x = blank.node_position[:, 0]
    free = np.ones((blank.node_count, 6), dtype=bool)
    free[x < 1e-9, :3] = False
    gripper = Gripper("jaw", np.flatnonzero(x > LENGTH - 1e-9), (1.0, 0.0, 0.0), SPRING, **given)
    simulation = one_sheet_run(
        name="gripped", blank=blank, fabric=strip, free=free, grippers=(gripper,), duration=duration, frame_count=100,
        dynamics=Dynamics(damping=500.0), precision="float64", lane_count=1, threads=1,
    )  # fmt: skip
    simulation.run([frames])
    return simulation


def of(frames: list[Frame], name: str) -> np.ndarray:
    return np.array([getattr(frame, name)[0] for frame in frames])


def test_force_and_slip_of_a_strip_are_those_of_paper_and_pencil(strip, frames, manual):
    """Out, beyond the limit, and back until it is slack."""
    motion = Stroke((0.0, 0.2, 0.4), (0.0, TRAVEL, 0.0))
    simulation = pulled(strip, frames, 0.4, largest_force=LIMIT, motion=motion)
    time = np.array([frame.time for frame in frames.all])
    travel = np.interp(time, *motion.curve())
    slip = np.where(time <= 0.2, np.maximum(travel - LIMIT / SERIES, 0.0), TRAVEL - LIMIT / SERIES)
    expected = np.clip(SERIES * (travel - slip), 0.0, LIMIT)
    force, found = of(frames.all, "gripper_force"), of(frames.all, "gripper_slip")
    assert slip[-1] == pytest.approx(2.3e-3) and expected[-1] == 0.0
    np.testing.assert_allclose(force, expected, atol=0.01 * LIMIT)
    np.testing.assert_allclose(found, slip, atol=0.01 * TRAVEL)
    assert force.max() <= LIMIT * (1.0 + 1e-12)
    yarns = frames.all[50].fields["warp_force"].mean() * WIDTH
    assert yarns == pytest.approx(expected[50], rel=0.01)
    energies = simulation.frame.energies
    assert energies["gripper_loss"] == pytest.approx(LIMIT * slip[-1], rel=0.01)
    assert abs(energies["balance_error"]) < 1e-3 * energies["gripper_work"]
    case = manual(
        "Process", "A strip in a gripper that slips",
        known="A strip of K = 20 kN/m, 100 x 20 mm, is pulled by a spring of 5 N/mm over 5 mm and let back; from 6 N "
        "on the gripper slips. Strip and spring are in series: 2.222 N/mm up to 6 N, then 2.3 mm of slip, and back.",
    )  # fmt: skip
    rows = [
        [f"{1e3 * travel[k]:.3g}", "out" if time[k] <= 0.2 else "back", f"{expected[k]:.4g}", f"{force[k]:.4g}",
         f"{1e3 * slip[k]:.4g}", f"{1e3 * found[k]:.4g}"]
        for k in (20, 35, 50, 60, 70, 90)
    ]  # fmt: skip
    case.table(["travel [mm]", "", "force [N]", "got [N]", "slip [mm]", "got [mm]"], rows)
    case.table(["balance error over the work"], [[f"{energies['balance_error'] / energies['gripper_work']:.1e}"]])


def test_a_pretension_is_shared_and_a_gripper_lets_go(strip, frames):
    simulation = pulled(strip, frames, 0.2, pretension=LIMIT, ramp_time=0.05, release_time=0.15)
    force, time = of(frames.all, "gripper_force"), np.array([frame.time for frame in frames.all])
    # the strip gives way by what it stretches
    held = LIMIT * SERIES / SPRING
    assert force[(time > 0.1) & (time < 0.15)] == pytest.approx(held, rel=0.01)
    assert np.abs(force[time > 0.151]).max() == 0.0
    energies = simulation.frame.energies
    assert energies["gripper_loss"] == pytest.approx(0.5 * held**2 / SPRING, rel=0.02)
    assert energies["gripper_spring"] == 0.0
    assert abs(energies["balance_error"]) < 1e-3 * energies["gripper_work"]
    assert np.abs(simulation.frame.fields["warp_force"]).max() * WIDTH < 0.02 * held


def test_a_stiff_spring_is_part_of_the_stable_step(strip, frames):
    """A hundred times as stiff as the strip, the sheet stays stable, at a smaller step."""
    soft = pulled(strip, frames, 6e-3, motion=Stroke.smooth(4e-4, 0.1, 2e-3))
    stiff_gripper = soft.setup.sheet.grippers[0].model_copy(update={"stiffness": 1.0e7})
    setup = soft.setup.model_copy(
        update={"worlds": (soft.setup.worlds[0].model_copy(
            update={"sheets": (soft.setup.sheet.model_copy(update={"grippers": (stiff_gripper,)}),)}
        ),), "accept_unusual": True}
    )  # fmt: skip
    stiff = Simulation(setup)
    stiff.run()
    assert stiff.stepper.stable_step() < 0.5 * soft.stepper.stable_step()
    share = 1.0e7 * stiff.model.sheet.shares(stiff_gripper) / stiff.model.sheet.node_mass[stiff_gripper.nodes]
    assert stiff.stepper.stable_step() < 0.9 * 2.0 / np.sqrt(share.max())
    assert np.isfinite(stiff.frame.position).all()
    assert abs(stiff.frame.energies["balance_error"]) < 0.01 * stiff.frame.energies["gripper_work"]


def test_a_strip_is_swung_by_the_path_of_its_gripper(strip, frames, manual):
    """The anchors go along a circle about the hinge at the other end: the springs keep their force, and do no work."""
    blank = Blank.rectangle((0.0, 0.0), (LENGTH, WIDTH), 0.01)
    x = blank.node_position[:, 0]
    free = np.ones((blank.node_count, 6), dtype=bool)
    free[x < 1e-9, :3] = False
    free[:, 1] = False
    reach, angle = LENGTH + 0.05, np.radians(60.0)
    turn = np.linspace(0.0, angle, 13)
    ways = reach * np.column_stack([np.cos(turn) - 1.0, np.zeros(13), np.sin(turn)])
    smooth = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, 13))
    # at these times a turn that starts and stops smoothly is at these angles
    times = 0.05 + 0.35 * np.interp(turn / angle, smooth, np.linspace(0.0, 1.0, 13))
    path = PathMotion((0.0, *times.tolist()), ((0.0, 0.0, 0.0), *map(tuple, ways.tolist())))
    gripper = Gripper(
        "jaw", np.flatnonzero(x > LENGTH - 1e-9), (1.0, 0.0, 0.0), SPRING, length=0.05, pretension=LIMIT,
        ramp_time=0.04, motion=path,
    )  # fmt: skip
    simulation = one_sheet_run(
        name="swung", blank=blank, fabric=strip, free=free, grippers=(gripper,), duration=0.5, frame_count=10,
        dynamics=Dynamics(damping=30.0), precision="float64", lane_count=1, threads=1,
    )  # fmt: skip
    simulation.run([frames])
    tight, last = frames.all[1], frames.all[-1]
    edge = last.sheet.position[gripper.nodes]
    force = LIMIT * SERIES / SPRING  # the strip gives way by what it stretches
    length = LENGTH * (1.0 + force / (STIFFNESS * WIDTH))
    found = np.degrees(np.arctan2(edge[:, 2], edge[:, 0]))
    assert found == pytest.approx(np.full(len(edge), 60.0), abs=0.2)
    assert np.hypot(edge[:, 0], edge[:, 2]) == pytest.approx(np.full(len(edge), length), rel=2e-4)
    assert last.gripper_force[0] == pytest.approx(force, rel=0.005)
    energies = last.energies
    assert abs(energies["balance_error"]) < 0.01 * energies["gripper_work"]
    # beside the pretension the anchors only make up for the drag
    given = tight.energies["gripper_work"] + energies["damping_loss"] - tight.energies["damping_loss"]
    assert energies["gripper_work"] == pytest.approx(given, rel=0.03)
    case = manual(
        "Process", "A strip that is swung by the path of its gripper",
        known="A hinged strip of 100 mm and K = 20 kN/m under 6 N of pretension of a spring of 5 N/mm, whose "
        "gripper goes along a circle of 150 mm about the hinge, by 60 degrees: strip and springs turn with it, the "
        "force stays.",
    )  # fmt: skip
    case.table(
        ["quantity", "expected", "got"],
        [["angle of the strip [degrees]", "60", f"{found.mean():.4g}"],
         ["its length [mm]", f"{1e3 * length:.5g}", f"{1e3 * np.hypot(edge[:, 0], edge[:, 2]).mean():.5g}"],
         ["force [N]", f"{force:.5g}", f"{last.gripper_force[0]:.5g}"],
         ["work of the gripper [mJ]", f"{1e3 * given:.4g}", f"{1e3 * energies['gripper_work']:.4g}"]],
    )  # fmt: skip


def test_a_path_goes_on_from_where_the_last_stage_left_it(strip):
    """One stage with a path, a stage at rest, and a stage that lifts on: the anchors are at the sum of both ways."""
    blank = Blank.rectangle((0.0, 0.0), (LENGTH, WIDTH), 0.02)
    x = blank.node_position[:, 0]
    first = PathMotion((0.0, 0.02), ((0.0, 0.0, 0.0), (0.0, 0.0, 0.01)), along=Stroke((0.0, 0.02), (0.0, 2e-4)))
    gripper = Gripper(
        "jaw",
        np.flatnonzero(x > LENGTH - 1e-9),
        (1.0, 0.0, 0.0),
        SPRING,
        pretension=LIMIT,
        ramp_time=5e-3,
        motion=first,
    )
    held = Support("held", np.flatnonzero(x < 1e-9), displacements="xyz", rotations="")
    lift = PathMotion((0.0, 0.02), ((0.0, 0.0, 0.0), (0.0, 0.0, -0.004)))
    setup = Setup(
        "lifted", sheets=[Sheet(blank, strip, grippers=[gripper], supports=[held])], frame_count=3,
        stages=[Stage("a", 0.02), Stage("b", 0.01), Stage("c", 0.06, moves={"jaw": lift})],
        dynamics=Dynamics(damping=500.0), solver=Solver(precision="float64", lane_count=1, threads=1),
    )  # fmt: skip
    simulation = Simulation(setup)
    simulation.run()
    now = simulation.model.setup.sheet.grippers[0]
    assert now.way_at(setup.duration) == pytest.approx([2e-4, 0.0, 0.006])
    edge = simulation.frame.position[gripper.nodes].mean(axis=0)
    # strip and springs are in line with hinge and anchor
    anchor = np.array([LENGTH + gripper.length + 2e-4, 0.006])
    assert edge[2] / edge[0] == pytest.approx(anchor[1] / anchor[0], rel=0.02)
    energies = simulation.frame.energies
    assert abs(energies["balance_error"]) < 0.01 * energies["supplied"]
