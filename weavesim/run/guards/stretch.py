"""Stretches that yarns do not bear."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from .guard import Doubt, Guard, Level

if TYPE_CHECKING:
    from ..verdict import Judged

# Largest departure of a yarn's stretch from one that is not doubted.
LARGEST_STRAIN = 0.1


class YarnStretch(Guard):
    """Yarns that are stretched or compressed far beyond a woven fabric's."""

    name = "yarn_stretch"
    watches = "the stretch of the yarns"

    def after(self, run: Judged) -> Iterable[Doubt]:
        """Stretches of the last frame."""
        smallest, largest = run.number("min_stretch"), run.number("max_stretch")
        if not 1.0 - LARGEST_STRAIN < smallest <= largest < 1.0 + LARGEST_STRAIN:
            yield self.doubt(
                Level.WARNING,
                f"yarn stretches range from {smallest:.3f} to {largest:.3f}",
                "yarns of a woven fabric do not bear that",
                value=float(max(1.0 - smallest, largest - 1.0)),
                limit=LARGEST_STRAIN,
            )
