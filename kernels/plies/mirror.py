"""Contact of a sheet with its mirror image at a symmetry plane (docs/plies.md).

A fold that closes on the plane meets its image there, at half a thickness. Both move alike along the plane, so that
there is no friction, and the force on a node is across the plane. Each face of the sheet is a pass of its own.
"""

from functools import cache

import warp as wp

from ..contact.penalty import normal_force
from ..lane_types import lane_types, step_options
from ..lanes import fill, lane_maximum, larger, magnitude, rows3, smaller, store_rows3, where_positive
from ..operators import add, div, mul, sub  # noqa: F401
from ..pass_entries import PassEntry
from ..records import record3, store_record4
from ..rows import MOTION_RECORD_LENGTH, PLY_RECORD_LENGTH, ClockEntry, MotionRow, PlyRow, PlyWorkRow
from .data import NO_DEPTH, UNSOUGHT, record_struct
from .forces import USUAL_ENTRY
from .normals import NORMAL_ROW_COUNT
from .search import watch_struct


@cache
def mirror_struct(real: type, lane_count: int):
    """A symmetry plane, and the nodes of a sheet before it; arrays are [block]."""
    types = lane_types(real, lane_count)

    @wp.struct
    class Mirror:
        axis: wp.int32  # across the plane, which goes through the origin
        side: real  # 1 or -1: where the sheet lies along the axis
        facing: real  # 1: nodes whose normals point away from the plane; -1: towards it
        distance: real  # of the mid-surface from the plane, at which it touches its image [m]
        damping_time: real  # normal dashpot over normal spring [s]
        stiffness: wp.array(dtype=types.lanes)  # normal spring [N/m]
        least: wp.array(dtype=types.lanes)  # least cosine between normal and axis; above 1 for what never touches
        normals: wp.array2d(dtype=types.lanes)  # of the nodes: see normals.py
        motion: wp.array2d(dtype=types.lanes)  # of the nodes, rows: see MotionRow

    return Mirror


@cache
def height_function(real: type, lane_count: int):
    """wp.func (mirror, block) -> distance of the nodes from the plane [m]."""
    Mirror = mirror_struct(real, lane_count)

    @wp.func
    def height_of(mirror: Mirror, block: int):
        position = record3(mirror.motion, MOTION_RECORD_LENGTH, MotionRow.position, block)
        rest = record3(mirror.motion, MOTION_RECORD_LENGTH, MotionRow.remainder, block)
        return mirror.side * (position[mirror.axis] + rest[mirror.axis])

    return height_of


@cache
def watch_mirror_kernel(real: type, lane_count: int):
    """Kernel over blocks of nodes at an update: which may touch their image, and blocks that sleep until the next."""
    lanes = lane_types(real, lane_count).lanes
    Mirror, Record, Watch = mirror_struct(real, lane_count), record_struct(real, lane_count), watch_struct(real)
    height_of = height_function(real, lane_count)

    @wp.kernel(module="unique", enable_backward=False)
    def watch_mirror(first_block: wp.int32, mirror: Mirror, record: Record, watch: Watch):
        block = first_block + wp.tid()
        normal = record3(mirror.normals, NORMAL_ROW_COUNT, 0, block)
        cosine = (mirror.facing * mirror.side) * normal[mirror.axis]
        stray = where_positive(cosine - mirror.least[block], lanes(), lanes(real(UNSOUGHT)))
        left = height_of(mirror, block) - lanes(mirror.distance)
        left = where_positive(stray, lanes(real(UNSOUGHT)), left)
        way = -lane_maximum(-left) - real(watch.entry[PassEntry.reach])
        push, depth = record.rows[PlyRow.push, block], record.rows[PlyRow.depth, block]
        pushed = lane_maximum(push)
        record.rows[PlyRow.stray, block] = stray
        record.way[block] = wp.where(pushed > real(0.0), real(0.0), wp.max(way, real(0.0)))
        watch.deepest[block] = lane_maximum(depth - record.rows[PlyRow.entry, block])
        # a block may sleep from now on: when a node that turns away, and does not push, is back, its contact begins
        gone = where_positive(push, depth, lanes(real(NO_DEPTH)))
        record.rows[PlyRow.depth, block] = where_positive(stray, gone, depth)

    return watch_mirror


