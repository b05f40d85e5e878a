"""Sheets that a stage has trimmed: cuts that missed, and borders that are steps of whole elements."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from ..guard import Doubt, Guard, Level

if TYPE_CHECKING:
    from ...verdict import Judged

# From here on a border is off its curves [mm].
LEAST_OFF_CURVE = 1.0e-3


class Trims(Guard):
    """Trims that cut nothing away, and how far the border of what stays is off the curves."""

    name = "trims"
    watches = "what the trims of stages cut away"

    def after(self, run: Judged) -> Iterable[Doubt]:
        """Every trim so far."""
        for told in run.run.stages.trimmed:
            text = f"stage {told['stage']}, trim of sheet {told['sheet']}"
            if told["element_count"] == 0:
                yield self.doubt(
                    Level.WARNING,
                    f"{text}: all of it lies on the side that stays, and nothing is cut away",
                    "look at the unit and the place of the curves",
                    sheet=told["sheet"],
                    time=told["time_s"],
                )
                continue
            if told["off_curve_mm"] < LEAST_OFF_CURVE:
                continue
            yield self.doubt(
                Level.NOTE,
                f"{text}: whole elements stay or go; the new border is up to {told['off_curve_mm']:.3g} mm off its "
                "curves",
                "for a border that follows them, mesh the blank so that edges of elements lie there",
                sheet=told["sheet"],
                time=told["time_s"],
                value=1e-3 * told["off_curve_mm"],
            )
