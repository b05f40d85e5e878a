"""Prepare a run from a set-up: data on the device, kernels loaded, and checks that need the device."""

from __future__ import annotations

import logging
import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..device import exclusive, resolve_thread_counts
from ..engine.model import Model
from ..engine.setup import Setup
from ..engine.staging.derive import acting_of
from ..engine.state import State
from ..engine.stepper import Stepper
from ..errors import InputError
from ..fabric.cell import UnitCell
from ..kernel_cache import hashed_once
from ..tools.sampling import mesh_parts
from .estimate import check_bounds, estimate
from .frame import Frame, RunInfo, SheetFrame, SheetInfo, new_run_id
from .guards import Guards, Level, Start
from .ledger import Ledger, StageBook
from .staging.change import start_state
from .staging.rehearsal import mean_step, phases_of
from .touching import start_in_touch

logger = logging.getLogger(__name__)

# Forces of the undeformed sheet above this share of the unit cell's stiffness are more than rounding.
LARGEST_REST_FORCE = 1.0e-4


@dataclass(frozen=True)
class Prepared:
    """A run at time zero.

    Attributes:
        model, state, stepper, ledger: of the run.
        info: for its observers.
        frame: the undeformed state, with the fields that kernels write.
        guards: of the run, asked what they know so far.
    """

    model: Model
    state: State
    stepper: Stepper
    ledger: Ledger
    info: RunInfo
    frame: Frame
    guards: Guards

    @cached_property
    def whole_frame(self) -> Frame:
        """``frame`` with every field, before anything else is done with the state; waits for the device."""
        with exclusive():
            return self.ledger.completed(self.frame)


def prepare(setup: Setup, run_id: str | None = None) -> Prepared:
    """Make a run ready, with a new run id unless one is given.

    Raises:
        InputError: bad input that can only be detected on the device: an unstable step, a tool that overlaps the
            sheet, a unit cell that carries force at rest, a mesh that cannot be sampled.
    """
    check_bounds(estimate(setup), setup)
    course = acting_of(setup) if setup.stages else []
    phases = phases_of(setup)
    model = Model(phases[0].setup)
    state = State.initial(model)
    if course:
        start_state(state, model, course[0])
    solver = setup.solver
    thread_counts = resolve_thread_counts(solver.threads) if model.device.is_cpu else (1,)
    stepper = Stepper(
        model,
        state,
        thread_counts=thread_counts,
        largest_step=solver.time_step or math.inf,
        step_safety=solver.step_safety,
    )
    stepper.load()
    start_in_touch(model, state)
    stepper.start()
    stable = stepper.stable_step()
    if solver.time_step is not None and solver.time_step > stable:
        raise InputError(
            f"time_step = {solver.time_step:.4g} s is unstable for this mesh and fabric: at most {stable:.4g} s "
            "is stable; use that, a coarser mesh, or mass scaling (target_step)"
        )
    expected = estimate(
        setup,
        time_step=min(mean_step(phases, model, stable), solver.time_step or math.inf),
        thread_count=thread_counts[-1],
        is_cpu=model.device.is_cpu,
    )
    check_bounds(expected, setup)
    logger.info("%s takes %s", setup.name, expected)
    book = StageBook(course[0].stage.name, course[0].tools, {}, setup.trims) if course else None
    ledger = Ledger(stepper, book)
    frame = ledger.frame(0)
    for sheet, first in zip(setup.sheets, frame.sheets, strict=True):
        check_cell_at_rest(sheet.fabric.unit_cell, first)
    guards = Guards()
    doubts = guards.before(Start(model, ledger, frame, phases, setup.accept_unusual))
    info = RunInfo(
        name=setup.name,
        setup=setup,
        expected=expected,
        sheets=tuple(sheet_infos(setup)),
        tools=setup.tools,
        supports=setup.supports,
        grippers=setup.grippers,
        duration=setup.duration,
        frame_count=sum(setup.frame_counts),
        device=str(model.device),
        precision=model.precision.value,
        thread_counts=thread_counts,
        internal_energies=ledger.internal,
        warnings=[doubt.message for doubt in doubts if doubt.level > Level.NOTE],
        notes=(
            *mesh_notes(model),
            *_scaling_notes(setup),
            *(doubt.message for doubt in doubts if doubt.level == Level.NOTE),
        ),
        run_id=run_id or new_run_id(),
    )
    return Prepared(model, state, stepper, ledger, info, frame, guards)


def _scaling_notes(setup: Setup) -> Iterator[str]:
    if setup.solver.mass_scaling is not None:
        yield "; ".join(line.strip() for line in setup.solver.mass_scaling.report().split("\n"))


class PreparedOnce:
    """What a run has as soon as something of it is used, for ``Simulation``.

    Args:
        setup: of the run.
        run_id: of a run that is resumed; a new one by default.

    Attributes:
        setup: as given.
    """

    def __init__(self, setup: Setup, run_id: str | None = None) -> None:
        self.setup = setup
        self._run_id = run_id
        self._prepared: Prepared | None = None

    def prepare(self) -> Prepared:
        """Make the run ready, once: constants and state on the device, kernels loaded, the start checked.

        Raises:
            InputError: bad input that can only be detected on the device, such as an unstable step.
        """
        if self._prepared is None:
            with exclusive(), hashed_once():
                self._prepared = prepare(self.setup, self._run_id)
        return self._prepared

    @property
    def model(self) -> Model:
        """Constants, of the present stage."""
        return self.prepare().model

    @property
    def state(self) -> State:
        """Everything that changes in the run."""
        return self.prepare().state

    @property
    def stepper(self) -> Stepper:
        """Advances the state."""
        return self.prepare().stepper

    @property
    def ledger(self) -> Ledger:
        """Takes frames."""
        return self.prepare().ledger

    @property
    def info(self) -> RunInfo:
        """What observers receive."""
        return self.prepare().info


def sheet_infos(setup: Setup) -> Iterator[SheetInfo]:
    """Information about every sheet, for the observers."""
    tool_count = support_count = 0
    for world in setup.worlds:
        tools = tuple(range(tool_count, tool_count + len(world.tools)))
        tool_count += len(world.tools)
        for sheet in world.sheets:
            supports = tuple(range(support_count, support_count + len(sheet.supports)))
            support_count += len(sheet.supports)
            blank = world.symmetry.upright(sheet.oriented_blank)
            yield SheetInfo(
                sheet.name, blank, sheet.fabric, world.symmetry, tools, supports, world.name,
                world.dynamics.contact_thickness == "current",
            )  # fmt: skip


def check_cell_at_rest(cell: UnitCell, frame: SheetFrame) -> None:
    """Check that the undeformed sheet carries no force, which a user-defined unit cell may violate."""
    largest = LARGEST_REST_FORCE * max(*cell.yarn_stiffness_per_width, cell.shear_stiffness)
    found = max(float(np.abs(frame.fields[name]).max()) for name in ("warp_force", "weft_force", "shear_moment"))
    if not found <= largest:
        raise InputError(
            f"unit cell {type(cell).__name__}: the undeformed sheet carries {found:.4g} N/m, but at stretches of "
            "1, a shear angle of 0 and its initial_unknowns a cell must be free of force: correct its energy or those"
        )


def mesh_notes(model: Model) -> Iterator[str]:
    """Notes on the meshes of sheets and tools that were read from files, and the accuracy of the tools' sampling."""
    for world in model.setup.worlds:
        for sheet in world.sheets:
            yield from sheet.blank.source_notes
    for surface in mesh_parts(model.setup.tools).values():
        yield from surface.notes()
        yield model.samples[surface].note(surface.name)
