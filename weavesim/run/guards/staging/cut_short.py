"""Motions, pressures and releases that are not over when their stage, or the run, ends."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import zip_longest
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ....process.motions.paths import PathMotion
from ..guard import Doubt, Guard, Level, Start

if TYPE_CHECKING:
    from ....process.grippers import Gripper
    from ....process.strokes import Motion
    from ...staging.rehearsal import Phase

# Share of a way, or of a pressure, that may be missing unnoticed.
LARGEST_LACK = 0.01
# Of the end of a stage.
ROUNDING = 1.0e-9


class CutShort(Guard):
    """What a stage or a run does not leave enough time for. Stages that something else ends are not judged."""

    name = "cut_short"
    watches = "whether motions, pressures and releases come to their end within their stages"

    def before(self, start: Start) -> Iterable[Doubt]:
        """Strokes, paths and turns; pressures; grippers that are to open."""
        for phase, following in zip_longest(start.phases, start.phases[1:]):
            if phase.end_by is not None:
                continue
            where = f"stage {phase.name}" if phase.name else "the run"
            for text in (*_motions(phase, following), *_loads(phase, following)):
                yield self.doubt(
                    Level.NOTE, f"{text}, and {where} ends at {phase.end:.4g} s",
                    "give it more time, or say less, if it should come to its end", time=phase.end,
                )  # fmt: skip


def _motions(phase: Phase, following: Phase | None) -> Iterator[str]:
    for number, world in enumerate(phase.setup.worlds):
        for k, tool in enumerate(world.tools):
            later = None if following is None else following.setup.worlds[number].tools[k].motion
            if tool.name in phase.tools:
                yield from _motion(tool.name, tool.motion, later, phase.end)
        for s, sheet in enumerate(world.sheets):
            after = None if following is None else following.setup.worlds[number].sheets[s].grippers
            for k, gripper in enumerate(sheet.grippers):
                if not _is_open(gripper, phase.end):
                    later = after[k].motion if after and not _is_open(after[k], phase.end) else None
                    yield from _motion(gripper.name, gripper.motion, later, phase.end)


def _is_open(gripper: Gripper, time: float) -> bool:
    """Whether a gripper has opened by a time [s], by itself or at the begin of a stage."""
    return gripper.release_time is not None and gripper.release_time <= time


def _motion(name: str, motion: Motion, later: Motion | None, end: float) -> Iterator[str]:
    if _goes_on(motion, later):
        return
    along = motion.along_axis
    if not (along.by_force or along.limiting_force) and along.travel_time > end:
        times, ways = along.curve()
        whole = float(np.ptp(np.append(ways, 0.0)))
        lack, _ = _largest_lack(times, ways, end, along.displacement_at(end))
        if lack > LARGEST_LACK * whole > 0.0:
            yield (
                f"{name} is to move until {along.travel_time:.4g} s, {1e3 * lack:.4g} of its {1e3 * whole:.4g} mm are "
                "missing"
            )
    if isinstance(motion, PathMotion) and motion.carrying_time > end * (1.0 + ROUNDING):
        yield f"{name} is to move along its path or to turn until {motion.carrying_time:.4g} s"


def _largest_lack(times: ArrayLike, values: ArrayLike, end: float, now: float) -> tuple[float, int]:
    """How far what is to come is from what is there at the end, and at which of the times."""
    apart = np.where(np.asarray(times) > end, np.abs(np.asarray(values) - now), 0.0)
    k = int(np.argmax(apart))
    return float(apart[k]), k


def _goes_on(motion: Motion, later: Motion | None) -> bool:
    """Whether a motion is that of the next stage too, which may be given in another way."""
    if later is None:
        return False
    own, next_one = PathMotion.of(motion), PathMotion.of(later)
    if next_one == own:
        return True
    a, b = own.along, next_one.along
    if a.by_force or b.by_force or next_one.model_copy(update={"along": a}) != own:
        return False
    return b.travel_time == a.travel_time and bool(b.curve()[1][-1] == a.curve()[1][-1])


def _loads(phase: Phase, following: Phase | None) -> Iterator[str]:
    for number, world in enumerate(phase.setup.worlds):
        for s, sheet in enumerate(world.sheets):
            later = () if following is None else following.setup.worlds[number].sheets[s].pressures
            for pressure in sheet.pressures:
                if pressure in later:
                    continue
                now = float(np.interp(phase.end, pressure.times, pressure.pressures))
                lack, k = _largest_lack(pressure.times, pressure.pressures, phase.end, now)
                if lack > LARGEST_LACK * max(abs(value) for value in pressure.pressures):
                    yield (
                        f"the pressure on the {pressure.face} of {sheet.name} is to reach {pressure.pressures[k]:.4g} "
                        f"Pa at {pressure.times[k]:.4g} s, it is at {now:.4g} Pa"
                    )
            if following is None:
                for gripper in sheet.grippers:
                    if gripper.release_time is not None and gripper.release_time > phase.end:
                        yield f"{gripper.name} is to open at {gripper.release_time:.4g} s"
