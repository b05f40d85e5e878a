"""One pass of the contact between two plies: the nodes of one on the facets of the other (docs/plies.md).

The pass reads where both plies are before any node moves, and writes only what belongs to its own nodes. The facets
take their share of the forces later, from the records of the nodes (``reaction.py``).
"""

from functools import cache

import warp as wp

from ..lane_types import lane_types, step_options
from ..lanes import dot, fill, lane_maximum, rows3, square_root, store_rows3, where_positive
from ..operators import add, div, mul, sub  # noqa: F401
from ..pass_entries import PassEntry
from ..records import SCALAR, record3, record4, store_record4
from ..rows import MOTION_RECORD_LENGTH, PLY_RECORD_LENGTH, ClockEntry, MotionRow, PlyRow, PlyWorkRow
from .data import LEAST_STRAY, NO_DEPTH, blocks_per_call, contact_law_struct, record_struct, slaves_struct
from .facet import facets_struct, normal_at, walk_function
from .forces import ply_forces_function, ply_forces_struct
from .stand import (
    below_function,
    below_struct,
    ply_place_struct,
    speed_over,
    stand_function,
    stand_struct,
    touch_distance,
)
from .within import admit_function

# Newton iterations from the foot of the last step, and after a node has walked to another facet.
USUAL_ITERATIONS = wp.constant(2)
ITERATIONS_AFTER_WALK = wp.constant(5)


@cache
def close_books_function(real: type, lane_count: int):
    """wp.func -> growth of the distance at which the plies touch; books the second half of the last step's works."""
    types = lane_types(real, lane_count)
    lanes, lanes3 = types.lanes, types.lanes3
    Law, Record = contact_law_struct(real), record_struct(real, lane_count)
    Place, Below = ply_place_struct(real, lane_count), below_struct(real, lane_count)

    @wp.func
    def book(record: Record, block: int, time: real, drag: lanes3, dashpot: lanes, velocity: lanes3, leaving: lanes):
        """Works over ``time``, at one velocity; of a dashpot also where it takes all that the spring pushes."""
        rubbed = time * dot(drag, velocity)
        works = record.works
        works[PlyWorkRow.friction_work, block] = works[PlyWorkRow.friction_work, block] - rubbed
        damped = time * mul(dashpot, leaving)
        works[PlyWorkRow.damping_loss, block] = works[PlyWorkRow.damping_loss, block] - damped

    @wp.func
    def close_books(law: Law, record: Record, place: Place, below: Below, xi: lanes, eta: lanes):
        block = place.block
        drag = record3(record.rows, PLY_RECORD_LENGTH, PlyRow.drag, block)
        pressed = record.rows[PlyRow.push, block]
        growth = lanes()
        if lane_maximum(pressed) > real(0.0):
            velocity = speed_over(place, below, xi, eta)
            for c in range(3):  # nothing is known of those without a foot
                velocity[c] = where_positive(pressed, velocity[c], lanes())
            n = normal_at(below.x, below.d, xi, eta)
            leaving = law.side * dot(velocity, n) / square_root(dot(n, n))
            leaving = where_positive(pressed, leaving, lanes())
            dashpot = record.rows[PlyRow.dashpot, block]
            book(record, block, real(0.5) * place.last_step, drag, dashpot, velocity, leaving)
            growth = touch_distance(law, below, xi, eta) - record.rows[PlyRow.distance, block]
            growth = where_positive(pressed, growth, lanes())
        return growth

    return book, close_books


