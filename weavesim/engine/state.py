"""Everything that a step writes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import warp as wp

from ..kernels.rows import (
    CELL_REPORT_ROWS,
    CLOCK_LENGTH,
    CLOCK_MEAN_STEP,
    CLOCK_STEP,
    CLOCK_TIME,
    CORNER_ROW_COUNT,
    HALF_THICKNESS_ROW,
    MOTION_ROW_COUNT,
    SLIP_ROWS,
)
from .layout import BLOCK
from .model import Model


@dataclass
class State:
    """All that the kernels write. Scalars are [row, element or node], padded; see the kernels for the rows."""

    motion: wp.array  # flat, ``Model.motion_layout``: rows MOTION_ROWS, mean shear angle
    cell_unknowns: wp.array  # (unknowns of the unit cell, one at least; elements)
    cell_report: wp.array  # (3, elements), rows CELL_REPORT_ROWS
    slip: wp.array  # (8, elements), rows SLIP_ROWS; (8, BLOCK) for a fabric without friction inside
    corner_force: wp.array  # flat, ``Model.corners``
    node_report: wp.array  # (rows, nodes), ``Model.node_report_rows``
    friction: wp.array  # flat, ``Model.friction_layout`` [m]
    gap: wp.array  # (tools, node blocks), how far each may move before a contact is possible [m]
    reaction: wp.array  # (tools, node blocks) vec3 [N]
    clock: wp.array  # time, step, mean step [s]

    @classmethod
    def initial(cls, model: Model, velocity: np.ndarray | None = None) -> State:
        real, vec3, device = model.real, model.types.vec3, model.device
        tool_rows = max(model.tool_count, 1)
        slip_count = model.element_count if model.fabric.has_inner_friction else BLOCK
        node_report = np.zeros((len(model.node_report_rows), model.node_count))
        if model.follows_thickness:
            node_report[int(HALF_THICKNESS_ROW)] = 0.5 * model.fabric.thickness
        clock = np.zeros(CLOCK_LENGTH)
        clock[[CLOCK_STEP, CLOCK_MEAN_STEP]] = model.reference_step
        motion = wp.zeros(MOTION_ROW_COUNT * model.node_count, dtype=real, device=device)
        model.write_motion(motion, model.initial_motion(velocity))
        return cls(
            motion=motion,
            cell_unknowns=wp.array(model.initial_unknowns(), dtype=real, device=device),
            cell_report=wp.zeros((len(CELL_REPORT_ROWS), model.element_count), dtype=real, device=device),
            slip=wp.zeros((len(SLIP_ROWS), slip_count), dtype=real, device=device),
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
        return float(self.clock.numpy()[CLOCK_TIME])

    @property
    def step(self) -> float:
        """Current time step [s]; waits for the device."""
        return float(self.clock.numpy()[CLOCK_STEP])


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
