"""From one stage to the next: what changes in the state of a run, beside the constants."""

from __future__ import annotations

import numpy as np

from ...engine.model import Model
from ...engine.plies.pass_state import forget_arguments
from ...engine.staging.acting import Acting
from ...engine.state import SheetState, State
from ...engine.surface.friction import argument_rows
from ...errors import RunError
from ...kernels.rows import VELOCITY_REMAINDER, MotionRow, ToolDriveRow
from ...process.interfaces import Interface
from ...process.strokes import ForceDriven
from ..touching import place_carried, touch_sheets
from ..watch.tool_distance import ToolDistances

# Overlap of a tool that begins to act with a sheet, over its thickness, from which on a stage is refused.
LARGEST_OVERLAP = 0.25


def start_state(state: State, model: Model, first: Acting) -> None:
    """Keep tools that do not act in the first stage out of contact, in a state at time zero."""
    for k, tool in enumerate(model.setup.tools):
        if tool.name not in first.tools:
            _let_go(state, model, k)


def change_state(state: State, model: Model, last: Acting, now: Acting) -> None:
    """Make a state at the end of a stage one at the begin of the next.

    Tools that no longer act lose their contact; supports that take hold stop their nodes.

    Args:
        state: of the run, which is written.
        model: of the next stage.
        last, now: what acts in the stage that ends, and in the next.
    """
    names = [tool.name for tool in model.setup.tools]
    for k, name in enumerate(names):
        if name in last.tools and name not in now.tools:
            _let_go(state, model, k)
        if name in now.tools and name not in last.tools:
            _meet(state, model, k)
    _forget_arguments(state, model, last, now)
    _restart_tools(state, names, last, now)
    # a tool that no longer acts rests from now on, whatever it did
    place_carried(model, state, [k for k, name in enumerate(names) if _begins(now, name)])
    arriving = [
        k
        for k, tool in enumerate(model.setup.tools)
        if tool.name in now.tools
        and _begins(now, tool.name)
        and isinstance(motion := tool.motion.along_axis, ForceDriven)
        and motion.in_touch
    ]
    if arriving:
        touch_sheets(model, state, arriving, [positions_of(model, state, k) for k in range(len(model.sheets))])
    for index, sheet in enumerate(model.sheets):
        held = np.zeros((sheet.blank.node_count, 6), dtype=bool)
        for support in sheet.supports:
            if support.name in now.supports and support.name not in last.supports:
                held[support.nodes] |= support.held
        if held.any():
            _stop(state, model, index, held)


def _forget_arguments(state: State, model: Model, last: Acting, now: Acting) -> None:
    """Extremes of the arguments of frictions that are others from now on begin anew."""
    changed = {name for name, friction in now.friction.items() if last.friction.get(name) != friction}
    for k, tool in enumerate(model.setup.tools):
        for own, place, index in _of_sheets(state, model, k) if tool.name in changed else ():
            sheet = model.sheets[index]
            for array in (own.friction_argument, own.sample_friction_argument):
                count = array.shape[-1]
                if sheet.node_traits.friction_laws and count:
                    rows, start = array.numpy(), argument_rows(sheet, count)
                    rows[2 * place : 2 * place + 2] = start[2 * place : 2 * place + 2]
                    array.assign(rows)
    for each, own_pass in zip(model.passes, state.passes, strict=True):
        if isinstance(each.interface, Interface) and each.interface.name in changed:
            forget_arguments(own_pass, each)


def refuse_overlap(model: Model, state: State, last: Acting, now: Acting) -> None:
    """Refuse a stage whose new tools overlap the sheets.

    Raises:
        RunError: one overlaps a sheet by more than a quarter of its thickness.
    """
    distances, displacement, time = ToolDistances(model), state.tool_displacement.numpy(), state.time
    for k, tool in enumerate(model.setup.tools):
        if tool.name not in now.tools or tool.name in last.tools:
            continue
        for _, _, index in _of_sheets(state, model, k):
            sheet = model.sheets[index]
            thickness = sheet.fabric.thickness
            limit = (0.5 - LARGEST_OVERLAP) * thickness
            found = distances.deepest(
                k, tool.place(float(displacement[k]), time), positions_of(model, state, index), sheet, limit
            )
            if found.element is not None:
                raise RunError(
                    f"stage {now.stage.name}: {tool.name} begins to act at {state.time:.4g} s, where it overlaps sheet "
                    f"{sheet.name} by {1e3 * (0.5 * thickness - found.distance):.3g} mm: place it away from the "
                    "sheet, or have it come nearer by a stroke"
                )


