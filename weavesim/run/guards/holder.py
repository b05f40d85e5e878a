"""Tools driven by a force that do not carry it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from ..frame import Outcome
from .guard import Doubt, Guard, Level

if TYPE_CHECKING:
    from ..verdict import Judged

# Share of the time with less than half the force that is not doubted, and from which on the force is not applied.
LARGEST_IDLE = 0.1
USELESS_IDLE = 0.5
# Peak over the largest force wanted, likewise.
LARGEST_PEAK = 3.0
USELESS_PEAK = 10.0
# Of tools that have met the sheet, and of those of an interrupted run that have not.
BOUNCES = "it bounces: raise its force and move tools more slowly, or take a heavier holder or a gap"
NOT_THERE = "it has not met the sheet yet: put it nearer, or let the run go on"


class BouncingHolder(Guard):
    """Holders and punches driven by a force that bounce off the sheet, or fly."""

    name = "bouncing_holder"
    watches = "the force that force-driven tools carry, in every step"

    def after(self, run: Judged) -> Iterable[Doubt]:
        """Tools that carried less than half of their force for long, or far more."""
        watched, finished = run.extremes.tools, run.run.outcome is Outcome.FINISHED
        for k, (name, met) in enumerate(zip(run.run.info.tool_names, run.extremes.touched, strict=True)):
            if finished and not met:
                continue  # ``never_touched`` speaks
            wanted, time = watched["most_wanted"][k], watched["wanted"][k]
            if not (wanted > 0.0 and time > 0.0):
                continue
            idle, peak = watched["idle"][k] / time, watched["peak"][k] / wanted
            if idle > LARGEST_IDLE or peak > LARGEST_PEAK:
                share = watched["carried_impulse"][k] / watched["wanted_impulse"][k]
                yield self.doubt(
                    Level.DO_NOT_USE if idle > USELESS_IDLE or peak > USELESS_PEAK else Level.WARNING,
                    f"{name} carried less than half of its force for {idle:.0%} of the time, {share:.0%} of it on "
                    f"average, and {watched['peak'][k]:.4g} N at its peak, where {wanted:.4g} N were wanted",
                    BOUNCES if met else NOT_THERE,
                    value=float(idle),
                    limit=LARGEST_IDLE,
                )
