"""Forces of one block of nodes on the facets of another ply: spring, dashpot, friction (docs/plies.md)."""

from functools import cache

import warp as wp

from ..contact.friction import YARN_ANGLE, table_function
from ..contact.penalty import friction_spring, normal_force
from ..lane_types import lane_types
from ..lanes import (
    cross,
    dot,
    fill,
    lane_maximum,
    larger,
    magnitude,
    rows3,
    scale,
    smaller,
    square_root,
    where_positive,
)
from ..operators import add, div, mul, sub  # noqa: F401
from ..rows import PlyRow, PlyWorkRow
from .argument import friction_argument_function, yarn_angle_function
from .data import NO_DEPTH, contact_law_struct, record_struct, slaves_struct
from .facet import facets_struct
from .stand import ply_place_struct, stand_struct

# A contact that begins deeper than this share of the thickness, or than two steps' approach, begins without force.
USUAL_ENTRY = wp.constant(0.005)


@cache
def ply_forces_struct(real: type, lane_count: int):
    """Contact of one block of nodes in this step."""
    types = lane_types(real, lane_count)
    lanes, lanes3 = types.lanes, types.lanes3

    @wp.struct
    class PlyForces:
        force: lanes3  # on the nodes [N]
        drag: lanes3  # friction within it [N]
        spring: lanes3  # tangential spring [m]
        push: lanes  # of the normal spring [N]
        pressure: lanes  # of spring and dashpot [Pa]
        dashpot: lanes  # along the normal; where it pulls, at most as much as the spring pushes [N]
        entry: lanes  # penetration without force [m]

    return PlyForces


@cache
def ply_forces_function(real: type, lane_count: int):
    """wp.func -> PlyForces; slips, extremes and the loss of released springs are written."""
    types = lane_types(real, lane_count)
    lanes, indices = types.lanes, types.indices
    Slaves, Facets, Law = slaves_struct(real, lane_count), facets_struct(real), contact_law_struct(real)
    Record, Place = record_struct(real, lane_count), ply_place_struct(real, lane_count)
    Stand, Forces = stand_struct(real, lane_count), ply_forces_struct(real, lane_count)
    coefficient_at = table_function(real, lane_count)
    argument_of, yarn_angle = friction_argument_function(real, lane_count), yarn_angle_function(real, lane_count)

    @wp.func
    def entry_of(law: Law, stand: Stand, place: Place, record: Record, closing: lanes, facing: real):
        """Penetration that makes no force: no contact begins with one.

        Within a sheet, a node may come from among the neighbours of its foot, at any depth.
        """
        block = place.block
        usual = larger(place.mean_step * magnitude(closing), lanes(real(USUAL_ENTRY) * law.thickness))
        unseen = lanes(real(0.5) * real(NO_DEPTH)) - record.rows[PlyRow.depth, block]
        if facing != real(0.0):
            usual = where_positive(unseen, lanes(), usual)
        deep = stand.depth - real(2.0) * usual
        began = where_positive(record.rows[PlyRow.depth, block], lanes(), deep)
        kept = smaller(record.rows[PlyRow.entry, block], larger(stand.depth, lanes()))
        entry = where_positive(began, stand.depth, kept)
        record.rows[PlyRow.largest_entry, block] = larger(record.rows[PlyRow.largest_entry, block], entry)
        return entry

    @wp.func
    def book_release(record: Record, block: int, stand: Stand, stiffness: lanes):
        """A node that slides off a free edge takes its springs' energy with it."""
        push = record.rows[PlyRow.push, block]
        left = mul(fill(push, 1.0) - stand.has_foot, push)
        if lane_maximum(left) > real(0.0):
            released = real(0.5) * left * push / larger(stiffness, lanes(real(1.0e-30)))
            works = record.works
            works[PlyWorkRow.damping_loss, block] = works[PlyWorkRow.damping_loss, block] + released

    @wp.func
    def note_slip(record: Record, block: int, pressure: lanes, slid: lanes, moved: lanes):
        rows = record.rows
        rows[PlyRow.slip, block] = rows[PlyRow.slip, block] + where_positive(pressure, slid, lanes())
        rows[PlyRow.travel, block] = rows[PlyRow.travel, block] + moved

    @wp.func
    def rub(law: Law, place: Place, stand: Stand, forces: Forces, stiffness: lanes, angle: lanes, record: Record):
        """``forces`` with friction: a spring that turns with the facet, within Coulomb's limit, and a film."""
        block = place.block
        n = stand.normal
        flat = stand.velocity - scale(dot(stand.velocity, n), n)
        speed = square_root(dot(flat, flat))
        old = rows3(record.rows, PlyRow.spring, block)
        turned = old + scale(place.mean_step * stand.spin, cross(n, old)) + place.mean_step * flat
        trial = turned - scale(dot(turned, n), n)
        argument = argument_of(law.friction, forces.pressure, speed, angle, record, block)
        area = stiffness / lanes(law.area_stiffness)
        table = law.friction
        coefficient = coefficient_at(table.argument, table.coefficient, 0, table.argument.shape[0], argument)
        limit = coefficient * forces.pressure * area
        tangential = law.tangential_ratio * stiffness
        held = friction_spring(trial, tangential, limit)
        film = where_positive(forces.pressure, law.friction.film * area, lanes())
        forces.spring = held
        forces.drag = -(scale(tangential, held) + scale(film, flat))
        slid = square_root(dot(trial, trial)) - square_root(dot(held, held))
        note_slip(record, block, forces.pressure, slid, place.mean_step * speed)
        return forces

    @wp.func
    def forces_of(slaves: Slaves, facets: Facets, law: Law, place: Place, facet: indices, stand: Stand, record: Record):
        forces = Forces()
        stiffness = slaves.stiffness[place.block]
        closing = -law.side * dot(stand.velocity, stand.normal)
        book_release(record, place.block, stand, stiffness)
        forces.entry = entry_of(law, stand, place, record, closing, slaves.facing)
        push, pressed = normal_force(stand.depth - forces.entry, closing, stiffness, law.damping_time)
        forces.push = push
        forces.pressure = law.area_stiffness * pressed / larger(stiffness, lanes(real(1.0e-30)))
        forces.dashpot = pressed - push
        angle = lanes()
        if law.friction.argument_kind == YARN_ANGLE:
            angle = yarn_angle(slaves, facets, place.block, facet)
        forces = rub(law, place, stand, forces, stiffness, angle, record)
        forces.force = scale(law.side * pressed, stand.normal) + forces.drag
        return forces

    return forces_of