def _begins(now: Acting, name: str) -> bool:
    return now.tool_motions[name].since == now.index


def _of_sheets(state: State, model: Model, tool: int) -> list[tuple[SheetState, int, int]]:
    """State of every sheet that a tool may touch, the tool's place among those of the sheet, and the sheet's."""
    return [
        (state.sheets[index], tool - sheet.places.tools.start, index)
        for index, sheet in enumerate(model.sheets)
        if sheet.places.tools.start <= tool < sheet.places.tools.stop
    ]


def _let_go(state: State, model: Model, tool: int) -> None:
    """No distance is small enough for a contact, and what the contact kept is gone."""
    for own, place, index in _of_sheets(state, model, tool):
        sheet = model.sheets[index]
        for gap in (own.gap, own.sample_gap):
            if gap.size:
                gap[place].fill_(np.inf)
        for layout, array in (
            (sheet.friction_layout, own.friction),
            (sheet.samples.layout, own.sample_friction),
        ):
            if array.size:
                rows = layout.read(array)
                rows[3 * place : 3 * place + 3] = 0.0
                array.assign(layout.flat(rows))
        if own.sample_memory.size:
            own.sample_memory.zero_()  # half of the last step's impulses: nothing would book it
        for row in range(place, len(own.sample_reaction), max(sheet.tool_count, 1)):
            if own.sample_reaction.size:
                own.sample_reaction[row].zero_()
    for row in range(tool, len(state.reaction), max(len(model.setup.tools), 1)):  # of forces, and of moments if any
        state.reaction[row].zero_()
    if state.tool_moment.size:
        state.tool_moment[tool : tool + 1].zero_()
    state.tool_force[tool : tool + 1].zero_()


def _meet(state: State, model: Model, tool: int) -> None:
    """The next step looks for contacts."""
    for own, place, _ in _of_sheets(state, model, tool):
        for gap in (own.gap, own.sample_gap):
            if gap.size:
                gap[place].zero_()


def _restart_tools(state: State, names: list[str], last: Acting, now: Acting) -> None:
    drive, velocity = state.tool_drive.numpy(), state.tool_velocity.numpy()
    time = state.time
    for k, name in enumerate(names):
        if _begins(now, name):
            drive[ToolDriveRow.stroke_time, k] = time
            drive[ToolDriveRow.carrying, k] = 0.0
            if name not in now.tools or name not in last.tools:
                velocity[k] = 0.0
    state.tool_drive.assign(drive)
    state.tool_velocity.assign(velocity)


def positions_of(model: Model, state: State, index: int) -> np.ndarray:
    """Positions of the nodes of a sheet, by its index, (node_count, 3) [m]; waits for the device."""
    sheet = model.sheets[index]
    vectors = sheet.read_motion(state.sheets[index].motion)[:, : sheet.blank.node_count].astype(np.float64)
    return vectors[MotionRow.position.vector] + vectors[MotionRow.remainder.vector]


def _stop(state: State, model: Model, index: int, held: np.ndarray) -> None:
    """Take the speed of the components that supports begin to hold."""
    sheet, own = model.sheets[index], state.sheets[index]
    motion = sheet.read_motion(own.motion)
    count = sheet.blank.node_count
    for vector in (MotionRow.velocity.vector, VELOCITY_REMAINDER):
        motion[vector, :count][held[:, :3]] = 0.0
    motion[MotionRow.spin.vector, :count][held[:, 3:]] = 0.0
    sheet.write_motion(own.motion, motion)
