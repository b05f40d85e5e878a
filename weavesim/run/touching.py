"""Tools that start where they just touch a sheet."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import compress

import numpy as np

from ..engine.model import Model
from ..engine.state import State
from ..errors import InputError
from ..kernels.rows import ToolPoseRow
from ..process.strokes import ForceDriven
from ..tools.carried.device import poses
from .watch.tool_distance import ToolDistances

# A tool touches when it is nearer to the sheet than this share of its thickness.
TOUCHING = 1.0e-6
LARGEST_MOVE_COUNT = 200


def start_in_touch(model: Model, state: State) -> None:
    """Move tools that start in touch along their axes until they touch a node of a sheet; writes their displacements.

    Raises:
        InputError: a tool that meets no sheet on its way.
    """
    tools = model.setup.tools
    motions = [tool.motion.along_axis for tool in tools]
    own = [k for k, motion in enumerate(motions) if isinstance(motion, ForceDriven) and motion.in_touch]
    if own:
        touch_sheets(model, state, own, [sheet.blank.node_position for sheet in model.sheets])


def touch_sheets(model: Model, state: State, tools: Sequence[int], positions: Sequence[np.ndarray]) -> None:
    """Move tools along their axes, from where they are drawn, until they touch a node; writes their displacements.

    Args:
        model: of the run.
        state: whose ``tool_displacement`` is written.
        tools: indices of those that are moved.
        positions: of the nodes of every sheet, (node_count, 3) each [m].

    Raises:
        InputError: a tool that meets no sheet on its way.
    """
    distances, displacement, time = ToolDistances(model), state.tool_displacement.numpy(), state.time
    for k in tools:
        displacement[k] = _touching(model, distances, k, positions, time)
        stop, way = model.setup.tools[k].motion.spacers
        if way * (displacement[k] - stop) > 0.0:  # spacers hold it above the sheet
            displacement[k] = stop
    state.tool_displacement.assign(displacement)
    place_carried(model, state)


def place_carried(model: Model, state: State, begun: Sequence[int] = ()) -> None:
    """Bring the poses of carried tools to where the displacements and the time of a state have them.

    Args:
        model: of the run, or of its stage.
        state: whose ``tool_pose`` is written.
        begun: indices of tools whose path begins now: what it has been so far does not count.
    """
    tools = model.setup.tools
    if model.tools.carriers is None:
        return
    entries, found = state.tool_pose.numpy(), poses(tools, state.time, state.tool_displacement.numpy())
    for row in (ToolPoseRow.rotation, ToolPoseRow.shift, ToolPoseRow.pivot):
        entries[:, row.span] = found[:, row.span]
    for row in (ToolPoseRow.offset, ToolPoseRow.angle):
        entries[list(begun), row.span] = found[list(begun), row.span]
    state.tool_pose.assign(entries)


def _touching(model: Model, distances: ToolDistances, tool: int, positions: Sequence[np.ndarray], time: float) -> float:
    """Displacement at which a tool touches a node of the sheets [m]."""
    met = [sheet.places.tools.start <= tool < sheet.places.tools.stop for sheet in model.sheets]
    sheets = list(compress(model.sheets, met))
    nodes = np.concatenate(list(compress(positions, met)))
    half = np.concatenate([np.full(sheet.blank.node_count, 0.5 * sheet.fabric.thickness) for sheet in sheets])
    own, motion = model.setup.tools[tool], model.setup.tools[tool].motion
    forces = np.array(motion.curve()[1])
    way = float(np.sign(forces[int(np.argmax(np.abs(forces)))])) or 1.0
    at, tolerance = 0.0, TOUCHING * 2.0 * float(half.min())
    gap = float((distances(tool, own.place(at, time), nodes)[0] - half).min())
    longest = 2.0 * (abs(gap) + float(np.ptp(nodes, axis=0).max()))
    for _ in range(LARGEST_MOVE_COUNT):
        if abs(gap) <= tolerance:
            return at
        # a distance changes by at most the travel: the tool cannot go through the sheet
        at += way * gap
        if abs(at) > longest:
            break
        gap = float((distances(tool, own.place(at, time), nodes)[0] - half).min())
    raise InputError(
        f"{model.setup.tools[tool].name}: it starts in_touch, but along its axis it meets no sheet within "
        f"{1e3 * longest:.4g} mm; place it over a sheet, turn its axis or the sign of its force, or leave in_touch out"
    )
