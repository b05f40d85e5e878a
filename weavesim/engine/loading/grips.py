"""The springs of the gripped nodes of a sheet, in the form that the kernels read."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from ...kernels.loads.grippers import Grip, Grips
from ...kernels.rows import ROWS_PER_CORNER, CornerRow, GripRow
from ..sheet_model import SheetModel


@dataclass(frozen=True)
class DeviceGrips:
    """The springs of a sheet, in the order of the elements at whose corners they pull.

    Attributes:
        grips: ``kernels.loads.grippers.Grips``.
        element: of each spring, ascending (count,).
    """

    grips: Any
    element: np.ndarray

    def within(self, first: int, count: int) -> tuple[int, int]:
        """First spring, and number of springs, of ``count`` elements from ``first``."""
        low, high = np.searchsorted(self.element, [first, first + count])
        return int(low), int(high - low)


def gripped_corners(sheet: SheetModel) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Of every spring of a sheet in order of elements: gripper, its share in it, node, and a corner of the node.

    A corner is given by its element and its number; none is that of two springs. All are (count,).
    """
    quads, grippers = sheet.blank.quads, sheet.grippers
    node, first = np.unique(quads.ravel(), return_index=True)
    place = np.full(sheet.blank.node_count, -1)
    place[node] = first
    gripper = np.repeat(np.arange(len(grippers)), [len(each.nodes) for each in grippers])
    nodes = np.concatenate([each.nodes for each in grippers])
    share = np.concatenate([sheet.shares(each) for each in grippers])
    order = np.argsort(place[nodes], kind="stable")
    at = place[nodes][order]
    return gripper[order], share[order], nodes[order], at // 4, at % 4


def device_grips(sheet: SheetModel) -> DeviceGrips:
    """The springs of a sheet that has some."""
    gripper, shares, node, element, corner = gripped_corners(sheet)
    curves = [each.anchor_curve() for each in sheet.grippers]
    first_knot = np.cumsum([0, *(len(times) for times, _ in curves)])
    records = []
    for k, own in enumerate(gripper):
        given, share = sheet.grippers[own], float(shares[k])
        record: Any = Grip()
        record.position = int(sheet.motion_layout.entry(0, int(node[k])))
        record.corner = int(sheet.corners.entry(CornerRow.force + ROWS_PER_CORNER * int(corner[k]), int(element[k])))
        direction = np.array(given.direction)
        record.anchor = sheet.blank.node_position[node[k]] + given.length * direction
        record.length = given.length
        record.stiffness, record.pretension = share * given.stiffness, share * given.pretension
        record.ramp_time, record.largest_force = given.ramp_time, share * given.limit
        record.release_time = np.inf if given.release_time is None else given.release_time
        record.first_knot, record.knot_count = int(first_knot[own]), len(curves[own][0])
        records.append(record)
    grips = Grips()
    grips.grip = wp.array(records, dtype=Grip, device=sheet.device)
    times, values = (np.concatenate(part) for part in zip(*curves, strict=True))
    grips.curve_time = wp.array(times, dtype=wp.float64, device=sheet.device)
    grips.curve_value = wp.array(values, dtype=wp.vec3d, device=sheet.device)
    grips.node_stride, grips.corner_stride = sheet.motion_layout.stride, sheet.corners.stride
    return DeviceGrips(grips, element)


@dataclass(frozen=True)
class GripperState:
    """The grippers of a sheet at one instant.

    Attributes:
        force: of each gripper, the sum of its springs' (gripper_count,) [N].
        slip: through each, the mean of its nodes (gripper_count,) [m].
        stored: by all springs [J].
        work: of the anchors and pretensions so far [J].
        loss: in slip and at releases so far [J].
    """

    force: np.ndarray
    slip: np.ndarray
    stored: float
    work: float
    loss: float

    @classmethod
    def of(cls, sheet: SheetModel, grip: wp.array) -> GripperState:
        """From the rows GripRow of a state of the sheet; waits for the device."""
        if not sheet.grippers:
            return cls(np.empty(0), np.empty(0), 0.0, 0.0, 0.0)
        rows, count = grip.numpy(), len(sheet.grippers)
        gripper, share, *_ = gripped_corners(sheet)
        stiffness = share * np.array([each.stiffness for each in sheet.grippers])[gripper]
        force = np.bincount(gripper, weights=rows[GripRow.force], minlength=count)
        slip = np.bincount(gripper, weights=share * rows[GripRow.slip], minlength=count)
        stored = 0.5 * float((rows[GripRow.force] ** 2 / stiffness).sum())
        return cls(force, slip, stored, float(rows[GripRow.work].sum()), float(rows[GripRow.loss].sum()))
