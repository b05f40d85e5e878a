"""Prepare a run for its next stage: a model of that stage on the state of the run."""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from ...engine.model import Model
from ...engine.staging.derive import stage_setup
from ...engine.stepper import Stepper
from ...errors import InputError, RunError
from ..ledger import Ledger, StageBook
from ..start import Prepared
from .change import change_state, refuse_overlap

if TYPE_CHECKING:
    from ..simulation import Simulation

logger = logging.getLogger(__name__)


def begin_stage(simulation: Simulation) -> None:
    """Go on to the next stage of a run, from the last frame of a stage, which is that of the present state.

    Raises:
        RunError: a tool that cannot begin to act where it is.
    """
    prepared, course, frame = simulation.prepare(), simulation.stages, simulation.frame
    course.finish(frame, prepared.model.setup)
    simulation.watch.look(frame, last=True)
    last, before = course.acting[course.index], prepared.model
    course.go_on(frame, before.setup)
    now = course.acting[course.index]
    model = _model(simulation)
    try:
        change_state(prepared.state, model, last, now)
    except InputError as error:
        raise RunError(f"stage {course.name}: {error}") from None
    refuse_overlap(model, prepared.state, last, now)
    following = _prepared(simulation, model, {})
    if model.setup.solver.target_step != before.setup.solver.target_step:
        following.stepper.refresh_step()
    following.ledger.carry_on(frame.energies, frame.index)
    simulation.enter(following)
    logger.info("%s: stage %s begins at %.6g s", simulation.name, course.name, frame.time)
    simulation.checkpoint()


def stage_memory(simulation: Simulation) -> dict[str, Any]:
    """What a checkpoint keeps of the stages."""
    book = simulation.ledger.stage
    return {"course": simulation.stages.memory(), "carried": book.carried if book else None}


def recall_stage(simulation: Simulation, memory: Mapping[str, Any]) -> None:
    """Have a prepared run be in the stage that ``stage_memory`` found; its state is that of the start still."""
    simulation.stages.recall(memory["course"])
    if simulation.setup.stages:
        simulation.enter(_prepared(simulation, _model(simulation), dict(memory["carried"])))


def _model(simulation: Simulation) -> Model:
    course = simulation.stages
    own = stage_setup(simulation.setup, course.acting[course.index], course.begins)
    return Model(own, simulation.model.samples)


def _prepared(simulation: Simulation, model: Model, carried: dict[str, float]) -> Prepared:
    prepared, course = simulation.prepare(), simulation.stages
    solver = model.setup.solver
    stepper = Stepper(
        model,
        prepared.state,
        thread_counts=prepared.info.thread_counts,
        largest_step=solver.time_step or math.inf,
        step_safety=solver.step_safety,
    )
    stepper.load()
    ledger = Ledger(stepper, StageBook(course.name, course.acting[course.index].tools, carried))
    return replace(prepared, model=model, stepper=stepper, ledger=ledger)
