"""Everything that a step writes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import warp as wp

from ..kernels.rows import CORNER_ROW_COUNT, CellReportRow, ClockEntry, MotionRow, NodeReportRow, SlipRow
from .layout import BLOCK
from .model import Model


@dataclass
class State:
    """All that the kernels write. Scalars are [row, element or node], padded; see kernels/rows.py for the rows."""

    motion: wp.array  # flat, ``Model.motion_layout``, rows MotionRow
    cell_unknowns: wp.array  # (unknowns of the unit cell, one at least; elements)
    cell_report: wp.array  # (rows, elements), CellReportRow
    slip: wp.array  # (rows, elements), SlipRow; (rows, BLOCK) for a fabric without friction inside
    corner_force: wp.array  # flat, ``Model.corners``, rows CornerRow
    node_report: wp.array  # (rows, nodes), ``Model.node_report_rows``
    friction: wp.array  # flat, ``Model.friction_layout`` [m]
    gap: wp.array  # (tools, node blocks), how far each may move before a contact is possible [m]
    reaction: wp.array  # (tools, node blocks) vec3 [N]
    clock: wp.array  # rows ClockEntry [s]

    @classmethod
    def initial(cls, model: Model, velocity: np.ndarray | None = None) -> State:
        real, vec3, device = model.real, model.types.vec3, model.device
        tool_rows = max(model.tool_count, 1)
        slip_count = model.element_count if model.fabric.has_inner_friction else BLOCK
        node_report = np.zeros((len(model.node_report_rows), model.node_count))
        if model.follows_thickness:
            node_report[NodeReportRow.half_thickness] = 0.5 * model.fabric.thickness
        clock = np.zeros(ClockEntry.row_count())
        clock[[ClockEntry.step, ClockEntry.mean_step]] = model.reference_step
        motion = wp.zeros(MotionRow.row_count() * model.node_count, dtype=real, device=device)
        model.write_motion(motion, model.initial_motion(velocity))
        return cls(
            motion=motion,
            cell_unknowns=wp.array(model.initial_unknowns(), dtype=real, device=device),
            cell_report=wp.zeros((CellReportRow.row_count(), model.element_count), dtype=real, device=device),
            slip=wp.zeros((SlipRow.row_count(), slip_count), dtype=real, device=device),
            corner_force=wp.zeros(CORNER_ROW_COUNT * model.element_count, dtype=real, device=device),
            node_report=wp.array(node_report, dtype=real, device=device),
            friction=wp.zeros(3 * tool_rows * model.node_count, dtype=real, device=device),
            gap=wp.zeros((tool_rows, model.node_count // model.lane_count), dtype=real, device=device),
            reaction=wp.zeros((tool_rows, model.node_count // model.lane_count), dtype=vec3, device=device),
            clock=wp.array(clock, dtype=wp.float64, device=device),
        )

    @property
    def time(self) -> float:
        """[s]; waits for the device."""
        return float(self.clock.numpy()[ClockEntry.time])

    @property
    def step(self) -> float:
        """Current time step [s]; waits for the device."""
        return float(self.clock.numpy()[ClockEntry.step])


@dataclass
class Ahead:
    """What the next step will be, at the end of it; see ``State`` and ``DeviceTools`` for the rows."""

    motion: wp.array
    node_report: wp.array
    cell_unknowns: wp.array
    cell_report: wp.array
    slip: wp.array
    friction: wp.array
    tool_velocity: wp.array
    tool_work: wp.array
