"""Stretches that yarns do not bear."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from .guard import Doubt, Guard, Level

if TYPE_CHECKING:
    from ..verdict import Judged

# Largest strain of a yarn that is not doubted, and from which on a result is no woven fabric's.
LARGEST_STRAIN = 0.1
USELESS_STRAIN = 0.25


class YarnStretch(Guard):
    """Yarns that were stretched or compressed far beyond a woven fabric's, at any time."""

    name = "yarn_stretch"
    watches = "the stretch of the yarns, at any time"

    def after(self, run: Judged) -> Iterable[Doubt]:
        """Extremes of each sheet over all steps."""
        for info, sheet in zip(run.run.info.sheets, run.extremes.sheets, strict=True):
            smallest, largest = sheet.min_stretch, sheet.max_stretch
            if not 1.0 - LARGEST_STRAIN < smallest.value <= largest.value < 1.0 + LARGEST_STRAIN:
                worst = max(largest, smallest, key=lambda extreme: abs(extreme.value - 1.0))
                strain = abs(worst.value - 1.0)
                yield self.doubt(
                    Level.WARNING if strain < USELESS_STRAIN else Level.DO_NOT_USE,
                    f"yarn stretches ranged from {smallest.value:.3f} to {largest.value:.3f}",
                    "yarns of a woven fabric do not bear that",
                    sheet=info.name,
                    place=worst.place,
                    time=worst.time,
                    value=strain,
                    limit=LARGEST_STRAIN,
                )