@cache
def meet_plies_kernel(real: type, lane_count: int):
    """Kernel over groups of blocks of nodes, launched before the elements of a step."""
    types = lane_types(real, lane_count)
    lanes, lanes3, indices = types.lanes, types.lanes3, types.indices
    Slaves, Facets, Law = slaves_struct(real, lane_count), facets_struct(real), contact_law_struct(real)
    Record, Place = record_struct(real, lane_count), ply_place_struct(real, lane_count)
    Stand, Forces = stand_struct(real, lane_count), ply_forces_struct(real, lane_count)
    look_below, stand_on = below_function(real, lane_count), stand_function(real, lane_count)
    walk, forces_of = walk_function(real, lane_count), ply_forces_function(real, lane_count)
    book, close_books = close_books_function(real, lane_count)
    admit = admit_function(real, lane_count)
    span = blocks_per_call(lane_count)

    @wp.func
    def place_of(block: int, clock: wp.array(dtype=wp.float64), record: Record, motion: wp.array2d(dtype=lanes)):
        place = Place()
        place.block = block
        place.mean_step = real(clock[ClockEntry.mean_step])
        place.last_step = record.last_step[block]
        place.position = record3(motion, MOTION_RECORD_LENGTH, MotionRow.position, block)
        place.remainder = record3(motion, MOTION_RECORD_LENGTH, MotionRow.remainder, block)
        place.velocity = record3(motion, MOTION_RECORD_LENGTH, MotionRow.velocity, block)
        return place

    @wp.func
    def keep_stray(record: Record, block: int, stand: Stand, stray: lanes):
        """1 where a node has its foot, 0 where it has none near; those that have just lost it become strays."""
        tracked = where_positive(stray, lanes(), fill(stray, 1.0))
        lost = mul(tracked, stand.lost)
        record.rows[PlyRow.stray, block] = where_positive(lost, lanes(real(LEAST_STRAY)), stray)
        return mul(stand.has_foot, tracked)

    @wp.func
    def restrict(stand: Stand, has_foot: lanes, stray: lanes):
        """``stand`` with these feet only; those that follow a facet without one, as beside it, move along it, too."""
        stand.has_foot = has_foot
        stand.depth = where_positive(has_foot, stand.depth, lanes(real(NO_DEPTH)))
        for c in range(3):
            stand.velocity[c] = where_positive(stray, lanes(), stand.velocity[c])
        return stand

    @wp.func
    def store(record: Record, block: int, facet: indices, stand: Stand, forces: Forces, is_first: int):
        rows = record.rows
        store_record4(rows, PLY_RECORD_LENGTH, PlyRow.force, block, forces.force, stand.xi)
        store_record4(rows, PLY_RECORD_LENGTH, PlyRow.drag, block, forces.drag, stand.eta)
        store_rows3(rows, PlyRow.spring, block, forces.spring)
        rows[PlyRow.push, block] = forces.push
        rows[PlyRow.dashpot, block] = forces.dashpot
        rows[PlyRow.distance, block] = stand.distance
        rows[PlyRow.entry, block] = forces.entry
        rows[PlyRow.depth, block] = stand.depth
        record.facet[block] = facet
        standing = indices()
        for i in range(lane_count):
            standing[i] = wp.where(forces.pressure[i] > real(0.0), facet[i], -1)
        record.standing[block] = standing
        total = forces.force
        if is_first == 0:
            total = total + rows3(record.total, 0, block)
        store_rows3(record.total, 0, block, total)

    @wp.kernel(module="unique", enable_backward=False, module_options=step_options(real, inlined=True))
    def meet_plies(
        # In
        first_block: wp.int32,
        last_block: wp.int32,  # one past the end
        slaves: Slaves,
        facets: Facets,
        law: Law,
        clock: wp.array(dtype=wp.float64),
        motion: wp.array2d(dtype=lanes),  # of the nodes; rows: see MotionRow
        # Out
        record: Record,
    ):
        if slaves.is_first == 0 and record.entry[PassEntry.watched] == wp.float64(0.0):
            return
        first = first_block + span * wp.tid()
        for block in range(first, wp.min(first + span, last_block)):
            if record.way[block] > real(0.0):
                if slaves.is_first == 1:
                    store_rows3(record.total, 0, block, lanes3())
                continue
            place = place_of(block, clock, record, motion)
            old_xi = record4(record.rows, PLY_RECORD_LENGTH, PlyRow.force, block)[SCALAR]
            old_eta = record4(record.rows, PLY_RECORD_LENGTH, PlyRow.drag, block)[SCALAR]
            facet, xi, eta, moved = walk(facets, record.facet[block], old_xi, old_eta)
            below = look_below(facets, facet, place)
            iterations = USUAL_ITERATIONS
            growth = lanes()
            # no copy of what is below: it is large, and copies of it would cost a tenth of the pass
            if moved > 0:
                iterations = ITERATIONS_AFTER_WALK
                before = look_below(facets, record.facet[block], place)
                growth = close_books(law, record, place, before, old_xi, old_eta)
            else:
                growth = close_books(law, record, place, below, old_xi, old_eta)
            stand = stand_on(law, facets, facet, place, below, xi, eta, iterations)
            has_foot = keep_stray(record, block, stand, record.rows[PlyRow.stray, block])
            if slaves.facing != real(0.0):
                has_foot = admit(slaves, facets, facet, block, below, stand, has_foot)
            stand = restrict(stand, has_foot, record.rows[PlyRow.stray, block])
            forces = forces_of(slaves, facets, law, place, facet, stand, record)
            old_push = record.rows[PlyRow.push, block]
            worked = real(0.5) * (old_push + forces.push) * growth
            record.works[PlyWorkRow.thickness_work, block] = record.works[PlyWorkRow.thickness_work, block] + worked
            half = real(0.5) * place.mean_step
            leaving = law.side * dot(stand.velocity, stand.normal)
            book(record, block, half, forces.drag, forces.dashpot, stand.velocity, leaving)
            record.last_step[block] = place.mean_step
            store(record, block, facet, stand, forces, slaves.is_first)

    return meet_plies
