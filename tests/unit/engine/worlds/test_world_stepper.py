"""Worlds that are stepped in one launch take the steps that each takes alone, to the bit."""

import numpy as np
import pytest
import warp as wp

from tests.support.runs import one_sheet_setup
from weavesim.engine.worlds.mirror import Unalike
from weavesim.engine.worlds.world_stepper import WorldStepper
from weavesim.fabric.presets import glass_polypropylene
from weavesim.kernels.rows import ToolWatchRow
from weavesim.process.dynamics import Dynamics
from weavesim.process.grippers import Gripper
from weavesim.process.strokes import SmoothStroke, Stroke
from weavesim.process.supports import Drive, Support
from weavesim.run.simulation import Simulation
from weavesim.sheet.blank import Blank
from weavesim.tools.mesh_tool import MeshShape
from weavesim.tools.shapes import Sphere
from weavesim.tools.tool import Tool

HALF_WAY, END = 4e-4, 1e-3


def world(number=0, size=0.005, **given):
    """A patch of 20 mm: driven at one edge, gripped at the other, hit by a ball; all numbers vary."""
    blank = Blank.rectangle((0.0, 0.0), (0.02, 0.02), size)
    x = blank.node_position[:, 0]
    rise = SmoothStroke((0.0, END), (0.0, 1e-4 * (1 + number)), (0.0, 0.0))
    edge = Support("edge", np.flatnonzero(x < 1e-9), (Drive(rise, (0.0, 0.0, 1.0)),))
    gripper = Gripper("grip", np.flatnonzero(x > 0.0199), (1.0, 0.0, 0.0), stiffness=2e3 * (1 + number), pretension=1.0)
    ball = Tool(
        "ball", Sphere(0.005, origin=(0.01, 0.01, -0.0057)), axis=(0.0, 0.0, 1.0),
        motion=Stroke((0.0, END), (0.0, 3e-3 - 5e-4 * number)), friction=0.1 * number,
    )  # fmt: skip
    fabric = glass_polypropylene()
    fabric = fabric.model_copy(update={"areal_density": fabric.areal_density * (1.0 + 0.2 * number)})
    dynamics = Dynamics(
        gravity=(0.0, 0.0, -9.81 * number), damping=10.0 * number, contact_samples="surface",
        contact_allowance=5e-4 * number,
    )  # fmt: skip
    settings = {"name": f"world {number}", "duration": END, "lane_count": 1, "threads": 1, "tools": (ball,)} | given
    return one_sheet_setup(
        blank=blank, fabric=fabric, supports=(edge,), grippers=(gripper,), dynamics=dynamics, **settings
    )


def started(setup):
    simulation = Simulation(setup)
    simulation.prepare()
    return simulation.stepper


def bits(state):
    """All of a state, but for the forces that every step writes before it reads them."""
    return {name: array.numpy().tobytes() for name, array in state.arrays() if not name.endswith("corner_force")}


@pytest.fixture(scope="module")
def together():
    """Three worlds, half way and at the end."""
    steppers = [started(world(number)) for number in range(3)]
    worlds, found = WorldStepper(wp.get_device("cpu"), steppers), []
    worlds.load()
    worlds.start()
    for target in (HALF_WAY, END):
        worlds.advance_to(np.full(3, target))
        found.append([(stepper.step_count, bits(stepper.state)) for stepper in steppers])
    return found


@pytest.mark.parametrize("number", range(3))
def test_every_world_gets_the_bits_of_a_single_run(together, number):
    alone = started(world(number))
    alone.whole_launches = True  # padding moves too
    for target, found in zip((HALF_WAY, END), together, strict=True):
        alone.advance_to(target)
        step_count, state = found[number]
        assert step_count == alone.step_count
        assert {name for name, value in bits(alone.state).items() if state[name] != value} == set()
    assert alone.state.sheet.grip.numpy().any() and (number or alone.state.sheet.sample_work_sum.numpy().any())
    assert alone.state.tool_watch.numpy()[ToolWatchRow.peak] > 0.0


def test_worlds_differ_in_all_that_varies(together):
    for name in ("sheets/0/motion", "sheets/0/grip", "tool_displacement", "drive_displacement", "clock"):
        assert len({state[name] for _, state in together[-1]}) == 3


