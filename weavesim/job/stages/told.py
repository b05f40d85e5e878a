"""Stages in the table of what is known before a run: who acts, what moves, and what ends them."""

from __future__ import annotations

from ...engine.setup import Setup
from ...engine.staging.acting import Acting
from ...engine.staging.derive import acting_of
from ...process.friction import in_words
from ...process.motions.paths import PathMotion
from ...process.stages import AtForce, AtRest, AtStroke, Stage
from ...process.strokes import Motion


def stage_lines(setup: Setup) -> list[tuple[str, str]]:
    """Name of every stage of a job, and what happens in it; forces are those of the whole press, as in the job."""
    if not setup.stages:
        return []
    share = setup.worlds[0].symmetry.share
    return [(now.stage.name, f"{_acts(now, share)}; {end_text(now.stage, share)}") for now in acting_of(setup)]


def _acts(now: Acting, share: float) -> str:
    """Who acts, those that move anew with their motion, and what presses."""
    tools = [name for name in now.tool_motions if name in now.tools]
    parts = [_does(tools, "act")] if tools else ["no tool acts"]
    if now.grippers:
        parts.append(_does(sorted(now.grippers), "pull"))
    if now.supports:
        parts.append(_does(sorted(now.supports), "hold"))
    parts += [f"{move.name} {motion_text(move.motion, share)}" for move in now.stage.moves]
    for pressed in now.stage.pressures or ():
        on = f" on {pressed.sheet}" if pressed.sheet else ""
        parts.append(f"{1e-3 * pressed.pressure.pressures[-1]:.4g} kPa{on}")
    parts += [f"{in_words(each.friction)} of {each.name}" for each in now.stage.friction]
    parts += [f"{trim.sheet or 'the sheet'} is trimmed" for trim in now.stage.trims]
    return ", ".join(parts)


def _does(names: list[str], what: str) -> str:
    return f"{', '.join(names)} {what}{'s' if len(names) == 1 else ''}"


def motion_text(motion: Motion, share: float) -> str:
    """A motion in a few words; ``share`` of the whole is computed, and forces on it are that share."""
    if not motion.moves_tools:
        return "moves"
    if isinstance(motion, PathMotion):
        parts = [] if motion.along.travel_time == 0.0 and not motion.by_force else [motion_text(motion.along, share)]
        if motion.points:
            parts.append(f"follows a path of {len(motion.points)} points")
        if motion.rotation:
            parts.append(f"turns by {motion.rotation.angles[-1]:.4g} degrees")
        return " and ".join(parts or ["stays"])
    _, values = motion.curve()
    if motion.by_force:
        return f"pushed with {values[-1] / share:.4g} N"
    return f"moves by {1e3 * values[-1]:.4g} mm" if values.any() else "stays"


def end_text(stage: Stage, share: float) -> str:
    """What ends a stage; see ``motion_text``."""
    most = f"{1e3 * stage.duration:.4g} ms"
    end = stage.end
    if end is None:
        return f"takes {most}"
    if isinstance(end, AtStroke):
        what = f"{end.tool} has moved {1e3 * end.displacement:.4g} mm"
    elif isinstance(end, AtForce):
        what = f"{end.tool} is pushed with {end.force / share:.4g} N"
    elif isinstance(end, AtRest):
        what = f"at rest (kinetic energy {end.kinetic_share:g} of internal, {end.speed:g} m/s)"
    else:
        what = f"{type(end).__name__} says so"
    return f"ends {'' if isinstance(end, AtRest) else 'when '}{what}, after {most} at the latest"
