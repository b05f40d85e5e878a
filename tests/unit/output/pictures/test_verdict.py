"""The picture of a verdict: rows for the sheets that have something to show."""

from types import SimpleNamespace

import numpy as np
import pytest

from tests.support.bowls import bowl
from weavesim.output.pictures.verdict import verdict_picture

FINE = SimpleNamespace(sheet=bowl(0.12, 0.12), regions=[])
WRINKLED = SimpleNamespace(sheet=FINE.sheet, regions=[SimpleNamespace(elements=np.array([3, 4]), kind="wrinkle")])


@pytest.mark.parametrize(
    ("judged", "titles", "within"),
    [
        ([FINE], ["a: within all limits"], ""),
        ([FINE, FINE], ["a: within all limits"], "Within all limits: b"),
        ([FINE, WRINKLED, FINE], ["b: 1 region beyond a limit"], "Within all limits: a, c"),
        ([WRINKLED, WRINKLED], ["a: 1 region beyond a limit", "b: 1 region beyond a limit"], ""),
    ],
)
def test_sheets_without_regions_leave_no_empty_rows(judged, titles, within):
    figure = verdict_picture("abc"[: len(judged)], judged)
    assert [axes.get_title(loc="left") for axes in figure.axes[::2]] == titles
    assert figure.get_suptitle() == within
    assert figure.get_size_inches()[1] == 5.0 * len(titles)
