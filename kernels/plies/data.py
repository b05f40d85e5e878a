"""Data of one pass of an interface: the nodes of one ply, the slave, on the facets of another, the master.

A node's *foot* is its closest point on the facets, along their interpolated normal; it *stands* there where it is
pressed. A *stray* has none, or has just found one and is in no list of a facet yet. A *way* is how far a node, or all
of a block or a group, may move before it has to be looked at again; 0 where it is watched. A block *sleeps* whose way
lasts beyond the next update, and *wakes* when it no longer does; a sheet is *awake* while anything is near enough to
touch it. Groups of nodes and facets *hang together* that are connected by a short way on the flat blank. docs/plies.md
has the formulas.
"""

from functools import cache
from typing import Any

import warp as wp

from ..contact.friction import friction_law_struct
from ..lane_types import GPU_LANE_COUNT, lane_types
from .facet import facets_struct

# Way of nodes without a foot that never seek one by themselves [m].
UNSOUGHT = wp.constant(1.0e30)
# Farther than anything of a sheet [m]: corners of a box that holds nothing yet.
FAR = wp.constant(1.0e30)
# Blocks of a call on a CPU: a call on one block that sleeps would cost more than the look at it.
_BLOCKS_PER_CALL = 16
# Penetration of a node that has no foot [m].
NO_DEPTH = wp.constant(-1000.0)
# Smallest way of a node without a foot [m]: more than 0 says that it has none.
LEAST_STRAY = wp.constant(1.0e-12)


def blocks_per_call(lane_count: int) -> int:
    """Consecutive blocks that one thread of a launch does: one on a GPU."""
    return 1 if lane_count == GPU_LANE_COUNT else _BLOCKS_PER_CALL


@cache
def slaves_struct(real: type, lane_count: int):
    """Constants of the nodes of one pass; arrays are [block of lanes]."""
    types = lane_types(real, lane_count)

    @wp.struct
    class Slaves:
        stiffness: wp.array(dtype=types.lanes)  # normal spring [N/m]; 0 for padding
        home: wp.array(dtype=types.indices)  # an element beside each node, for the direction of its warp
        facets: facets_struct(real)  # of the nodes' own sheet
        normals: wp.array2d(dtype=types.lanes)  # of the nodes: see normals.py
        flat: wp.array2d(dtype=types.lanes)  # flat coordinates, laid out alike; 1 behind those of nodes on a free edge
        facing: real  # within a sheet: 1 if the node's normal points along the facet's, -1 if against; else 0
        squared_exclusion: real  # nearer on the flat blank, points of one sheet are neighbours [m^2]
        squared_edge_distance: real  # farther away, nodes of free edges may stand edge-on [m^2]
        is_first: wp.int32  # 1 in the first pass of a sheet, which begins the sum of its contact forces

    return Slaves


@cache
def contact_law_struct(real: type):
    """Constants of one pass."""

    @wp.struct
    class ContactLaw:
        side: real  # 1: the nodes lie above the facets, along their directors; -1: below
        thickness: real  # sum of the half thicknesses [m]
        farthest: real  # coordinate up to which a foot may lie beyond a free edge of its facet
        area_stiffness: real  # of both passes together, per area [Pa/m]
        damping_time: real  # normal dashpot over normal spring [s]
        tangential_ratio: real  # friction spring over normal spring
        friction: friction_law_struct(real)

    return ContactLaw


@cache
def record_struct(real: type, lane_count: int):
    """What one pass keeps of its nodes; all of it is written. Arrays are [block] or [row, block]."""
    types = lane_types(real, lane_count)

    @wp.struct
    class Record:
        facet: wp.array(dtype=types.indices)  # on which each node has its foot
        standing: wp.array(dtype=types.indices)  # the same where it is pressed, else -1
        rows: wp.array2d(dtype=types.lanes)  # see PlyRow
        works: wp.array2d(dtype=types.lanes)  # see PlyWorkRow
        total: wp.array2d(dtype=types.lanes)  # contact force on the node of all passes [N]
        way: wp.array(dtype=real)  # how far a block may move before any of its nodes can touch [m]; 0: watch it
        entry: wp.array(dtype=wp.float64)  # see PassEntry
        last_step: wp.array(dtype=real)  # mean step over which the forces of the last step acted [s]

    return Record


@cache
def listed_struct():
    """Nodes that may stand on each facet until the lists are made again, ascending."""

    @wp.struct
    class Listed:
        node: wp.array2d(dtype=wp.int32)  # [slot, facet]
        count: wp.array(dtype=wp.int32)  # of each facet; TOO_MANY where the slots do not suffice

    return Listed


# Count of a facet, or of a block of them, whose slots do not suffice: all nodes are looked through instead.
TOO_MANY = wp.constant(-1)


@wp.func
def is_missing(listed: Any, facet: int, node: int):
    """Whether the list of a facet lacks a node, so that the node's force would not be taken from the facet."""
    count = listed.count[facet]
    missing = count != TOO_MANY
    for slot in range(count):
        if listed.node[slot, facet] == node:
            missing = False
    return missing
