"""Supports as the kernels take them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import warp as wp

from ..kernels.stepping.node_data import support_struct
from .supports import Support


@dataclass(frozen=True)
class DeviceSupports:
    """Supports as the kernels take them; arrays on one device.

    Attributes:
        struct: ``kernels.stepping.node_data.support_struct``.
        first_piece, start, piece: curves of all drives, see ``kernels.support_motion``.
        displacement: of each drive, (drive_count,) of float64 [m].
    """

    struct: object
    first_piece: wp.array
    start: wp.array
    piece: wp.array
    displacement: wp.array

    @property
    def drive_count(self) -> int:
        return self.displacement.shape[0]


def build_device_supports(
    supports: Sequence[Support], node_count: int, real: type, lane_count: int, device: wp.context.Device
) -> DeviceSupports:
    """Arrays for ``node_motion_kernel`` and ``support_motion_kernel``; ``node_count`` is the padded one."""
    vec3, indices = wp.types.vector(3, real), wp.types.vector(lane_count, wp.int32)
    drives = [(support, k) for support in supports for k in range(len(support.drives))]
    held = np.zeros(node_count if supports else 0, dtype=np.int32)
    direction = np.zeros((len(drives), node_count if drives else 0, 3))
    for support in supports:
        held[support.nodes] = support.held[:3] @ (1 << np.arange(3))
    for row, (support, k) in enumerate(drives):
        direction[row, support.nodes] = support.directions(k)
    curves = [support.drives[k].pieces() for support, k in drives]

    def array(data: np.ndarray, dtype: type) -> wp.array:
        vectors = hasattr(dtype, "_shape_")
        shape = data.shape[:-1] if vectors else data.shape
        return wp.array(data, dtype=dtype, device=device) if data.size else wp.zeros(shape, dtype=dtype, device=device)

    increment = wp.zeros(len(drives), dtype=real, device=device)
    struct = support_struct(real, lane_count)()
    struct.held = array(held.reshape(-1, lane_count), indices)
    struct.direction = array(direction, vec3)
    struct.increment = increment
    struct.holding = wp.zeros(node_count if supports else 0, dtype=vec3, device=device)
    return DeviceSupports(
        struct=struct,
        first_piece=array(np.cumsum([0, *(len(start) for start, _ in curves)]), wp.int32),
        start=array(np.concatenate([np.empty(0), *(start for start, _ in curves)]), wp.float64),
        piece=array(np.concatenate([np.empty((0, 4)), *(piece for _, piece in curves)]), wp.vec4d),
        displacement=wp.zeros(len(drives), dtype=wp.float64, device=device),
    )


def support_outputs(supports: Sequence[Support], device: DeviceSupports) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Forces on the sheet (support_count, 3) [N], displacements and forces of all drives (drive_count,) [m], [N].

    Sums run over the nodes in the order of the support, in double precision.
    """
    holding = device.struct.holding.numpy().astype(np.float64)
    force = [[math.fsum(component) for component in holding[s.nodes].T] for s in supports]
    drive_force = [
        math.fsum((holding[s.nodes] * s.directions(k)).ravel()) for s in supports for k in range(len(s.drives))
    ]
    return (
        np.array(force).reshape(-1, 3),
        device.displacement.numpy().copy(),
        np.array(drive_force),
    )
