"""Two edges that cross: where they are nearest, how much of the contact is theirs, and their force (docs/plies.md)."""

from functools import cache

import warp as wp

from ..plies.forces import USUAL_ENTRY
from ..rows import MotionRow
from .data import creases_struct, edges_struct, place_functions
from .pair_rows import CreaseWorkRow, PairRow

# Squared sines of the angle between two edges at which their contact begins to count, 5 degrees, and counts whole, 15.
LEAST_SQUARED_SINE = wp.constant(0.0076)
WHOLE_SQUARED_SINE = wp.constant(0.067)
# Sines of the angle at which the other edge stands over a facet of this one: up to 10 degrees, and not beyond 30.
WHOLE_LEAN = wp.constant(0.17)
LARGEST_LEAN = wp.constant(0.5)
# Cosines of the angle between the facets of two free edges: up to 20 degrees nodes on facets hold them apart, from 40
# on it is the matter of the edges.
LEAST_COSINE_OF_FACETS = wp.constant(0.766)
LARGEST_COSINE_OF_FACETS = wp.constant(0.94)
# A contact that begins with more than this weight may have come from nowhere: it begins without a force.
SUDDEN_WEIGHT = wp.constant(0.25)


@cache
def pair_struct(real: type):
    """Two edges in this step; vectors point from the second, of the higher number, to the first."""
    vec3 = wp.types.vector(3, real)

    @wp.struct
    class Pair:
        normal: vec3  # unit vector
        distance: real  # [m]
        weight: real
        first: real  # where it is nearest on either edge, 0 to 1
        second: real
        velocity: vec3  # of the first over the second [m/s]
        stiffness: real  # without the weight [N/m]

    return Pair


@cache
def pair_function(real: type):
    """wp.func (edges, creases, first, second) -> Pair."""
    vec3, Pair = wp.types.vector(3, real), pair_struct(real)
    Edges, Creases = edges_struct(real), creases_struct(real)
    row_at, between = place_functions(real)

    @wp.func
    def ramp(value: real, low: real, high: real):
        return wp.clamp((value - low) / (high - low), real(0.0), real(1.0))

    @wp.func
    def share_within(edges: Edges, edge: int, at: real):
        """1 on the edge, 0 beyond; half-way where the next edge takes over, so that both together have one."""
        low, high = edges.overlap[0, edge], edges.overlap[1, edge]
        return ramp(at, -low, low) * ramp(real(1.0) - at, -high, high)

    @wp.func
    def share_outside(creases: Creases, edge: int, away: vec3):
        """1 where the other edge, along ``away``, lies outside of the crease; 0 over a facet, whose matter it is."""
        result = real(1.0)
        for facet in range(2):
            lean = wp.dot(creases.inward[facet, edge], away)
            result = result * (real(1.0) - ramp(lean, real(WHOLE_LEAN), real(LARGEST_LEAN)))
        return result

    @wp.func
    def share_across(edges: Edges, creases: Creases, first: int, second: int, u: vec3, v: vec3):
        """Of two free edges, along ``u`` and ``v``: 0 where their facets lie along each other; else 1."""
        result = real(1.0)
        if second < edges.free_count:
            n, m = wp.cross(u, creases.inward[0, first]), wp.cross(v, creases.inward[0, second])
            cosine = wp.abs(wp.dot(n, m)) / wp.sqrt(wp.dot(u, u) * wp.dot(v, v))
            result = ramp(-cosine, -real(LARGEST_COSINE_OF_FACETS), -real(LEAST_COSINE_OF_FACETS))
        return result

    @wp.func
    def velocity_of(edges: Edges, edge: int, at: real):
        start = row_at(edges, 0, edge, MotionRow.velocity)
        return start + at * (row_at(edges, 1, edge, MotionRow.velocity) - start)

    @wp.func
    def velocity_between(edges: Edges, first: int, second: int, at: real, at_second: real):
        return velocity_of(edges, first, at) - velocity_of(edges, second, at_second)

    @wp.func
    def meet(edges: Edges, creases: Creases, first: int, second: int):
        pair = Pair()
        u, v = between(edges, 1, first, 0, first), between(edges, 1, second, 0, second)
        w = between(edges, 0, first, 0, second)
        a, b, c = wp.dot(u, u), wp.dot(u, v), wp.dot(v, v)
        d, e = wp.dot(u, w), wp.dot(v, w)
        determinant = a * c - b * b
        crossing = ramp(determinant / (a * c), real(LEAST_SQUARED_SINE), real(WHOLE_SQUARED_SINE))
        pair.stiffness = wp.min(edges.stiffness[first], edges.stiffness[second])
        if crossing > real(0.0):
            pair.first = (b * e - c * d) / determinant
            pair.second = (a * e - b * d) / determinant
            away = w + pair.first * u - pair.second * v
            pair.distance = wp.length(away)
            if pair.distance < edges.thickness:
                crossing = crossing * share_within(edges, first, pair.first) * share_within(edges, second, pair.second)
                pair.normal = away / wp.max(pair.distance, real(1.0e-30))
                crossing = crossing * share_outside(creases, first, -pair.normal)
                crossing = crossing * share_outside(creases, second, pair.normal)
                crossing = crossing * share_across(edges, creases, first, second, u, v)
                pair.weight = crossing * creases.weight[first] * creases.weight[second]
                pair.velocity = velocity_between(edges, first, second, pair.first, pair.second)
        return pair

    return meet, velocity_between


