"""How a run ended: its exit code, and what the user is told.

Imports of other rooms are inside the functions, which keeps ``weavesim --help`` fast.
"""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator, Mapping
from enum import IntEnum
from pathlib import Path
from typing import Any

# A shell reports a process that a signal ended with this plus the number of the signal.
SIGNALLED = 128


class ExitCode(IntEnum):
    """Exit codes of the command line; a run that was interrupted ends with 128 plus the number of the signal."""

    FINISHED = 0
    RUN_ERROR = 1
    INPUT_ERROR = 2
    DO_NOT_USE = 3
    MISSING = 4
    BEYOND_LIMITS = 5
    STOPPED = 6


def interrupted_code(number: int) -> int:
    """Exit code after a signal: 130 for Ctrl-C, 143 for SIGTERM, 129 for SIGHUP."""
    return SIGNALLED + number


def summaries(result: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
    """The summaries in what ``Scene.run`` returns: one, or one per case."""
    yield from _cases(result).values() or [result]


def _cases(result: Mapping[str, Any]) -> dict[str, Mapping[str, Any]]:
    """Summaries by case; none if there is one for the whole result."""
    return {name: value for name, value in result.items() if isinstance(value, Mapping) and "outcome" in value}


def exit_code(result: Mapping[str, Any], number: int | None) -> int:
    """Exit code for what ``Scene.run`` returned.

    Args:
        result: a summary, or the summaries by case.
        number: of the signal that the run received; None for none.
    """
    from ..run.frame import Outcome
    from ..run.guards.guard import VERDICTS, Level

    every = list(summaries(result))
    outcomes = {one.get("outcome", Outcome.FINISHED.value) for one in every}
    if number is not None:
        return interrupted_code(number)
    if Outcome.INTERRUPTED.value in outcomes:
        return interrupted_code(signal.SIGINT)
    if Outcome.STOPPED.value in outcomes:
        return ExitCode.STOPPED
    if outcomes != {Outcome.FINISHED.value}:
        return ExitCode.RUN_ERROR
    if any(one.get("verdict") == VERDICTS[Level.DO_NOT_USE] for one in every):
        return ExitCode.DO_NOT_USE
    if any(one.get("missing") for one in every):
        return ExitCode.MISSING
    return ExitCode.FINISHED


def closing_lines(result: Mapping[str, Any], out: Path, number: int | None) -> Iterator[str]:
    """What the user is told at the end; arguments as ``exit_code``, and the folder."""
    from ..run.frame import Outcome
    from ..run.guards.guard import VERDICTS, Level

    every = list(summaries(result))
    missing = list(dict.fromkeys(name for one in every for name in one.get("missing") or ()))
    outcomes = {one.get("outcome", Outcome.FINISHED.value) for one in every}
    if Outcome.INTERRUPTED.value in outcomes:
        start = f"Interrupted{_by(number)}; results so far are kept. "
    elif guards := list(dict.fromkeys(one["stopped_by"] for one in every if "stopped_by" in one)):
        start = f"Stopped by the guard {', '.join(guards)}, as wanted (stop_on); results so far are kept. "
    elif number is not None:
        start = f"Finished, although interrupted{_by(number)} at the end. "
    else:
        start = "" if outcomes == {Outcome.FINISHED.value} else "Stopped early. "
    if missing:
        yield f"{start}Not all results could be written: {', '.join(missing)} missing. The others are in {out}."
    else:
        yield f"{start}Results are in {out}."
    for one in every:
        for stage in one.get("stages") or ():
            yield f"Stage {stage['name']}: {_stage_end(stage)}."
    for one in every:
        if "springback_mm" in one:
            yield (
                f"Springback: {one['springback_mm']:.3g} mm, largest shear angle "
                f"{one['springback_max_shear_angle_deg']:+.3g} degrees from {one['formed_max_shear_angle_deg']:.3g}."
            )
    if any(one.get("verdict") == VERDICTS[Level.DO_NOT_USE] for one in every):
        yield "Do not use the result: see its warnings."
    if _can_go_on(result, out):
        yield f"Go on with it{' all the same' if Outcome.STOPPED.value in outcomes else ''}: weavesim resume {out}"
    for report in _reports(result, out):
        yield f"Open {report} in a browser."


def _stage_end(stage: Mapping[str, Any]) -> str:
    """What ended a stage, when, and where the leading tool then was."""
    by = {"force": "ended by its force", "stroke": "ended by its stroke", "rest": "came to rest"}
    how = by.get(stage["ended_by"], "took its time" if stage["reached"] else "took its time; its end was not reached")
    return f"{how}, at {1e3 * stage['end_s']:.4g} ms and a stroke of {stage['stroke_mm']:.4g} mm"


def _can_go_on(result: Mapping[str, Any], out: Path) -> bool:
    """Whether a run has left checkpoints."""
    from ..run.checkpoint.checkpoints import has_job

    return any(has_job(folder) for folder in [out, *(out / case for case in _cases(result))])


def _reports(result: Mapping[str, Any], out: Path) -> Iterator[Path]:
    """Reports of this run, not of others below its folder."""
    for folder, summary in zip(case_folders(result, out), summaries(result), strict=True):
        # one that could not be written to its end may still be there from the middle of the run
        if os.path.isfile(folder / "report.html") and "report.html" not in (summary.get("missing") or ()):
            yield folder / "report.html"


def case_folders(result: Mapping[str, Any], out: Path) -> list[Path]:
    """Folders of the runs of a result: that of the only one, or one for each case."""
    return [out / case for case in _cases(result)] or [out]


def _by(number: int | None) -> str:
    return f" by {signal.Signals(number).name}" if number is not None and number != signal.SIGINT else ""
