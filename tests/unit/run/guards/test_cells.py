"""Guard of unit cells that fail: when and where it was seen first, in any state that a run looks at."""

from types import SimpleNamespace

import numpy as np
import pytest

from tests.support.judged import judged
from weavesim.run.guards.cells import UnitCellFailures

LEDGER = SimpleNamespace(
    sheets=[SimpleNamespace(place_of=lambda element, k=k: np.array([0.1 * k, 0.01 * element])) for k in range(2)]
)


def frame(time: float, **residuals: list[float]):
    """Cells of two sheets, of which those with a residual above 1 have failed."""
    sheets = [
        SimpleNamespace(
            name=name,
            fields={
                "unit_cell_residual": np.array(residuals.get(name, [0.0] * 3)),
                "unit_cell_failed": (~(np.array(residuals.get(name, [0.0] * 3)) < 1.0)).astype(float),
            },
        )
        for name in ("lower", "upper")
    ]
    return SimpleNamespace(time=time, sheets=sheets)


def watched(*frames) -> UnitCellFailures:
    guard = UnitCellFailures()
    for each in frames:
        guard.watch(each, LEDGER)
    return guard


@pytest.mark.parametrize("bad", [2.0, np.nan, np.inf])
def test_the_first_that_fails_is_told_with_its_sheet_place_and_time(bad):
    guard = watched(frame(0.1), frame(0.2, lower=[1.5, 0.0, 0.0], upper=[0.0, 0.0, bad]), frame(0.3, lower=[9.0] * 3))
    (doubt,) = guard.after(judged(unit_cell_failures=4))
    assert (doubt.value, doubt.sheet, doubt.time) == (4.0, "upper", 0.2) and doubt.place == pytest.approx((0.1, 0.02))


def test_what_a_run_in_progress_says_is_of_the_state_that_was_seen_last():
    guard = watched(frame(0.1, upper=[2.0, 0.0, 3.0]))
    (doubt,) = guard.so_far(judged(unit_cell_failures=0))
    assert doubt.value == 2.0 and doubt.time == 0.1
    assert list(watched(frame(0.1, upper=[0.9] * 3)).so_far(judged())) == []


def test_it_remembers():
    guard, other = watched(frame(0.1, lower=[0.0, 2.0, 0.0])), UnitCellFailures()
    other.recall(guard.memory())
    assert list(other.so_far(judged())) == list(guard.so_far(judged())) != []
    other.recall(UnitCellFailures().memory())
    assert list(other.so_far(judged())) == []
