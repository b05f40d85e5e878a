"""Which contacts of a sheet with itself are real: those of neighbours on the flat blank are not.

Each pair of faces of a sheet is a pass of its own, by the side of the facet and by how the node faces it, so that a
node may touch on both sides at once, and a pass needs one foot for each node.
"""

from functools import cache

import warp as wp

from ..lane_types import lane_types
from ..lanes import dot, fill, where_positive
from ..operators import add, div, mul, sub  # noqa: F401
from ..records import SCALAR, gather4, record3, record4, vector_of
from .data import slaves_struct
from .facet import corner_entries, facets_struct, patch_at, patch_functions
from .normals import NORMAL_ROW_COUNT
from .stand import below_struct, stand_struct

# Least cosine between the normal of a node and that of the facet; none for nodes of free edges, which may stand edge-on
# where no crease is near.
LEAST_COSINE = wp.constant(0.7)
# Least squared length of the mean of a facet's normals, which turn by 50 degrees over it: in tighter creases feet jump.
LEAST_SQUARED_MEAN = wp.constant(0.81)


@cache
def flat_patch_function(real: type, lane_count: int):
    """wp.func -> patch of the flat coordinates of facets."""
    indices = lane_types(real, lane_count).indices
    Facets = facets_struct(real)
    _, _, _, patch_of = patch_functions(real, lane_count)

    @wp.func
    def flat_at(facets: Facets, facet: indices, corner: int):
        entry = corner_entries(facets.normal_corner, facet, corner)
        return vector_of(gather4(facets.flat, entry, 0, facets.normal_stride))

    @wp.func
    def flat_patch(facets: Facets, facet: indices):
        return patch_of(
            flat_at(facets, facet, 0), flat_at(facets, facet, 1), flat_at(facets, facet, 2), flat_at(facets, facet, 3)
        )

    return flat_patch


@cache
def admit_function(real: type, lane_count: int):
    """wp.func (slaves, facets, facet, block, below, stand, has_foot) -> ``has_foot`` without false feet."""
    types = lane_types(real, lane_count)
    lanes, indices = types.lanes, types.indices
    Slaves, Facets = slaves_struct(real, lane_count), facets_struct(real)
    Below, Stand = below_struct(real, lane_count), stand_struct(real, lane_count)
    flat_patch = flat_patch_function(real, lane_count)

    @wp.func
    def admit(slaves: Slaves, facets: Facets, facet: indices, block: int, below: Below, stand: Stand, has_foot: lanes):
        own = record4(slaves.flat, NORMAL_ROW_COUNT, 0, block)
        apart = patch_at(flat_patch(facets, facet), stand.xi, stand.eta) - vector_of(own)
        squared = dot(apart, apart)
        far = squared - lanes(slaves.squared_exclusion)
        normal = record3(slaves.normals, NORMAL_ROW_COUNT, 0, block)
        one = fill(far, 1.0)
        inner = where_positive(squared - lanes(slaves.squared_edge_distance), one - own[SCALAR], one)
        turned = slaves.facing * dot(normal, stand.normal) - real(LEAST_COSINE) * inner
        smooth = dot(below.d.mean, below.d.mean) - lanes(real(LEAST_SQUARED_MEAN))
        kept = where_positive(far, where_positive(turned, has_foot, lanes()), lanes())
        return where_positive(smooth, kept, lanes())

    return admit
