"""Laws that were used beyond what was measured."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...fabric.shear import unloading_doubt
from ...kernels.rows import ExtremeRow
from .guard import Doubt, Guard, Level

if TYPE_CHECKING:
    from ...fabric.fabric import Fabric
    from ...sheet.blank import Blank
    from ..verdict import Judged

# A few elements slightly beyond the data are worth a note only.
NOTED_SHARE = 0.002
NOTED_EXCESS = 0.02
# With that many elements, that far beyond the range, over the range, the extrapolation rules the result.
USELESS_SHARE = 0.05
USELESS_EXCESS = 0.5
# An element counts as unloaded from here on [rad], and a run as one with unloading from this share of them.
UNLOADED_ANGLE, UNLOADED_SHARE = math.radians(2.0), 0.02
# In front of the numbers, and their unit.
DEGREES, CURVATURE = ("°", 180.0 / math.pi), (" 1/m", 1.0)


class Beyond(NamedTuple):
    """Use of one law beyond its data, at any time.

    Attributes:
        what: the law, for readers.
        unit: of both values, with the factor from SI units.
        limit: up to where it was measured.
        largest: that was reached.
        share: of the elements.
        element: that went furthest.
        row: of ``ExtremeRow``.
    """

    what: str
    unit: tuple[str, float]
    limit: float
    largest: float
    share: float
    element: int
    row: int

    @property
    def excess(self) -> float:
        """Beyond the range, over the range."""
        return self.largest / self.limit - 1.0


def beyond_data(fabric: Fabric, rows: np.ndarray) -> Iterator[Beyond]:
    """Laws of a fabric that were used beyond their data; ``rows`` are extremes by ``ExtremeRow`` (row, element)."""
    friction = fabric.shear_friction
    warp, weft = fabric.bending.trusted_curvature
    for what, unit, row, limit in (
        ("the shear law", DEGREES, ExtremeRow.angle, fabric.shear.trusted_angle),
        ("the shear friction", DEGREES, ExtremeRow.angle, friction.trusted_angle if friction else None),
        ("the bending curve of the warp", CURVATURE, ExtremeRow.warp_curvature, warp),
        ("the bending curve of the weft", CURVATURE, ExtremeRow.weft_curvature, weft),
    ):
        if limit is None:
            continue
        beyond = rows[row] > limit * (1.0 + 1.0e-6)
        if beyond.any():
            element = int(np.argmax(rows[row]))
            yield Beyond(what, unit, limit, float(rows[row][element]), float(beyond.mean()), element, int(row))


class LawRange(Guard):
    """Measured laws that were used beyond their last point, at any time."""

    lasting = True
    name = "law_range"
    watches = "whether laws were used beyond their data"

    def after(self, run: Judged) -> Iterable[Doubt]:
        """One doubt for each law of each sheet."""
        for info, sheet in zip(run.run.info.sheets, run.extremes.sheets, strict=True):
            for found in beyond_data(info.fabric, sheet.rows):
                symbol, factor = found.unit
                level = Level.WARNING
                if found.share < NOTED_SHARE and found.excess < NOTED_EXCESS:
                    level = Level.NOTE
                elif found.share > USELESS_SHARE and found.excess > USELESS_EXCESS:
                    level = Level.DO_NOT_USE
                yield self.doubt(
                    level,
                    f"{found.what} was measured up to {factor * found.limit:.4g}{symbol} and used up to "
                    f"{factor * found.largest:.4g}{symbol}, beyond its data in {found.share:.2%} of the elements",
                    "there it is extrapolated (extrapolation); measure further, or form less",
                    sheet=info.name,
                    place=_centre(info.blank, found.element),
                    time=float(sheet.times[found.row]),
                    value=found.largest,
                    limit=found.limit,
                )


class Unloading(Guard):
    """Shear that went back, from its largest to the last frame, in a fabric of which nobody has measured unloading."""

    name = "unloading"
    watches = "whether shear went back in a fabric whose unloading is assumed"

    def after(self, run: Judged) -> Iterable[Doubt]:
        """One note for each sheet in which it matters."""
        frames = run.run.frame.sheets
        for info, frame, sheet in zip(run.run.info.sheets, frames, run.extremes.sheets, strict=True):
            back = sheet.rows[ExtremeRow.angle] - np.abs(frame.fields["shear_angle"])
            there = np.isfinite(back)  # without what was trimmed
            share = float((back[there] > UNLOADED_ANGLE).mean())
            if share > UNLOADED_SHARE and (assumption := unloading_doubt(info.fabric)):
                yield self.doubt(
                    Level.NOTE,
                    f"{share:.0%} of the elements went back in shear by more than {math.degrees(UNLOADED_ANGLE):.2g}°, "
                    f"by up to {math.degrees(back[there].max()):.3g}°, but what the fabric does then is not measured "
                    f"({assumption})",
                    "how far it springs back, and how much work is lost, depends on that; a test with unloading tells "
                    "(docs/fabrics.md)",
                    sheet=info.name,
                    place=_centre(info.blank, int(np.argmax(np.where(there, back, -np.inf)))),
                    value=share,
                    limit=UNLOADED_SHARE,
                )


def _centre(blank: Blank, element: int) -> tuple[float, float]:
    """Middle of an element on the flat blank [m]."""
    x, y = blank.material_coordinates[blank.quads[element]].mean(axis=0)
    return float(x), float(y)
