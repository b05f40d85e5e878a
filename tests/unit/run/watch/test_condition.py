"""Condition of a sheet at several times: the last, and the worst with its time and place."""

import numpy as np
import pytest

from weavesim.fabric.presets import glass_polypropylene
from weavesim.run.frame import SheetFrame, SheetInfo
from weavesim.run.watch.condition import Condition, StackCondition
from weavesim.sheet.blank import Blank
from weavesim.sheet.symmetry import Symmetry

BLANK = Blank.rectangle((0.0, 0.0), (0.06, 0.03), 0.005)


def looked(*positions: np.ndarray) -> Condition:
    condition = Condition(SheetInfo("sheet", BLANK, glass_polypropylene(), Symmetry(("x",))))
    for time, position in enumerate(positions):
        condition.look(SheetFrame("sheet", position, BLANK.initial_director, {}, {}), float(time))
    return condition


def looped(turns: float) -> np.ndarray:
    """Rolled up with a twist that makes the ends cross once there is more than one turn."""
    x, y = BLANK.node_position[:, :2].T
    angle = 2.0 * np.pi * turns * (x / 0.06)
    radius = 0.06 / (2.0 * np.pi * max(turns, 1e-9))
    return np.column_stack([radius * np.sin(angle), y + 0.2 * x, radius * (1.0 - np.cos(angle)) * (1 - 2.0 * x)])


def test_a_flat_sheet_is_sound():
    condition = looked(BLANK.node_position)
    assert all(
        tally.most == tally.last == 0.0 and tally.place is None
        for tally in (condition.crossings, condition.folded, condition.inverted, condition.beyond)
    )


def test_the_worst_state_is_kept():
    flat = BLANK.node_position
    condition = looked(flat, looped(1.2), flat)
    assert condition.crossings.last == 0.0 < condition.crossings.most
    assert condition.crossings.time == 1.0 and 0.0 < condition.crossings.share < 0.5
    assert condition.crossings.place is not None


def test_what_is_beyond_a_plane_is_in_metres():
    moved = BLANK.node_position - (0.002, 0.0, 0.0)
    condition = looked(BLANK.node_position, moved)
    assert condition.beyond.most == condition.beyond.last == pytest.approx(0.002) and condition.beyond.time == 1.0


def test_a_fold_and_a_turn_are_counted():
    creased = BLANK.node_position.copy()
    back = creased[:, 0] > 0.03
    creased[back, 0] = 0.06 - creased[back, 0]
    creased[back, 2] = 1e-4
    condition = looked(creased)
    assert condition.folded.last == 6.0 and condition.inverted.last == 36.0


def test_sheets_that_pass_through_each_other_are_counted_by_pair():
    names = ("lower", "middle", "upper")
    infos = [SheetInfo(name, BLANK, glass_polypropylene(), Symmetry()) for name in names]
    stack = StackCondition(infos)

    def look(time: float, tilt: float) -> None:
        heights = (0.0, 0.001, 0.002)
        positions = [BLANK.node_position + (0.0, 0.0, height) for height in heights]
        positions[1] = positions[1] + BLANK.node_position[:, :1] * (0.0, 0.0, tilt)
        # in another order than that of the world, and with a sheet of another one
        frames = [
            SheetFrame(name, position, BLANK.initial_director, {}, {})
            for name, position in [*zip(names, positions, strict=True), ("other", positions[0])]
        ]
        stack.look(frames[::-1], time)

    look(0.0, 0.0)
    look(0.1, 0.03)
    look(0.2, 0.0)
    assert stack.look_count == 3
    assert list(stack.crossings) == [("lower", "middle"), ("lower", "upper"), ("middle", "upper")]
    crossed = stack.crossings["middle", "upper"]
    assert crossed.last == 0.0 < crossed.most == stack.total["middle", "upper"] and crossed.time == 0.1
    assert crossed.place == pytest.approx((0.0325, 0.0025)) and crossed.share == pytest.approx(1.0 / 12.0)
    assert stack.crossings["lower", "middle"].most == stack.crossings["lower", "upper"].most == 0.0
