"""A kernel of the nodes is made for the traits of a run: no two of them may share what is compiled."""

from itertools import product

import pytest
import warp as wp

from weavesim.kernels.contact.tool_shapes import SHAPE_KINDS
from weavesim.kernels.stepping.node import node_motion_kernel
from weavesim.kernels.stepping.node_data import NodeTraits

TRAITS = [
    *(NodeTraits(*flags) for flags in product((False, True), repeat=3)),
    *(NodeTraits(shape_kinds=(name,), rotated=rotated) for name in SHAPE_KINDS for rotated in (False, True)),
    NodeTraits(shape_kinds=("plane", "sphere")),
    NodeTraits(shape_kinds=("plane", "sphere"), follows_thickness=True),
]


@pytest.mark.parametrize("lane_count", [1, 16])
def test_kernels_of_different_traits_are_kept_apart_in_the_cache(lane_count):
    names = [node_motion_kernel(wp.float32, lane_count, traits).module.get_module_identifier(1) for traits in TRAITS]
    assert len(set(names)) == len(TRAITS)


def test_kernel_of_the_same_traits_is_the_same():
    assert node_motion_kernel(wp.float32, 1, NodeTraits()) is node_motion_kernel(wp.float32, 1, NodeTraits())
