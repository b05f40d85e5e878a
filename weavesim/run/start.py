"""Prepare a run from a set-up: data on the device, kernels loaded, and checks that need the device."""

from __future__ import annotations

import logging
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..device import resolve_thread_counts
from ..engine.model import Model
from ..engine.setup import Setup, World
from ..engine.state import State
from ..engine.stepper import Stepper
from ..errors import InputError
from ..fabric.cell import UnitCell
from ..sheet.sheet import Sheet
from ..tools.sampling import mesh_parts
from .frame import Frame, RunInfo, SheetFrame, SheetInfo
from .ledger import Ledger
from .sheet_ledger import Penetration

logger = logging.getLogger(__name__)

# Forces of the undeformed sheet above this share of the unit cell's stiffness are more than rounding.
LARGEST_REST_FORCE = 1.0e-4
# With fewer elements along a quarter turn of an edge, the sheet sags over it.
LEAST_ELEMENTS_PER_QUARTER_TURN = 5.0


@dataclass(frozen=True)
class Prepared:
    """A run at time zero.

    Attributes:
        model, state, stepper, ledger: of the run.
        info: for its observers.
        frame: the undeformed state.
        penetration: of that frame.
    """

    model: Model
    state: State
    stepper: Stepper
    ledger: Ledger
    info: RunInfo
    frame: Frame
    penetration: Penetration


def prepare(setup: Setup) -> Prepared:
    """Make a run ready.

    Raises:
        InputError: bad input that can only be detected on the device: an unstable step, a tool that overlaps the
            sheet, a unit cell that carries force at rest, a mesh that cannot be sampled.
    """
    model = Model(setup)
    state = State.initial(model)
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
    stepper.start()
    stable = stepper.stable_step()
    if solver.time_step is not None and solver.time_step > stable:
        raise InputError(
            f"time_step = {solver.time_step:.4g} s is unstable for this mesh and fabric: at most {stable:.4g} s "
            "is stable; use that, a coarser mesh, or mass scaling (target_step)"
        )
    ledger = Ledger(stepper)
    frame = ledger.frame(0)
    for sheet, first in zip(setup.sheets, frame.sheets, strict=True):
        check_cell_at_rest(sheet.fabric.unit_cell, first)
    for sheet_ledger, sheet, first in zip(ledger.sheets, setup.sheets, frame.sheets, strict=True):
        check_overlap(sheet, sheet_ledger.penetration(first).at_nodes)
    info = RunInfo(
        name=setup.name,
        setup=setup,
        sheets=tuple(sheet_infos(setup)),
        tools=setup.tools,
        supports=setup.supports,
        duration=setup.duration,
        frame_count=setup.frame_count,
        device=str(model.device),
        precision=model.precision.value,
        thread_counts=thread_counts,
        internal_energies=ledger.internal,
        warnings=first_warnings(model),
        notes=tuple(mesh_notes(model)),
    )
    return Prepared(model, state, stepper, ledger, info, frame, ledger.penetration(frame))


def sheet_infos(setup: Setup) -> Iterator[SheetInfo]:
    """Information about every sheet, for the observers."""
    tool_count = support_count = 0
    for world in setup.worlds:
        tools = tuple(range(tool_count, tool_count + len(world.tools)))
        tool_count += len(world.tools)
        for sheet in world.sheets:
            supports = tuple(range(support_count, support_count + len(sheet.supports)))
            support_count += len(sheet.supports)
            yield SheetInfo(sheet.name, sheet.oriented_blank, sheet.fabric, world.symmetry, tools, supports)


def check_cell_at_rest(cell: UnitCell, frame: SheetFrame) -> None:
    """Check that the undeformed sheet carries no force, which a user-defined unit cell may violate."""
    largest = LARGEST_REST_FORCE * max(*cell.yarn_stiffness_per_width, cell.shear_stiffness)
    found = max(float(np.abs(frame.fields[name]).max()) for name in ("warp_force", "weft_force", "shear_moment"))
    if not found <= largest:
        raise InputError(
            f"unit cell {type(cell).__name__}: the undeformed sheet carries {found:.4g} N/m, but at stretches of "
            "1, a shear angle of 0 and its initial_unknowns a cell must be free of force: correct its energy or those"
        )


def check_overlap(sheet: Sheet, penetration: float) -> None:
    """Check that no tool overlaps the blank by more than half its thickness before the run starts [m]."""
    thickness = sheet.fabric.thickness
    if penetration > 0.5 * thickness:
        raise InputError(
            f"a tool overlaps the blank by {1e3 * penetration:.3g} mm before the run starts; the sheet is "
            f"{1e3 * thickness:.3g} mm thick: move the tool half a thickness off the mid-surface"
        )


def first_warnings(model: Model) -> list[str]:
    """Warnings for the user before the run, each once."""
    found: list[str] = []
    sheets = iter(model.sheets)
    for world in model.setup.worlds:
        for sheet in world.sheets:
            found += [
                *sheet.fabric.unit_cell.warnings(),
                *_tool_warnings(world, sheet, next(sheets).geometry.area.max()),
            ]
    return list(dict.fromkeys(found))


def _tool_warnings(world: World, sheet: Sheet, largest_area: float) -> Iterator[str]:
    size = float(np.sqrt(largest_area))
    for tool in world.tools:
        count, radius = tool.elements_per_quarter_turn(size), tool.smallest_radius
        if any(part.surface is not None for part in tool.shape.parts()):
            edges = tool.sharp_edges_facing(sheet.oriented_blank.node_position)
            if len(edges):
                place = ", ".join(f"{1e3 * c:.4g}" for c in edges[0])
                yield (
                    f"{tool.name}: {len(edges)} sharp edges face the sheet, one at ({place}) mm; contact is at the "
                    f"sheet's nodes, {size * 1e3:.2g} mm apart, so that a sharp edge comes through between them: "
                    "round it, or use a finer mesh"
                )
            # sharp edges that the sheet does not meet have no radius to be resolved
            radius = tool.fillet_radius
            count = 0.5 * math.pi * radius / size
        if count < LEAST_ELEMENTS_PER_QUARTER_TURN:
            yield (
                f"{tool.name}: {count:.1f} elements of {size * 1e3:.2g} mm along 90 degrees "
                f"of its {radius * 1e3:.3g} mm radius; below five the sheet sags over the edge"
            )


def mesh_notes(model: Model) -> Iterator[str]:
    """Notes on the triangle meshes of the tools, and the accuracy of their sampling."""
    for surface in mesh_parts(model.setup.tools).values():
        yield from surface.notes()
        yield model.samples[surface].note(surface.name)
