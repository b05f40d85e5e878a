"""Data of the contact of edges with edges within a sheet, and where the ends of an edge are."""

from functools import cache

import warp as wp

from ..rows import MotionRow

# Edges of a group, which one thread looks at; consecutive creases that share a box.
GROUP = wp.constant(16)


@cache
def edges_struct(real: type):
    """Edges of a sheet, free ones first, on the motion of one state; arrays are [edge]."""
    vec4 = wp.types.vector(4, real)

    @wp.struct
    class Edges:
        # [place, edge]: first entry in the motion of both ends, and of the two nodes opposite in either facet; of a
        # free edge, which has one, the ends in place of the other
        entry: wp.array2d(dtype=wp.int32)
        flat: wp.array(dtype=vec4)  # both ends on the flat blank [m]
        stiffness: wp.array(dtype=real)  # of a pair with an edge that is not lighter [N/m]
        overlap: wp.array2d(dtype=real)  # [end, edge]: share of the length by which the next edge takes over
        motion: wp.array(dtype=real)
        stride: wp.int32  # entries between two rows of the motion
        edge_count: wp.int32
        free_count: wp.int32
        thickness: real  # distance at which edges touch [m]
        squared_exclusion: real  # nearer on the flat blank, edges are neighbours [m^2]
        turning: real  # both faces move at least this far while facets turn against each other by one radian [m]
        damping_time: real  # normal dashpot over normal spring [s]
        tangential_ratio: real  # friction spring over normal spring
        coefficient: wp.array(dtype=real)  # of friction; the first counts

    return Edges


@cache
def creases_struct(real: type):
    """What is kept of the edges; all of it is written."""
    vec3 = wp.types.vector(3, real)

    @wp.struct
    class Creases:
        number: wp.array(dtype=wp.int32)  # see CreaseCount
        quiet: wp.array(dtype=real)  # [0]: way that both faces may still move before there can be a crease [m]
        crease: wp.array(dtype=wp.int32)  # edges with a weight, ascending
        weight: wp.array(dtype=real)  # [edge]: 0 where the sheet is flat, 1 at a crease
        inward: wp.array2d(dtype=vec3)  # [facet, edge]: unit vectors across the edge into its facets
        first: wp.array(dtype=wp.int32)  # [edge]: where its list begins
        count: wp.array(dtype=wp.int32)  # [edge]: length of its list
        partner: wp.array(dtype=wp.int32)  # [entry]: edges that may touch it, ascending
        rows: wp.array2d(dtype=real)  # [row, entry], see PairRow
        works: wp.array2d(dtype=wp.float64)  # [row, edge], see CreaseWorkRow
        force: wp.array2d(dtype=vec3)  # [end, edge]: contact force on its ends [N]
        deepest: wp.array(dtype=real)  # [edge]: deepest penetration so far that makes a force [m]
        largest_entry: wp.array(dtype=real)  # [edge]: largest entry so far [m]

    return Creases


@cache
def crease_search_struct(real: type):
    """What a search makes, before it is adopted."""
    vec3 = wp.types.vector(3, real)

    @wp.struct
    class CreaseSearch:
        of_group: wp.array(dtype=wp.int32)  # [group of edges]: creases, then those before it
        largest_turn: wp.array(dtype=real)  # [group of edges] [rad]
        low: wp.array(dtype=vec3)  # [group of creases]: corners of their box, with half of what they may move [m]
        high: wp.array(dtype=vec3)
        first: wp.array(dtype=wp.int32)  # [place in the list of creases]
        count: wp.array(dtype=wp.int32)
        partner: wp.array(dtype=wp.int32)  # [entry]
        rows: wp.array2d(dtype=real)  # [row, entry]

    return CreaseSearch


@cache
def place_functions(real: type):
    """wp.funcs (edges, ...) -> vector of a row of the motion; difference of two positions, cancelling first."""
    vec3, Edges = wp.types.vector(3, real), edges_struct(real)

    @wp.func
    def row_at(edges: Edges, place: int, edge: int, row: int):
        entry = edges.entry[place, edge] + row * edges.stride
        return vec3(edges.motion[entry], edges.motion[entry + edges.stride], edges.motion[entry + 2 * edges.stride])

    @wp.func
    def between(edges: Edges, place: int, edge: int, from_place: int, from_edge: int):
        moved = row_at(edges, place, edge, MotionRow.position) - row_at(
            edges, from_place, from_edge, MotionRow.position
        )
        rest = row_at(edges, place, edge, MotionRow.remainder) - row_at(
            edges, from_place, from_edge, MotionRow.remainder
        )
        return moved + rest

    return row_at, between
