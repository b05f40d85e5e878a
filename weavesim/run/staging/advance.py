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
from .waste import clear_waste, cut_sheets, waste_of

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
    if not course.ended[-1]["reached"]:  # a guard tells more at the end of the run, which may be hours away
        logger.warning(
            "%s: stage %s took all of its time, to %.6g s; its end was not reached",
            simulation.name,
            course.name,
            frame.time,
        )
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
    if now.stage.trims:
        try:
            following = trim(simulation, following, frame.index)
        except ValueError as error:
            raise RunError(f"stage {course.name}: trim at {frame.time:.4g} s: {error}") from None
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


def trim(simulation: Simulation, whole: Prepared, index: int) -> Prepared:
    """Trim the sheets of a run at the begin of its present stage.

    Args:
        simulation: whose course is in that stage.
        whole: the stage with the sheets as they were.
        index: of the last frame.

    Raises:
        ValueError: a trim that leaves nothing or several pieces, or cuts away what a gripper holds.
    """
    course, state = simulation.stages, whole.state
    before = whole.ledger.frame(index).energies
    for each in cut_sheets(course.acting[course.index], whole.model, state, course.kept):
        lost = waste_of(each, whole.model, state)
        course.kept[each.sheet] = each.kept
        model = _model(simulation)
        clear_waste(state, model)
        whole = _prepared(simulation, model, {})
        whole.stepper.refresh_step()
        whole.ledger.carry_on(before, index, trimmed=True)
        after = whole.ledger.frame(index).energies
        energy = after["trimmed_energy"] - before["trimmed_energy"]
        course.trimmed.append({"stage": course.name, "time_s": state.time, "energy_j": energy, **lost})
        before = after
    return whole


def _model(simulation: Simulation) -> Model:
    course = simulation.stages
    own = stage_setup(simulation.setup, course.acting[course.index], course.begins)
    return Model(own, simulation.model.samples, course.kept)


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
    book = StageBook(course.name, course.acting[course.index].tools, carried, simulation.setup.trims)
    ledger = Ledger(stepper, book)
    return replace(prepared, model=model, stepper=stepper, ledger=ledger)
