"""All stages of a run before it starts, each taking its whole duration."""

from __future__ import annotations

from dataclasses import dataclass

from ...engine.model import Model
from ...engine.setup import Setup
from ...engine.staging.derive import acting_of, planned_begins, stage_setup
from ...process.stages import StageEnd


@dataclass(frozen=True)
class Phase:
    """A stage as it is planned, or a run without stages.

    Attributes:
        setup: of the stage alone, in the time of the run.
        tools: names of those that act.
        begin, end: [s].
        name: of the stage; empty without stages.
        end_by: what ends it before that, if anything does.
    """

    setup: Setup
    tools: frozenset[str]
    begin: float
    end: float
    name: str = ""
    end_by: StageEnd | None = None


def phases_of(setup: Setup) -> tuple[Phase, ...]:
    """The stages of a run, or the run itself if it has none.

    Raises:
        InputError: a stage whose values do not fit each other.
    """
    if not setup.stages:
        return (Phase(setup, frozenset(tool.name for tool in setup.tools), 0.0, setup.duration),)
    course = acting_of(setup)
    begins = planned_begins(setup, course)
    return tuple(
        Phase(
            stage_setup(setup, now, begins[: now.index + 1]),
            now.tools,
            begins[now.index].time,
            begins[now.index].time + now.stage.duration,
            now.stage.name,
            now.stage.end,
        )
        for now in course
    )


def mean_step(phases: tuple[Phase, ...], model: Model, step: float) -> float:
    """Mean time step over all stages [s], which differ in their added mass.

    Args:
        phases: all stages.
        model: of the first.
        step: stable step of the first [s].
    """
    if len(phases) == 1:
        return step
    found = {phases[0].setup.solver.target_step: 1.0}
    count = 0.0
    for phase in phases:
        target = phase.setup.solver.target_step
        if target not in found:
            found[target] = Model(phase.setup, model.samples).reference_step / model.reference_step
        count += (phase.end - phase.begin) / (step * found[target])
    return (phases[-1].end - phases[0].begin) / count
