"""One test of one specimen as a path in time: sorted, freed of offsets, thinned, and checked before any fit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ..checks import as_typed
from ..errors import InputError
from ..fabric.curve import noise
from ..input_files import shown

LEAST_POINT_COUNT = 6
# Points of one test that a fit sees; more are averaged in their order.
LARGEST_POINT_COUNT = 150
# A reversal of the abscissa that counts, as a share of its range, and the steps that a branch between two has at least.
REVERSAL, LEAST_BRANCH = 0.05, 3
# A force at the start that is taken for the machine's zero, and the largest that may be subtracted: shares of the
# largest force.
SMALL_OFFSET, LARGEST_OFFSET = 0.02, 0.2
# A force at the start that is only noise, over the noise of the points.
NOISE_OF_OFFSET = 6.0
# Distance of a point from its neighbours that is a slip of the pen: times their noise, and as a share of the range.
SPIKE_NOISE, SPIKE_SHARE = 25.0, 0.2


@dataclass(frozen=True)
class Series:
    """A test of one specimen.

    Attributes:
        file: as given.
        label: number of the specimen in its file, or "".
        x, y: abscissa and what was measured, in the order of time, (n,) each.
        lines: line of each row in the file, (n,); of the first row of several that were averaged.
        names: of the columns of x and y.
        notes: what was done to the rows.
    """

    file: str
    label: str
    x: np.ndarray
    y: np.ndarray
    lines: np.ndarray
    names: tuple[str, str]
    notes: tuple[str, ...] = field(default=())

    @property
    def place(self) -> str:
        """File and specimen, for messages."""
        return f"{shown(self.file)}{f', specimen {self.label}' if self.label else ''}"

    def fault(self, reason: str, row: int | None = None, column: int = 1) -> InputError:
        """An error about a row of this test; ``column`` is 0 for x, 1 for y."""
        line = f", line {self.lines[row]}" if row is not None else ""
        return InputError(f"{self.place}{line}: column {self.names[column]!r}: {reason}")

    def noted(self, note: str) -> Series:
        """This series with one more note; itself if the note is empty."""
        return replace(self, notes=(*self.notes, note)) if note else self

    def rows(self, chosen: np.ndarray, note: str = "") -> Series:
        """Some of the rows, in the order of the index (m,)."""
        return replace(self, x=self.x[chosen], y=self.y[chosen], lines=self.lines[chosen]).noted(note)

    @property
    def loading(self) -> tuple[np.ndarray, np.ndarray]:
        """x and y up to the first turning point, (k,) each."""
        end = first_reversal(self.x)
        return self.x[:end], self.y[:end]

    @property
    def unloads(self) -> bool:
        """True if x falls again by a fifth of its range or more."""
        return bool(self.x[first_reversal(self.x) - 1 :].min() < self.x.max() - 0.2 * np.ptp(self.x))


def first_reversal(x: np.ndarray) -> int:
    """Number of points up to the turning point after which x first falls by ``REVERSAL`` of its range."""
    top = np.maximum.accumulate(x)
    fallen = np.flatnonzero(top - x > REVERSAL * np.ptp(x))
    return int(np.argmax(x[: fallen[0]])) + 1 if len(fallen) else len(x)


def turns(x: np.ndarray) -> list[int]:
    """Indices at which x turns by more than ``REVERSAL`` of its range."""
    least, direction, extreme = REVERSAL * np.ptp(x), 0, 0
    found = []
    for k, value in enumerate(x):
        if direction >= 0 and value < x[extreme] - least or direction <= 0 and value > x[extreme] + least:
            if direction:
                found.append(extreme)
            direction, extreme = (-1 if value < x[extreme] else 1), k
        elif direction and (value - x[extreme]) * direction > 0.0:
            extreme = k
    return found


def in_order(series: Series) -> Series:
    """Rows in the order of time: as they are if x rises, or rises and falls; sorted if it jumps about."""
    x = series.x
    if np.all(np.diff(x) > 0.0):
        return series
    turning = turns(x)
    if not turning and x[-1] < x[0]:
        return series.rows(np.arange(len(x))[::-1], "rows were in falling order; they were reversed")
    # loading and unloading are branches of several points
    if turning and min(np.diff([0, *turning])) < LEAST_BRANCH:
        return series.rows(
            np.argsort(x, kind="stable"),
            "rows were in no order; they were sorted, and taken for one loading",
        )
    after = len(x) - 1 - turning[-1] if turning else LEAST_BRANCH
    if after < LEAST_BRANCH:
        raise series.fault(
            f"{x[turning[-1] + 1]:.4g} after {x[turning[-1]]:.4g}: {'a single row' if after == 1 else f'{after} rows'} "
            f"after a turn, where a branch has at least {LEAST_BRANCH}: out of place, or an unloading that was cut off?"
            " Put the rows in order, or leave these out",
            turning[-1] + 1, 0,
        )  # fmt: skip
    if turning and x[0] > x.min() + 0.5 * np.ptp(x):
        raise series.fault(
            f"it begins at {x[0]:.4g}, and falls before it rises: a test begins unloaded; leave out the rows before",
            0, 0,
        )  # fmt: skip
    return series


def thinned(series: Series, largest: int = LARGEST_POINT_COUNT) -> Series:
    """At most about ``largest`` points: means of successive ones, on each branch by itself."""
    if len(series.x) <= largest:
        return series
    size = -(-len(series.x) // largest)
    ends = [0, *(turn + 1 for turn in turns(series.x)), len(series.x)]
    starts = np.unique([k for begin, end in zip(ends, ends[1:], strict=False) for k in range(begin, end, size)])
    count = np.diff([*starts, len(series.x)])
    x, y = (np.add.reduceat(values, starts) / count for values in (series.x, series.y))
    note = f"{len(series.x)} rows averaged to {len(starts)}"
    return replace(series, x=x, y=y, lines=series.lines[starts]).noted(note)


def without_offset(series: Series, offset: str) -> Series:
    """Less the force at the start, if the test begins at zero; as ``offset`` of the options says.

    Raises:
        InputError: "ask", and a force that may be the machine's zero or friction.
    """
    reach = max(5.0e-3 * float(np.ptp(series.x)), 1.0e-12)
    end = first_reversal(series.x)
    start = np.flatnonzero(np.abs(series.x[:end]) <= reach)
    if not len(start) or offset == "keep":
        return series
    value, largest = float(series.y[start].mean()), float(np.abs(series.y).max())
    if value == 0.0:
        return series
    # what the noise of the points explains is left alone
    if offset == "ask" and abs(value) <= NOISE_OF_OFFSET * noise_of(series):
        return series
    if offset == "ask" and abs(value) > SMALL_OFFSET * largest:
        raise series.fault(
            f"{value:.4g} at the start, {abs(value) / largest:.0%} of the largest: the machine's zero, or friction? "
            f"Give {as_typed('offset')} = subtract, or keep",
            int(start[0]),
        )
    if abs(value) > LARGEST_OFFSET * largest:
        raise series.fault(
            f"{value:.4g} at the start, {abs(value) / largest:.0%} of the largest, is no offset; at most "
            f"{LARGEST_OFFSET:.0%} are subtracted: correct the table",
            int(start[0]),
        )
    return replace(series, y=series.y - value).noted(f"{value:.4g} at the start subtracted")


def check_rows(series: Series, accept_unusual: bool) -> None:
    """Raise InputError for a test that no law can follow: too few points, no signal, wrong sign, a spike."""
    x, y = series.x, series.y
    if len(x) < LEAST_POINT_COUNT:
        raise series.fault(f"{len(x)} rows; at least {LEAST_POINT_COUNT} are needed", len(x) - 1, 0)
    if np.ptp(x) == 0.0:
        raise series.fault(f"all values are {x[0]:.6g}: nothing moves", 0, 0)
    if not np.any(y):
        raise series.fault("all values are zero: is it the right column?", 0)
    if np.ptp(y) == 0.0:
        raise series.fault(f"all values are {y[0]:.6g}: nothing was measured", 0)
    if np.median(y) < 0.0 and -y.min() > y.max():
        row = int(np.argmin(y))
        raise series.fault(f"{y[row]:.4g}: forces are negative on the whole; change the sign, it is the machine's", row)
    if not accept_unusual:
        _check_spikes(series)


def _check_spikes(series: Series) -> None:
    x, y = series.loading
    if len(x) < 8 or not np.all(np.diff(x) > 0.0):
        return
    share = (x[1:-1] - x[:-2]) / (x[2:] - x[:-2])
    distance = np.abs(y[1:-1] - (1.0 - share) * y[:-2] - share * y[2:])
    limit = max(SPIKE_NOISE * noise(x, y), SPIKE_SHARE * float(np.ptp(np.sort(y)[:-1])))
    alone = np.flatnonzero(distance > limit)
    # the neighbours of a spike are as far from it
    row = int(alone[np.argmax(distance[alone])]) + 1 if len(alone) else 0
    if row and abs(y[row] - y[row - 1]) > limit and abs(y[row] - y[row + 1]) > limit:
        raise series.fault(
            f"{y[row]:.4g} stands alone between {y[row - 1]:.4g} and {y[row + 1]:.4g}: a slip? Correct it, or give "
            "accept_unusual",
            row,
        )


def check_repeats(tests: Sequence[Series], accept_unusual: bool) -> None:
    """Raise InputError for repeats that have no common range, or of which one is in another unit."""
    if len(tests) < 2:
        return
    low, high = max(t.x.min() for t in tests), min(t.x.max() for t in tests)
    if high <= low:
        last = max(tests, key=lambda t: float(t.x.min()))
        raise last.fault(f"it begins at {low:.4g}, where another specimen has ended, at {high:.4g}", 0, 0)
    size = [float(np.abs(t.y[(t.x >= low) & (t.x <= high)]).max(initial=0.0)) for t in tests]
    middle = float(np.median(size))
    for test, value in zip(tests, size, strict=True):
        if not accept_unusual and not 0.1 * middle <= value <= 10.0 * middle:
            raise test.fault(
                f"up to {value:.4g}, where the other specimens have {middle:.4g}: another unit, or another fabric?",
                int(np.argmax(np.abs(test.y))),
            )


def noise_of(test: Series) -> float:
    """Of the points of one test, from each one's distance to its neighbours."""
    x, y = test.loading
    order = np.argsort(x, kind="stable")
    x, first = np.unique(x[order], return_index=True)
    return noise(x, y[order][first]) if len(x) > 4 else 0.0
