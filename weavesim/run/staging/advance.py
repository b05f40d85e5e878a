"""Prepare a run for its next stage: a model of that stage on the state of the run."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from ...engine.model import Model
from ...engine.setup import Setup
from ...engine.staging.derive import stage_setup
from ...engine.stepper import Stepper
from ..frame import Frame
from ..ledger import Ledger, StageBook
from ..start import Prepared
from .change import change_state, refuse_overlap
from .course import Course


def next_stage(prepared: Prepared, setup: Setup, course: Course, frame: Frame) -> Prepared:
    """Go on to the next stage, from the last ``frame`` of a stage, which is that of the present state.

    Args:
        prepared: the run in its present stage.
        setup: of the whole run.
        course: of the run, which goes on.
        frame: the last of the stage.
    """
    last, before = course.acting[course.index], prepared.model
    course.go_on(frame, before.setup)
    now = course.acting[course.index]
    model = _model(prepared, setup, course)
    change_state(prepared.state, model, last, now)
    following = _prepared(prepared, model, course, {})
    refuse_overlap(model, prepared.state, last, now)
    if model.setup.solver.target_step != before.setup.solver.target_step:
        following.stepper.refresh_step()
    following.ledger.carry_on(frame.energies, frame.index)
    return following


def in_stage(prepared: Prepared, setup: Setup, course: Course, carried: Mapping[str, float]) -> Prepared:
    """A prepared run in the present stage of ``course``, whose ledger goes on from ``carried``; the state stays."""
    return _prepared(prepared, _model(prepared, setup, course), course, dict(carried))


def stage_memory(prepared: Prepared, course: Course) -> dict[str, Any]:
    """What a checkpoint keeps of the stages."""
    return {"course": course.memory(), "carried": prepared.ledger.stage.carried if prepared.ledger.stage else None}


def _model(prepared: Prepared, setup: Setup, course: Course) -> Model:
    own = stage_setup(setup, course.acting[course.index], course.begins)
    return Model(own, prepared.model.samples)


def _prepared(prepared: Prepared, model: Model, course: Course, carried: dict[str, float]) -> Prepared:
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
