"""The kernels of the contact between plies."""

from __future__ import annotations

import warp as wp

from ...kernels.plies.collect import (
    GROUP,
    adopt_lists_kernel,
    begin_travel_kernel,
    count_strays_kernel,
    list_nodes_kernel,
    list_strays_kernel,
    settle_own_search_kernel,
    sum_up_kernel,
    survey_groups_kernel,
    watch_speed_kernel,
)
from ...kernels.plies.mirror import meet_mirror_kernel, watch_mirror_kernel
from ...kernels.plies.node_pass import meet_plies_kernel
from ...kernels.plies.normals import surface_normals_kernel
from ...kernels.plies.own_search import (
    bound_groups_kernel,
    follow_own_facets_kernel,
    seek_own_facets_kernel,
)
from ...kernels.plies.reaction import push_facets_kernel
from ...kernels.plies.search import (
    bound_facets_kernel,
    plan_search_kernel,
    seek_feet_kernel,
)
from ...kernels.stepping.step import group_maximum_kernel
from ..creases.crease_launches import crease_kernels


def ply_kernels(real: type, lane_count: int) -> list[wp.Kernel]:
    """Kernels of the contact of plies, roughly in order of decreasing compile time."""
    return [
        meet_plies_kernel(real, lane_count),
        seek_feet_kernel(real, lane_count),
        push_facets_kernel(real, lane_count),
        list_nodes_kernel(real),
        adopt_lists_kernel(real, lane_count),
        surface_normals_kernel(real, lane_count),
        watch_speed_kernel(real, lane_count),
        begin_travel_kernel(real, lane_count),
        group_maximum_kernel(real, GROUP),
        survey_groups_kernel(real),
        count_strays_kernel(real),
        sum_up_kernel(real),
        list_strays_kernel(real),
        bound_facets_kernel(real),
        plan_search_kernel(real),
    ]


def own_contact_kernels(real: type, lane_count: int) -> list[wp.Kernel]:
    """Kernels of the contact of a sheet with itself, beside those."""
    return [
        seek_own_facets_kernel(real),
        follow_own_facets_kernel(real, lane_count),
        bound_groups_kernel(real),
        settle_own_search_kernel(real),
        *crease_kernels(real),
    ]


def mirror_kernels(real: type, lane_count: int) -> list[wp.Kernel]:
    """Kernels of the contact of a sheet with its mirror image, beside those."""
    return [meet_mirror_kernel(real, lane_count), watch_mirror_kernel(real, lane_count)]
