"""Condition of a sheet at several times: the last, and the worst with its time and place."""

import numpy as np
import pytest

from weavesim.fabric.presets import glass_polypropylene
from weavesim.run.frame import SheetFrame, SheetInfo
from weavesim.run.watch.condition import Condition
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
