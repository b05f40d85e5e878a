"""Tools driven by a force that do not carry it, and strokes that wait at their largest force."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from ..frame import Outcome
from .guard import Doubt, Guard, Level

if TYPE_CHECKING:
    import numpy as np

    from ..frame import Frame
    from ..ledger import Ledger
    from ..verdict import Judged

logger = logging.getLogger(__name__)

# Share of the force, between two looks at a run, below which the run is told that a tool does not carry it.
LEAST_SHARE = 0.9
# Share of the run that a tool may take to land.
LONGEST_WAIT = 0.1

# Share of the time with less than half the force that is not doubted, and from which on the force is not applied.
LARGEST_IDLE = 0.1
USELESS_IDLE = 0.5
# Peak over the largest force wanted, likewise.
LARGEST_PEAK = 3.0
USELESS_PEAK = 10.0
# What a stroke may be short of unnoticed [m].
LEAST_LACK = 1.0e-6
# Of tools that have met the sheet, and of those of an interrupted run that have not.
BOUNCES = "it bounces: raise its force or its damping_ratio, move tools more slowly, or take a heavier holder or a gap"
LANDS_HARD = "it lands hard: put it nearer, or let it start in_touch"
NOT_THERE = "it has not met the sheet yet: put it nearer (in_touch), or let the run go on"
LATE = "the sheet was not held before: put it nearer, or let it start in_touch"


class Worst(NamedTuple):
    """What a tool lacked most between two looks at a run [s], and the largest force that it met [N], and when [s]."""

    idle: float = 0.0
    idle_time: float | None = None
    peak: float = 0.0
    peak_time: float | None = None


NOTHING = Worst()


class BouncingHolder(Guard):
    """Holders and punches driven by a force that bounce off the sheet, land late, or fly."""

    name = "bouncing_holder"
    watches = "the force that force-driven tools carry, in every step"
    lasting = True

    def __init__(self) -> None:
        self._last: dict[str, np.ndarray] | None = None
        self._told: set[int] = set()
        self._worst: dict[int, Worst] = {}

    def watch(self, frame: Frame, ledger: Ledger) -> None:
        """Tell a running command the first time that a tool which has landed does not carry its force."""
        last, self._last = self._last, ledger.watched()
        if last is None:
            return
        gained = {name: values - last[name] for name, values in self._last.items()}
        for k, idle in enumerate(gained["idle"]):
            worst = self._worst.get(k, NOTHING)
            if idle > worst.idle:
                worst = worst._replace(idle=float(idle), idle_time=frame.time)
            if self._last["peak"][k] > worst.peak:
                worst = worst._replace(peak=float(self._last["peak"][k]), peak_time=frame.time)
            self._worst[k] = worst
        for k, wanted in enumerate(gained["wanted_impulse"]):
            share = gained["carried_impulse"][k] / wanted if wanted > 0.0 else 1.0
            # the landing itself is in the first look
            if share < LEAST_SHARE and last["wanted"][k] > 0.0 and k not in self._told:
                self._told.add(k)
                name = ledger.tool_names[k]
                logger.warning("at %.4g s %s carries %.0f %% of its force", frame.time, name, 1e2 * share)

    def memory(self) -> Mapping[str, Any]:
        """The last look at the tools, and those that were told."""
        worst = [[k, *found] for k, found in self._worst.items()]
        return {"last": self._last, "told": sorted(self._told), "worst": worst}

    def recall(self, memory: Mapping[str, Any]) -> None:
        """Take them back."""
        self._last, self._told = memory["last"], set(memory["told"])
        self._worst = {k: Worst(*found) for k, *found in memory["worst"]}

    def after(self, run: Judged) -> Iterable[Doubt]:
        """Tools that carried less than half of their force for long, or far more, or that landed late."""
        return self._judged(run, 0.0)

    def so_far(self, run: Judged) -> Iterable[Doubt]:
        """The same of shares of the whole run, which stay beyond a limit; a peak is judged against the largest force
        that was wanted, which may be to come.
        """
        return self._judged(run, run.run.info.duration)

    def _judged(self, run: Judged, least_time: float) -> Iterable[Doubt]:
        """Times without the force are over the time that a tool was driven, but at least over ``least_time`` [s]."""
        watched, finished = run.extremes.tools, run.run.outcome is Outcome.FINISHED
        for k, (name, met) in enumerate(zip(run.run.info.tool_names, run.extremes.touched, strict=True)):
            if finished and not met:
                continue  # ``never_touched`` speaks
            wanted, time, waited = (watched[key][k] for key in ("most_wanted", "wanted", "waited"))
            if not (wanted > 0.0 and time + waited > 0.0):
                continue
            if not met:
                time, waited = waited, 0.0
            if not met and least_time > 0.0:
                continue  # it may meet the sheet yet
            idle = watched["idle"][k] / max(time, least_time) if met and time > 0.0 else 1.0
            peak = watched["peak"][k] / wanted if least_time == 0.0 else 0.0
            if idle > LARGEST_IDLE or peak > LARGEST_PEAK:
                impulse = watched["wanted_impulse"][k]
                share = watched["carried_impulse"][k] / impulse if impulse > 0.0 else 0.0
                yield self.doubt(
                    Level.DO_NOT_USE if idle > USELESS_IDLE or peak > USELESS_PEAK else Level.WARNING,
                    f"{name} carried less than half of its force for {idle:.0%} of the time, {share:.0%} of it on "
                    f"average, and {watched['peak'][k]:.4g} N at its peak, where {wanted:.4g} N were wanted",
                    NOT_THERE if not met else BOUNCES if idle > LARGEST_IDLE else LANDS_HARD,
                    time=self._time(k, idle > LARGEST_IDLE) if met else None,
                    value=float(idle),
                    limit=LARGEST_IDLE,
                )
            late = waited / max(time + waited, least_time)
            if met and late > LONGEST_WAIT:
                yield self.doubt(
                    Level.DO_NOT_USE if late > USELESS_IDLE else Level.WARNING,
                    f"{name} met the sheet only after {waited:.4g} s, {late:.0%} of the time that it was driven",
                    LATE,
                    value=float(late),
                    limit=LONGEST_WAIT,
                )

    def _time(self, tool: int, idle: bool) -> float | None:
        """When a tool lacked its force for longest, or had its peak [s]."""
        worst = self._worst.get(tool, NOTHING)
        return worst.idle_time if idle else worst.peak_time


class WaitingStroke(Guard):
    """Strokes that waited at their largest force, so that a run ends short of them."""

    name = "waiting_stroke"
    watches = "strokes with a largest force"

    def after(self, run: Judged) -> Iterable[Doubt]:
        """Tools that are behind their strokes."""
        info = run.run.info
        for k, (name, tool) in enumerate(zip(info.tool_names, run.run.model.setup.tools, strict=True)):
            limit = tool.motion.limiting_force
            if not limit:
                continue
            frame = run.run.frame
            goal = tool.motion.displacement_at(frame.time)
            short = abs(goal - float(frame.tool_displacement[k]))
            if short > LEAST_LACK:
                yield self.doubt(
                    Level.NOTE,
                    f"{name} is {1e3 * short:.3g} mm short of its stroke, since it waited at its largest force of "
                    f"{limit:.4g} N",
                    "let it push with more, or give it more time, if it should go on",
                    value=short,
                )
