"""Checks of the stages of a run: names that exist, motions that fit, and ends that can come."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...errors import did_you_mean
from ...process.grippers import MOVES_ANCHORS, moves_anchors
from ...process.motions.paths import PathMotion, Pose
from ...process.stages import AtForce, AtRest, AtStroke, Move, Stage
from ...process.strokes import ForceDriven
from .acting import Acting, Given, Parts, acting_in
from .trimming import check_trims

if TYPE_CHECKING:
    from ...process.supports import Support
    from ...sheet.sheet import Sheet

# A stage that ends at rest is looked at so often.
LOOK_COUNT = 100
# What a motion may be off zero at its start, over its largest displacement.
NO_START = 1.0e-12


def check_stages(
    stages: Sequence[Stage], parts: Parts, sheets: Sequence[Sheet], touching: frozenset[str] = frozenset()
) -> None:
    """Check the stages of a run against what it has; ``touching`` has the names of sheets that meet others.

    Raises:
        ValueError: a name that is not there, a motion that does not fit, or an end that can never come.
    """
    for stage in stages:
        _check_names(stage, parts, sheets)
    acts = acting_in(stages, parts)
    for now, before in zip(acts, [None, *acts], strict=False):
        _check_grippers(now, before, parts)
        _check_motions(now, before, parts)
        _check_end(now, stages)
    check_trims(acts, sheets, touching)
    for tool in parts.tools:
        if not any(tool.name in now.tools for now in acts):
            raise ValueError(
                f"stages: tool {tool.name} acts in none of them; add it to the tools of one, or leave it out"
            )


def _refuse(stage: Stage, text: str) -> None:
    raise ValueError(f"stage {stage.name}: {text}")


def _known(stage: Stage, what: str, name: str, known: Iterable[str]) -> None:
    names = list(known)
    if name not in names:
        there = f"there are {', '.join(names)}" if names else "the run has none"
        _refuse(stage, f"there is no {what} {name!r}; {there}{did_you_mean(name, names)}")


def _check_names(stage: Stage, parts: Parts, sheets: Sequence[Sheet]) -> None:
    names = dict(zip(_KINDS, parts.names, strict=True))
    for what, given in zip(_KINDS, (stage.tools, stage.supports, stage.grippers), strict=True):
        for name in given or ():
            _known(stage, what, name, names[what])
    for move in stage.moves:
        having = [what for what in _KINDS if move.name in names[what]]
        if not having:
            _known(stage, "tool, support or gripper", move.name, [name for own in names.values() for name in own])
        if len(having) > 1:
            _refuse(stage, f"{move.name} is the name of a {' and of a '.join(having)}; give one of them another name")
    if stage.end is not None and stage.end.tool_name is not None:
        _known(stage, "tool", stage.end.tool_name, names["tool"])
    for pressed in stage.pressures or ():
        if pressed.sheet is None and len(sheets) > 1:
            _refuse(stage, f"pressures: sheet is required, one of {', '.join(sheet.name for sheet in sheets)}")
        if pressed.sheet is not None:
            _known(stage, "sheet", pressed.sheet, [sheet.name for sheet in sheets])
        own = next(sheet for sheet in sheets if pressed.sheet in (None, sheet.name))
        try:
            pressed.pressure.check_elements(own.blank.element_count)
        except ValueError as error:
            _refuse(stage, str(error))


_KINDS = ("tool", "support", "gripper")


def _check_grippers(now: Acting, before: Acting | None, parts: Parts) -> None:
    for gripper in parts.grippers:
        if before is None and gripper.name not in now.grippers:
            _refuse(now.stage, f"gripper {gripper.name} must pull from the start; release it in a later stage")
        if before is not None and gripper.name in now.grippers - before.grippers:
            _refuse(now.stage, f"gripper {gripper.name} cannot pull again: once released, it stays open")


def _check_motions(now: Acting, before: Acting | None, parts: Parts) -> None:
    stage, moved = now.stage, [move.name for move in now.stage.moves]
    for name in sorted(now.tools - (before.tools if before else now.tools)):
        if name not in moved and before is not None and before.tool_motions[name].since > 0:
            _refuse(stage, f"tool {name} acts again, and needs a move: a motion, or Fixed() to stay where it is")
    supports = {support.name: support for support in parts.supports}
    for move in stage.moves:
        if move.name in now.tool_motions:
            if move.name not in now.tools:
                _refuse(stage, f"tool {move.name} is moved, but does not act; add it to tools, or leave the move out")
            if not move.motion.moves_tools:
                _refuse(stage, f"move {move.name}: {type(move.motion).__name__} does not move tools; take a Stroke")
            if move.motion.by_force and not isinstance(move.motion.along_axis, ForceDriven):
                _refuse(stage, f"move {move.name}: of the motions by a force only ForceDriven can begin in a stage")
        elif move.name in supports:
            _check_drive(stage, move, supports[move.name])
        elif not moves_anchors(move.motion):
            _refuse(stage, f"move {move.name}: {MOVES_ANCHORS} for anchors")
        if isinstance(move.motion, PathMotion):
            _check_path(stage, move.name, move.motion)
        if not move.motion.by_force:
            _check_start(stage, move)


def _check_drive(stage: Stage, move: Move, support: Support) -> None:
    if len(support.drives) != 1:
        _refuse(
            stage, f"move {move.name}: the support has {len(support.drives)} drives, and only a single one is moved"
        )
    if not move.motion.moves_supports:
        _refuse(stage, f"move {move.name}: a support moves by a Stroke or a SmoothStroke")


def _check_start(stage: Stage, move: Move) -> None:
    displacements = move.motion.curve()[1] if move.motion.moves_tools else move.motion.pieces()[1][:, 0]
    start = move.motion.displacement_at(0.0) if move.motion.moves_tools else displacements[0]
    if abs(start) > NO_START * float(np.abs(displacements).max(initial=0.0)):
        _refuse(
            stage,
            f"move {move.name} is at {start:.4g} m when the stage begins; it must start from 0, which is where "
            f"{move.name} then stands",
        )


def _check_path(stage: Stage, name: str, motion: PathMotion) -> None:
    way, angle = motion.state_at(0.0)
    if np.linalg.norm(way) > 0.0 or angle != 0.0:
        _refuse(
            stage,
            f"move {name}: its path is {1e3 * float(np.linalg.norm(way)):.4g} mm away, and it has turned by "
            f"{math.degrees(angle):.4g} degrees, when the stage begins; both must start from 0, which is where {name} "
            "then stands",
        )
    if motion.placed != Pose().numbers:
        _refuse(stage, f"move {name}: placed is where the stage finds it; leave it out")


# ------------------------------------------------------------------------------------------------ ends that can come


def _check_end(now: Acting, stages: Sequence[Stage]) -> None:
    end, stage = now.stage.end, now.stage
    if end is None:
        return
    if end.tool_name is not None and end.tool_name not in now.tools:
        _refuse(stage, f"it can never end by {end.tool_name}, which does not act in it; add it to tools")
    if isinstance(end, AtStroke):
        given = now.tool_motions[end.tool]
        if not given.motion.by_force:
            most = _largest_travel(given, now, stages, 1.0 if end.displacement > 0.0 else -1.0)
            if most < abs(end.displacement) * (1.0 - 1.0e-9):
                _refuse(
                    stage,
                    f"it can never end at a stroke of {end.displacement:.4g} m: {end.tool} moves by at most "
                    f"{most:.4g} m that way within its {stage.duration:.4g} s; take a larger stroke or duration, or an "
                    "earlier end",
                )
    if isinstance(end, AtForce):
        motion = now.tool_motions[end.tool].motion
        most = float(np.abs(motion.curve()[1]).max()) if motion.by_force else motion.limiting_force or np.inf
        if most < end.force:
            _refuse(
                stage,
                f"it can never end at {end.force:.4g} N: {end.tool} is pushed by at most {most:.4g} N; take a smaller "
                "force, or push with more",
            )
    if isinstance(end, AtRest):
        for name in sorted(now.tools):
            if _always_moves(now.tool_motions[name], now, stages):
                _refuse(
                    stage,
                    f"it can never come to rest: {name} moves for all of its {stage.duration:.4g} s; take a longer "
                    "duration, or another end",
                )


def _latest(given: Given, now: Acting, stages: Sequence[Stage]) -> float:
    """Latest time on a motion at which a stage can begin [s]."""
    return float(sum(stage.duration for stage in stages[given.since : now.index]))


def _largest_travel(given: Given, now: Acting, stages: Sequence[Stage], sign: float) -> float:
    """Furthest that a stroke goes to one side within a stage, whenever that begins [m]."""
    latest, duration = _latest(given, now, stages), now.stage.duration
    times = np.unique(
        np.concatenate([np.linspace(0.0, latest + duration, 20 * LOOK_COUNT + 1), given.motion.curve()[0]])
    )
    times = times[(times >= 0.0) & (times <= latest + duration)]
    at = sign * np.interp(times, *given.motion.curve())
    if latest == 0.0:
        return float(at.max() - at[0])
    return float((at - np.minimum.accumulate(at)).max())


def _always_moves(given: Given, now: Acting, stages: Sequence[Stage]) -> bool:
    """Whether a stroke moves at all times of a stage that begins at the latest."""
    begin = _latest(given, now, stages)
    if isinstance(given.motion, PathMotion):
        rates = [given.motion.rates_at(time) for time in begin + np.linspace(0.0, now.stage.duration, LOOK_COUNT)]
        if all(np.any(speed) or np.any(spin) for speed, spin in rates):
            return True
    if given.motion.by_force:
        return False
    at = np.interp(begin + np.linspace(0.0, now.stage.duration, LOOK_COUNT + 1), *given.motion.curve())
    return bool(len(at) and (np.diff(at) != 0.0).all())