@cache
def pair_force_function(real: type):
    """wp.func -> force on the first edge of a pair; its rows are written, and its works if ``books``."""
    vec3, Pair = wp.types.vector(3, real), pair_struct(real)
    Edges, Creases = edges_struct(real), creases_struct(real)
    _, velocity_between = pair_function(real)

    @wp.func
    def vector_row(creases: Creases, row: int, place: int):
        rows = creases.rows
        return vec3(rows[row, place], rows[row + 1, place], rows[row + 2, place])

    @wp.func
    def book(creases: Creases, edge: int, row: int, value: real):
        creases.works[row, edge] = creases.works[row, edge] + wp.float64(value)

    @wp.func
    def close_books(edges: Edges, creases: Creases, first: int, second: int, place: int, stiffness: real):
        """The second half of the last step's works, with the velocity after it."""
        rows = creases.rows
        if rows[PairRow.press, place] > real(0.0):
            velocity = velocity_between(edges, first, second, rows[PairRow.first, place], rows[PairRow.second, place])
            half = real(0.5) * rows[PairRow.step, place]
            drag = -(edges.tangential_ratio * stiffness) * vector_row(creases, PairRow.spring, place)
            dashpot = vector_row(creases, PairRow.dashpot, place)
            book(creases, first, CreaseWorkRow.friction_work, -half * wp.dot(drag, velocity))
            book(creases, first, CreaseWorkRow.damping_loss, -half * wp.dot(dashpot, velocity))

    @wp.func
    def press_of(edges: Edges, creases: Creases, pair: Pair, place: int, step: real):
        """Penetration that makes a force; the rows about it are written. No contact comes from nowhere with a force."""
        rows = creases.rows
        depth = wp.where(pair.weight > real(0.0), edges.thickness - pair.distance, real(-1.0))
        usual = wp.max(step * wp.abs(wp.dot(pair.velocity, pair.normal)), real(USUAL_ENTRY) * edges.thickness)
        entry = wp.min(rows[PairRow.entry, place], wp.max(depth, real(0.0)))
        if rows[PairRow.depth, place] <= real(0.0):
            deep = depth > real(2.0) * usual
            sudden = deep and pair.weight > real(SUDDEN_WEIGHT)
            entry = wp.where(sudden, depth, real(0.0))
            # what it stores at once is the work of its weight, from nothing
            rows[PairRow.press, place] = wp.where(deep and not sudden, depth, real(0.0))
        rows[PairRow.depth, place] = depth
        rows[PairRow.entry, place] = entry
        return wp.max(depth - entry, real(0.0))

    @wp.func
    def book_springs(creases: Creases, first: int, place: int, pair: Pair, press: real):
        """Work of the change of the weight; what a pair stored that ceases at once is lost."""
        old, weight = creases.rows[PairRow.press, place], creases.rows[PairRow.weight, place]
        half = real(0.5) * pair.stiffness * old
        book(creases, first, CreaseWorkRow.thickness_work, half * (pair.weight - weight) * press)
        if pair.weight <= real(0.0):
            book(creases, first, CreaseWorkRow.damping_loss, half * weight * old)

    @wp.func
    def rub(edges: Edges, creases: Creases, pair: Pair, place: int, step: real, pressed: real):
        """Friction on the first edge: a spring with a slider, within Coulomb's limit."""
        n = pair.normal
        trial = vector_row(creases, PairRow.spring, place) + step * pair.velocity
        trial = trial - wp.dot(trial, n) * n
        tangential = edges.tangential_ratio * pair.stiffness
        force = tangential * wp.length(trial)
        limit = edges.coefficient[0] * pressed
        held = trial * wp.min(limit / wp.max(force, real(1.0e-30)), real(1.0))
        for c in range(3):
            creases.rows[PairRow.spring + c, place] = held[c]
        return -tangential * held

    @wp.func
    def store(creases: Creases, place: int, pair: Pair, press: real, step: real, dashpot: vec3):
        rows = creases.rows
        rows[PairRow.weight, place] = pair.weight
        rows[PairRow.press, place] = press
        rows[PairRow.first, place] = pair.first
        rows[PairRow.second, place] = pair.second
        rows[PairRow.step, place] = step
        for c in range(3):
            rows[PairRow.dashpot + c, place] = dashpot[c]

    @wp.func
    def force_of(edges: Edges, creases: Creases, pair: Pair, edge: int, other: int, place: int, step: real):
        first = wp.min(edge, other)
        press = press_of(edges, creases, pair, place, step)
        if edge == first:
            close_books(edges, creases, first, other, place, pair.stiffness)
            book_springs(creases, first, place, pair, press)
        stiffness = pair.weight * pair.stiffness
        push = stiffness * press
        dashpot = real(0.0)
        if press > real(0.0):
            closing = -wp.dot(pair.velocity, pair.normal)
            dashpot = wp.max(push + edges.damping_time * stiffness * closing, real(0.0)) - push
        drag = rub(edges, creases, pair, place, step, push + dashpot)
        if edge == first:
            half = real(0.5) * step
            damped = half * dashpot * wp.dot(pair.normal, pair.velocity)
            book(creases, first, CreaseWorkRow.friction_work, -half * wp.dot(drag, pair.velocity))
            book(creases, first, CreaseWorkRow.damping_loss, -damped)
        store(creases, place, pair, press, step, dashpot * pair.normal)
        return (push + dashpot) * pair.normal + drag

    return force_of