@cache
def meet_mirror_kernel(real: type, lane_count: int):
    """Kernel over blocks of nodes, launched before the elements of a step."""
    types = lane_types(real, lane_count)
    lanes, lanes3 = types.lanes, types.lanes3
    Mirror, Record = mirror_struct(real, lane_count), record_struct(real, lane_count)
    height_of = height_function(real, lane_count)

    @wp.func
    def entry_of(mirror: Mirror, record: Record, block: int, depth: lanes, way: lanes):
        """Penetration that makes no force; a node may come from among those that do not touch, at any depth."""
        old = record.rows[PlyRow.depth, block]
        usual = larger(magnitude(way), lanes(real(2.0) * real(USUAL_ENTRY) * mirror.distance))
        usual = where_positive(lanes(real(0.5) * real(NO_DEPTH)) - old, lanes(), usual)
        began = where_positive(old, lanes(), depth - real(2.0) * usual)
        kept = smaller(record.rows[PlyRow.entry, block], larger(depth, lanes()))
        entry = where_positive(began, depth, kept)
        record.rows[PlyRow.entry, block] = entry
        record.rows[PlyRow.largest_entry, block] = larger(record.rows[PlyRow.largest_entry, block], entry)
        return entry

    @wp.func
    def book(mirror: Mirror, record: Record, block: int, lost: lanes, stray: lanes):
        """Energy lost in the dashpot, and of the springs of nodes that are turned away."""
        push = record.rows[PlyRow.push, block]
        released = where_positive(stray, mul(push, push), lanes())
        released = real(0.5) * released / larger(mirror.stiffness[block], lanes(real(1.0e-30)))
        works = record.works
        works[PlyWorkRow.damping_loss, block] = works[PlyWorkRow.damping_loss, block] + lost + released

    @wp.kernel(module="unique", enable_backward=False, module_options=step_options(real))
    def meet_mirror(
        # In
        first_block: wp.int32,
        mirror: Mirror,
        clock: wp.array(dtype=wp.float64),
        # Out
        record: Record,
    ):
        block = first_block + wp.tid()
        if record.way[block] > real(0.0):
            return
        step = real(clock[ClockEntry.mean_step])
        rows = record.rows
        velocity = mirror.side * record3(mirror.motion, MOTION_RECORD_LENGTH, MotionRow.velocity, block)[mirror.axis]
        lost = real(-0.5) * record.last_step[block] * rows[PlyRow.dashpot, block]
        stray = rows[PlyRow.stray, block]
        depth = where_positive(stray, lanes(real(NO_DEPTH)), lanes(mirror.distance) - height_of(mirror, block))
        entry = entry_of(mirror, record, block, depth, step * velocity)
        push, pressed = normal_force(depth - entry, -velocity, mirror.stiffness[block], mirror.damping_time)
        dashpot = pressed - push
        lost = lost - real(0.5) * step * dashpot
        book(mirror, record, block, mul(lost, velocity), stray)
        force = lanes3()
        force[mirror.axis] = mirror.side * pressed
        store_record4(rows, PLY_RECORD_LENGTH, PlyRow.force, block, force, lanes())
        rows[PlyRow.push, block] = push
        rows[PlyRow.dashpot, block] = dashpot
        rows[PlyRow.distance, block] = fill(push, mirror.distance)
        rows[PlyRow.depth, block] = depth
        record.last_step[block] = step
        store_rows3(record.total, 0, block, rows3(record.total, 0, block) + force)

    return meet_mirror