def test_a_world_waits_where_it_has_reached_its_target():
    steppers = [started(world(number)) for number in range(3)]
    worlds = WorldStepper(wp.get_device("cpu"), steppers)
    worlds.start()
    worlds.advance_to(np.array([END, -np.inf, HALF_WAY]))
    counts = [stepper.step_count for stepper in steppers]
    assert counts[1] == 0 < counts[2] < counts[0]
    worlds.advance_to(np.full(3, END))
    for number, stepper in enumerate(steppers):
        alone = started(world(number))
        alone.whole_launches = True
        alone.advance_to(END)
        assert bits(stepper.state) == bits(alone.state)
    worlds.advance_to(np.full(3, HALF_WAY))
    assert [stepper.state.time >= END for stepper in steppers] == [True] * 3


def test_an_interval_of_one_launch_ends_there_too(together):
    """On a CPU the loop is recorded as on a GPU, and replayed natively."""
    steppers = [started(world(number)) for number in range(3)]
    worlds = WorldStepper(wp.get_device("cpu"), steppers)
    worlds.launches_intervals = True
    worlds.start()
    for target, found in zip((HALF_WAY, END), together, strict=True):
        worlds.advance_to(np.full(3, target))
        assert [(stepper.step_count, bits(stepper.state)) for stepper in steppers] == found


@pytest.mark.gpu
def test_a_gpu_steps_worlds_as_it_steps_each_alone():
    # in double precision: a relative change of 1e-15 of the density moves nodes by 2e-7 m until then, as yarns go slack
    # and stick; in single precision one of 1e-7 moves them by 1e-5 m
    steppers = [started(world(number, precision="float64")) for number in range(3)]
    worlds = WorldStepper(wp.get_device("cuda:0"), steppers)
    worlds.load()
    worlds.start()
    worlds.advance_to(np.full(3, END))
    for number, stepper in enumerate(steppers):
        alone = started(world(number, precision="float64", device="cuda:0"))
        alone.advance_to(END)
        assert abs(stepper.step_count - alone.step_count) <= 20
        here, there = (each.model.sheet.read_motion(each.state.sheet.motion)[0] for each in (stepper, alone))
        np.testing.assert_allclose(here, there, atol=2e-6)


def test_tools_may_be_triangle_meshes():
    corners = np.array([[-0.03, -0.03, 0.0], [0.05, -0.03, 0.0], [0.05, 0.05, 0.0], [-0.03, 0.05, 0.0]])
    shape = MeshShape.from_triangles(
        corners, np.array([[0, 1, 2], [0, 2, 3]]), spacing=1e-3, reach=5e-3, origin=(0.0, 0.0, -0.0007)
    )
    rising = Stroke((0.0, HALF_WAY), (0.0, 1e-3))
    tables = [Tool("table", shape, axis=(0.0, 0.0, 1.0), motion=rising, friction=0.1 * number) for number in range(2)]
    steppers = [started(world(number, tools=(tables[number],))) for number in range(2)]
    worlds = WorldStepper(wp.get_device("cpu"), steppers)
    worlds.load()
    worlds.start()
    worlds.advance_to(np.full(2, HALF_WAY))
    for number, stepper in enumerate(steppers):
        alone = started(world(number, tools=(tables[number],)))
        alone.whole_launches = True
        alone.advance_to(HALF_WAY)
        assert bits(stepper.state) == bits(alone.state)
        assert alone.state.tool_watch.numpy()[ToolWatchRow.peak] > 0.0


def test_a_world_that_is_lost_stops_alone():
    steppers = [started(world(number)) for number in range(2)]
    motion = steppers[0].state.sheet.motion.numpy().copy()
    motion[0] = np.nan
    steppers[0].state.sheet.motion.assign(motion)
    worlds = WorldStepper(wp.get_device("cpu"), steppers)
    worlds.start()
    worlds.advance_to(np.full(2, HALF_WAY))
    assert not steppers[0].state.step > 0.0
    alone = started(world(1))
    alone.whole_launches = True
    alone.advance_to(HALF_WAY)
    assert bits(steppers[1].state) == bits(alone.state)


def test_other_meshes_are_refused():
    with pytest.raises(Unalike):
        WorldStepper(wp.get_device("cpu"), [started(world(0)), started(world(0, size=0.004))])
