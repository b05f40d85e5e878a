"""Stages whose end never came, and strokes that a stage left unfinished."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from ....process.stages import AtForce, AtRest, AtStroke, StageEnd
from ..guard import Doubt, Guard, Level, Start

if TYPE_CHECKING:
    from ...verdict import Judged

# What a stroke may be short of unnoticed [mm].
LEAST_LACK = 1.0e-3


class StageEnds(Guard):
    """Stages that took all of their time, though something else should have ended them."""

    name = "stage_ends"
    watches = "whether every stage came to the end that was wanted"

    def before(self, start: Start) -> Iterable[Doubt]:
        """Stages that end at rest, but have nothing that stops the sheets."""
        for phase in start.phases:
            undamped = all(world.dynamics.damping == 0.0 for world in phase.setup.worlds)
            if isinstance(phase.end_by, AtRest) and undamped:
                yield self.doubt(
                    Level.WARNING,
                    f"stage {phase.name} ends at rest, but has no damping",
                    "it may swing for all of its duration: give it a damping",
                )

    def after(self, run: Judged) -> Iterable[Doubt]:
        """Ends that did not come, and strokes that a stage with another end cut off."""
        for stage, told in zip(run.run.setup.stages, run.run.stages.ended, strict=False):
            if not told["reached"] and stage.end is not None:
                yield self.doubt(
                    Level.WARNING,
                    f"stage {stage.name} took all of its {stage.duration:.4g} s: {_missed(stage.end)}",
                    _advice(stage.end),
                    time=told["end_s"],
                )
            if told["ended_by"] == "duration" and told is not run.run.stages.ended[-1]:
                for name, behind in told["behind_mm"].items():
                    if behind > LEAST_LACK:
                        yield self.doubt(
                            Level.NOTE,
                            f"stage {stage.name} ended with {name} {behind:.3g} mm short of its stroke, since it "
                            "waited at its largest force",
                            "let it push with more, or give the stage more time, if it should have gone on",
                            time=told["end_s"],
                            value=1e-3 * behind,
                        )


def _missed(end: StageEnd) -> str:
    if isinstance(end, AtStroke):
        return f"{end.tool} did not get as far as {end.displacement:.4g} m"
    if isinstance(end, AtForce):
        return f"{end.tool} did not meet a force of {end.force:.4g} N"
    return "rest never came"


def _advice(end: StageEnd) -> str:
    if isinstance(end, AtRest):
        return "the next stage began on a moving sheet: give it more damping or a longer duration"
    return "the next stage began without it: give the tool more way, or the stage a longer duration"
