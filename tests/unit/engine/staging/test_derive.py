"""The set-up of one stage: motions in the time of the run, from where things are."""

import numpy as np
import pytest

from tests.unit.engine.staging.test_checks import DOWN, FORCE, staged
from weavesim import AtStroke, Fixed, NodalLoads, Pressure, SheetPressure, SmoothStroke, Stage, Stroke
from weavesim.engine.staging.derive import AnchorPlace, acting_of, first_begin, planned_begins, stage_setup
from weavesim.process.stages import SheetLoads


def in_stage(setup, index, **given):
    """The last of the stages up to ``index``, whose begins are a little late."""
    begins = [first_begin(setup)]
    for _ in range(index):
        last = begins[-1]
        begins.append(last._replace(time=last.time + 0.101, planned=last.planned + 0.1, **given))
    return stage_setup(setup, acting_of(setup)[index], begins)


def tool(setup, name):
    return next(each for each in setup.tools if each.name == name)


def test_a_stage_that_says_nothing_changes_nothing():
    setup = staged(Stage("a", 0.1), Stage("b", 0.1))
    for index in (0, 1):
        alone = in_stage(setup, index)
        assert alone.worlds == setup.worlds and alone.solver == setup.solver and alone.stages == ()


def test_strokes_go_on_from_where_the_tool_is():
    setup = staged(Stage("a", 0.1), Stage("b", 0.1, moves={"punch": DOWN, "holder": Fixed(), "die": FORCE}))
    alone = in_stage(setup, 1, tools=(0.011, 0.002, 0.0, 0.0))
    assert tool(alone, "punch").motion == Stroke((0.101, 0.201), (0.011, 0.031))
    assert tool(alone, "holder").motion == Stroke((0.101,), (0.002,))
    assert tool(alone, "die").motion == FORCE.model_copy(update={"times": (0.101,)})


def test_a_tool_that_is_left_out_stays_and_one_that_comes_later_waits():
    setup = staged(Stage("a", 0.1, tools=("holder", "stopping")), Stage("b", 0.1, tools=("punch", "die")))
    first, second = in_stage(setup, 0), in_stage(setup, 1, tools=(0.0, 0.003, 0.0, 0.002))
    assert tool(first, "punch").motion == Stroke((0.0,), (0.0,))
    assert tool(second, "punch").motion == Stroke((0.101, 0.201), (0.0, 0.02))
    assert tool(second, "holder").motion == Stroke((0.101,), (0.003,))
    assert tool(second, "stopping").motion == Stroke((0.101,), (0.002,))


def test_supports_let_go_but_keep_their_place_in_the_state():
    setup = staged(Stage("a", 0.1), Stage("b", 0.1, supports=("edge",)), Stage("c", 0.1, supports=("edge", "frame")))
    frame = in_stage(setup, 1).supports[1]
    assert not frame.held.any() and len(frame.drives) == 1 and not np.any(frame.drives[0].direction)
    assert in_stage(setup, 2).supports == setup.supports


def test_drives_and_anchors_go_on_from_where_they_are():
    smooth = SmoothStroke((0.0, 0.1), (0.0, 0.01), (0.0, 0.0))
    setup = staged(Stage("a", 0.1), Stage("b", 0.1, moves={"frame": smooth, "spring": DOWN}))
    alone = in_stage(setup, 1, drives=(0.004,), grippers=(AnchorPlace(0.001),))
    assert alone.supports[1].drives[0].at(0.101) == pytest.approx(0.004)
    assert alone.supports[1].drives[0].at(0.201) == pytest.approx(0.014)
    assert alone.grippers[0].motion.displacement_at(0.151) == pytest.approx(0.011)


def test_a_gripper_is_released_when_its_stage_begins():
    setup = staged(Stage("a", 0.1), Stage("b", 0.1), Stage("c", 0.1, grippers=()), Stage("d", 0.1))
    assert [in_stage(setup, k).grippers[0].release_time for k in range(4)] == [None, None, 0.202, 0.202]


def test_pressures_and_loads_change_with_the_stage():
    lifted = SheetPressure(Pressure.ramped("bottom", 5e3, 0.01))
    setup = staged(
        Stage("a", 0.1),
        Stage("b", 0.1, pressures=(lifted,), gravity=(0.0, 0.0, -9.81), target_step=1e-6),
        Stage("c", 0.1, pressures=(), damping=5.0, target_step=0.0),
    )
    first, second, third = (in_stage(setup, k) for k in range(3))
    assert first.sheet.pressures == (Pressure("top", (0.0,)),) == third.sheet.pressures
    assert second.sheet.pressures[0].at(np.array([0.101, 0.111])).tolist() == pytest.approx([0.0, 5e3])
    dynamics = [each.worlds[0].dynamics for each in (first, second, third)]
    assert [each.gravity[2] for each in dynamics] == [0.0, -9.81, -9.81]
    assert [each.damping for each in dynamics] == [0.0, 0.0, 5.0]
    assert [each.solver.target_step for each in (first, second, third)] == [None, 1e-6, None]


def test_the_plan_knows_where_strokes_end():
    setup = staged(
        Stage("a", 0.05), Stage("b", 0.1, AtStroke("stopping", 0.005)), Stage("c", 0.1, moves={"punch": DOWN})
    )
    begins = planned_begins(setup, acting_of(setup))
    assert [begin.time for begin in begins] == pytest.approx([0.0, 0.05, 0.15])
    assert begins[1].tools == pytest.approx((0.01, 0.0, 0.0, 0.01))
    assert begins[2].tools == pytest.approx((0.02, 0.0, 0.0, 0.015))


@pytest.mark.parametrize("loads", [(), (SheetLoads(NodalLoads()),)])
def test_loads_of_a_stage_replace_those_of_the_sheet_even_if_there_are_none(loads):
    own = NodalLoads(np.full((25, 3), 2.0))
    setup = staged(Stage("a", 0.1), Stage("b", 0.1, loads=loads), loads=own)
    assert np.array_equal(in_stage(setup, 0).sheet.loads.force, own.force)
    assert not np.any(in_stage(setup, 1).sheet.loads.force)
