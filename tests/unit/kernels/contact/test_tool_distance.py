"""Parts of the wrong kind are refused, or stop a run; the right ones are those of the registry."""

import numpy as np
import pytest
import warp as wp

from weavesim.kernels.contact.tool_distance import part_distance_function
from weavesim.kernels.contact.tool_shapes import SHAPE_KINDS, part_struct
from weavesim.kernels.lanes import lane_types


def test_kinds_have_a_number_each_and_read_fields_of_the_part():
    assert [kind.number for kind in SHAPE_KINDS.values()] == list(range(len(SHAPE_KINDS)))
    for kind in SHAPE_KINDS.values():
        assert set(kind.dimensions) <= set(part_struct(wp.float64).vars)


def test_function_for_an_unknown_kind_is_refused():
    with pytest.raises(ValueError, match="no distance function of cone; there are plane, sphere"):
        part_distance_function(wp.float64, 1, ("plane", "cone"))


def test_part_of_a_kind_that_the_function_is_not_made_for_has_no_distance():
    part_distance, lanes3 = part_distance_function(wp.float64, 1, ("sphere",)), lane_types(wp.float64, 1).lanes3

    @wp.kernel(module="unique", enable_backward=False)
    def height(parts: wp.array(dtype=part_struct(wp.float64)), distance: wp.array(dtype=wp.float64)):
        i = wp.tid()
        x = lanes3()
        x[2, 0] = wp.float64(3.0)
        d, _n = part_distance(parts[i], x)
        distance[i] = d[0]

    parts = []
    for name in ("sphere", "plane"):
        part = part_struct(wp.float64)()
        part.kind, part.radius = SHAPE_KINDS[name].number, 1.0
        parts.append(part)
    distance = wp.zeros(2, dtype=wp.float64, device="cpu")
    wp.launch(
        height, dim=2, inputs=[wp.array(parts, dtype=part_struct(wp.float64), device="cpu"), distance], device="cpu"
    )
    assert distance.numpy()[0] == 2.0
    assert np.isnan(distance.numpy()[1])
