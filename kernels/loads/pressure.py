"""Pressure on the faces of a sheet: it follows them (docs/theory.md, section 7).

On a bilinear element x = b xi + c eta + h xi eta (+ mean) the area vector is b x c + xi b x h + eta h x c, and that
times the shape functions integrates to the forces at its corners in closed form: p times the derivative of the volume
below the element.
"""

from functools import cache

import warp as wp

from ..lane_types import lane_types
from ..lanes import cross, dot, lane_sum, scale
from ..operators import add, div, mul, sub  # noqa: F401
from ..records import SCALAR, record4, store_record4, vector_of
from ..rows import CORNER_ROW_COUNT, ROWS_PER_CORNER, ClockEntry, CornerRow, MotionRow
from ..shell.kinematics import corner_vector, element_struct
from ..stepping.node_forces import load_share


@cache
def pressure_struct(real: type, lane_count: int):
    """The pressures on a sheet."""
    types = lane_types(real, lane_count)

    @wp.struct
    class Pressures:
        share: wp.array2d(dtype=types.lanes)  # [pressure, block]: 1 or -1 on elements that it pushes up or down, or 0
        time: wp.array(dtype=wp.float64)  # knots of all curves [s]
        value: wp.array2d(dtype=wp.float64)  # [pressure, knot]: [Pa]

    return Pressures


@cache
def corner_forces_function(real: type, lane_count: int):
    """wp.func -> forces at corners 1 to 4 over the pressure, of corners relative to the first."""
    lanes3 = lane_types(real, lane_count).lanes3

    @wp.func
    def corner_forces(r2: lanes3, r3: lanes3, r4: lanes3):
        quarter, third = real(0.25), real(1.0 / 3.0)
        b = quarter * ((r2 - r4) + r3)
        c = quarter * ((r4 - r2) + r3)
        h = quarter * ((r3 - r2) - r4)
        even = cross(b, c)
        along = third * cross(b, h)
        across = third * cross(h, c)
        return even - along - across, even + along - across, even + along + across, even - along + across

    return corner_forces


@cache
def element_pressure_kernel(real: type, lane_count: int):
    """Kernel, launched after the elements: add the forces of the pressures to their corners, and book the work.

    The work of the last step is that of the mean of the forces at its ends, which is exact for central differences.
    """
    types = lane_types(real, lane_count)
    lanes, lanes3 = types.lanes, types.lanes3
    Elements, Pressures = element_struct(real, lane_count), pressure_struct(real, lane_count)
    corner_forces = corner_forces_function(real, lane_count)

    @wp.func
    def pressure(pressures: Pressures, block: wp.int32, time: wp.float64):
        """On every element, upwards [Pa]."""
        total = lanes()
        for k in range(pressures.share.shape[0]):
            total = total + real(load_share(pressures.time, pressures.value[k], time)) * pressures.share[k, block]
        return total

    @wp.func
    def place(elements: Elements, block: wp.int32, corner: wp.int32, motion: wp.array(dtype=real)):
        return (
            corner_vector(elements, block, corner, motion, MotionRow.position),
            corner_vector(elements, block, corner, motion, MotionRow.remainder),
        )

    @wp.func
    def push(corner_force: wp.array2d(dtype=lanes), corner: wp.int32, block: wp.int32, force: lanes3):
        row = CornerRow.force + corner * ROWS_PER_CORNER
        piece = record4(corner_force, CORNER_ROW_COUNT, row, block)
        store_record4(corner_force, CORNER_ROW_COUNT, row, block, vector_of(piece) + force, piece[SCALAR])

    @wp.kernel(module="unique", enable_backward=False)
    def element_pressures(
        # In
        first_block: wp.int32,
        elements: Elements,
        pressures: Pressures,
        motion: wp.array(dtype=real),
        clock: wp.array(dtype=wp.float64),
        # Out
        corner_force: wp.array2d(dtype=lanes),  # rows: see CornerRow
        work: wp.array(dtype=wp.float64),  # of every block so far [J]
    ):
        block = first_block + wp.tid()
        last_step = wp.float64(2.0) * clock[ClockEntry.mean_step] - clock[ClockEntry.step]
        now = pressure(pressures, block, clock[ClockEntry.time])
        before = pressure(pressures, block, clock[ClockEntry.time] - last_step)
        x1, y1 = place(elements, block, 0, motion)
        x2, y2 = place(elements, block, 1, motion)
        x3, y3 = place(elements, block, 2, motion)
        x4, y4 = place(elements, block, 3, motion)
        r2 = (x2 - x1) + (y2 - y1)
        r3 = (x3 - x1) + (y3 - y1)
        r4 = (x4 - x1) + (y4 - y1)
        f1, f2, f3, f4 = corner_forces(r2, r3, r4)
        push(corner_force, 0, block, scale(now, f1))
        push(corner_force, 1, block, scale(now, f2))
        push(corner_force, 2, block, scale(now, f3))
        push(corner_force, 3, block, scale(now, f4))
        # travel in the last step
        d1 = real(last_step) * corner_vector(elements, block, 0, motion, MotionRow.velocity)
        d2 = real(last_step) * corner_vector(elements, block, 1, motion, MotionRow.velocity)
        d3 = real(last_step) * corner_vector(elements, block, 2, motion, MotionRow.velocity)
        d4 = real(last_step) * corner_vector(elements, block, 3, motion, MotionRow.velocity)
        g1, g2, g3, g4 = corner_forces(r2 - (d2 - d1), r3 - (d3 - d1), r4 - (d4 - d1))
        swept = now * (dot(f1, d1) + dot(f2, d2) + dot(f3, d3) + dot(f4, d4))
        swept = swept + before * (dot(g1, d1) + dot(g2, d2) + dot(g3, d3) + dot(g4, d4))
        work[block] = work[block] + wp.float64(0.5) * wp.float64(lane_sum(swept))

    return element_pressures
