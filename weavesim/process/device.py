"""Supports in the form that the kernels read, and the forces read back from them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import warp as wp

from .supports import Support


@dataclass(frozen=True)
class DeviceDrives:
    """Curves of all drives of all supports of a run, as ``support_motion_kernel`` reads them; arrays on one device.

    Attributes:
        first_piece: of each drive, and the number of all pieces, (drive_count + 1,) int32.
        start: of every piece, (piece_count,) float64 [s].
        piece: c0 to c3 of every piece, (piece_count,) vec4d [m].
        count: number of drives.
    """

    first_piece: wp.array
    start: wp.array
    piece: wp.array
    count: int


def build_device_drives(supports: Sequence[Support], device: wp.Device) -> DeviceDrives:
    """The curves of all drives of ``supports``, in order."""
    curves = [drive.pieces() for support in supports for drive in support.drives]
    return DeviceDrives(
        first_piece=_array(np.cumsum([0, *(len(start) for start, _ in curves)]), wp.int32, device),
        start=_array(np.concatenate([np.empty(0), *(start for start, _ in curves)]), wp.float64, device),
        piece=_array(np.concatenate([np.empty((0, 4)), *(piece for _, piece in curves)]), wp.vec4d, device),
        count=len(curves),
    )


def build_support_arrays(
    supports: Sequence[Support],
    node_count: int,
    real: type,
    lane_count: int,
    device: wp.Device,
    left_out: np.ndarray | None = None,
) -> tuple[wp.array, wp.array]:
    """Which components of the nodes of a sheet its supports hold, and the directions of its drives.

    Args:
        supports: of one sheet.
        node_count: with padding.
        real: scalar type of the run.
        lane_count: nodes per kernel thread.
        device: of the arrays.
        left_out: nodes that no support holds, (k,); None for none.

    Returns:
        Bits 0-2 of every node for x, y, z, (node blocks,) of lanes of int32; displacement over that of the drive,
        (drive_count, node_count) of vec3. Both are empty without supports.
    """
    drives = [(support, k) for support in supports for k in range(len(support.drives))]
    held = np.zeros(node_count if supports else 0, dtype=np.int32)
    direction = np.zeros((len(drives), node_count if drives else 0, 3))
    for support in supports:
        held[support.nodes] = support.held[:3] @ (1 << np.arange(3))
    for row, (support, k) in enumerate(drives):
        direction[row, support.nodes] = support.directions(k)
    if left_out is not None and supports:
        held[left_out], direction[:, left_out] = 0, 0.0
    return (
        _array(held.reshape(-1, lane_count), wp.types.vector(lane_count, wp.int32), device),
        _array(direction, wp.types.vector(3, real), device),
    )


def _array(data: np.ndarray, dtype: type, device: wp.Device) -> wp.array:
    shape = data.shape[:-1] if hasattr(dtype, "_shape_") else data.shape
    return wp.array(data, dtype=dtype, device=device) if data.size else wp.zeros(shape, dtype=dtype, device=device)


def support_forces(supports: Sequence[Support], holding: np.ndarray) -> tuple[list[list[float]], list[float]]:
    """Force of each support on its sheet, (support_count, 3) [N], and that along each of their drives [N].

    Sums run over the nodes in the order of the support, in double precision.

    Args:
        supports: of one sheet.
        holding: force of the supports on every node of the sheet, (node_count, 3) [N].
    """
    holding = holding.astype(np.float64)
    force = [[math.fsum(component) for component in holding[s.nodes].T] for s in supports]
    along = [math.fsum((holding[s.nodes] * s.directions(k)).ravel()) for s in supports for k in range(len(s.drives))]
    return force, along
