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
# A sheet with less stiffness over its thickness is no woven fabric, but rubber [Pa]: it bears more, and its law is
# linear up to about a half.
LEAST_MODULUS = 5.0e7
LARGEST_STRAIN_OF_RUBBER, USELESS_STRAIN_OF_RUBBER = 0.5, 1.0


class YarnStretch(Guard):
    """Yarns that were stretched or compressed far beyond a woven fabric's, at any time."""

    lasting = True
    name = "yarn_stretch"
    watches = "the stretch of the yarns, at any time"

    def after(self, run: Judged) -> Iterable[Doubt]:
        """Extremes of each sheet over all steps."""
        for info, sheet in zip(run.run.info.sheets, run.extremes.sheets, strict=True):
            smallest, largest = sheet.min_stretch, sheet.max_stretch
            rubber = max(info.fabric.unit_cell.yarn_stiffness_per_width) < LEAST_MODULUS * info.fabric.thickness
            limit, useless = (
                (LARGEST_STRAIN_OF_RUBBER, USELESS_STRAIN_OF_RUBBER) if rubber else (LARGEST_STRAIN, USELESS_STRAIN)
            )
            if not 1.0 - limit < smallest.value <= largest.value < 1.0 + limit:
                worst = max(largest, smallest, key=lambda extreme: abs(extreme.value - 1.0))
                strain = abs(worst.value - 1.0)
                yield self.doubt(
                    Level.WARNING if strain < useless else Level.DO_NOT_USE,
                    f"{'' if rubber else 'yarn '}stretches ranged from {smallest.value:.3f} to {largest.value:.3f}",
                    "rubber is not linear there" if rubber else "yarns of a woven fabric do not bear that",
                    sheet=info.name,
                    place=worst.place,
                    time=worst.time,
                    value=strain,
                    limit=limit,
                )
