"""Parts of the wrong kind are refused, or stop a run; the right ones are those of the registry."""

import sys
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import warp as wp

from weavesim.kernels.contact.tool_distance import part_distance_function
from weavesim.kernels.contact.tool_shapes import (
    SHAPE_KINDS,
    ShapeKind,
    number,
    part_struct,
    plane_distance,
    shape_number,
)
from weavesim.kernels.lane_types import lane_types
from weavesim.kernels.lanes import fill


def test_kinds_have_a_number_each_and_read_fields_of_the_part():
    assert [shape_number(name) for name in SHAPE_KINDS] == list(range(len(SHAPE_KINDS)))
    assert shape_number("package.cone") == shape_number("package.cone") > len(SHAPE_KINDS)
    assert shape_number("package.cone") != shape_number("package.wedge")
    for name, kind in SHAPE_KINDS.items():
        if name != "volume":
            assert set(kind.dimensions) <= set(part_struct(wp.float64).vars) and not kind.places


def test_dimensions_that_are_no_field_stand_among_the_numbers():
    kind = ShapeKind(plane_distance, ("height", "radius", "angle"))
    assert kind.places == {"height": ("lower", 0), "angle": ("lower", 1)}
    with pytest.raises(ValueError, match="at most 6 dimensions beside radius, .*; these are 7: a, b"):
        ShapeKind(plane_distance, tuple("abcdefg"))


def test_six_dimensions_are_read_as_they_were_given():
    kind = ShapeKind(plane_distance, tuple("abcdef"))
    part = part_struct(wp.float64)()
    for value, (field, index) in enumerate(kind.places.values()):
        getattr(part, field)[index] = float(value)

    @wp.kernel(module="unique", enable_backward=False)
    def read(parts: wp.array(dtype=part_struct(wp.float64)), found: wp.array(dtype=wp.float64)):
        i = wp.tid()
        found[i] = number(parts[0], i)

    found = wp.zeros(6, dtype=wp.float64, device="cpu")
    parts = wp.array([part], dtype=part_struct(wp.float64), device="cpu")
    wp.launch(read, dim=6, inputs=[parts, found], device="cpu")
    assert found.numpy().tolist() == [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]


@wp.func
def low_distance(part: Any, p: Any):
    return p[2] + fill(p[2], 1.0), p


@wp.func
def high_distance(part: Any, p: Any):
    return p[2] - fill(p[2], 1.0), p


def compiled_name(patch: pytest.MonkeyPatch, name: str, distance: wp.Function) -> str:
    """Under which the kernel of one kind is kept in the cache, as another process would find it."""
    patch.setitem(sys.modules, name, SimpleNamespace(SHAPE=ShapeKind(distance)))
    part_distance = part_distance_function.__wrapped__(wp.float64, 1, (name,))
    lanes3, ToolPart = lane_types(wp.float64, 1).lanes3, part_struct(wp.float64)

    @wp.kernel(module="unique", enable_backward=False)
    def height(parts: wp.array(dtype=ToolPart), distance: wp.array(dtype=wp.float64)):
        d, _n = part_distance(parts[0], lanes3())
        distance[0] = d[0]

    return height.module.get_module_identifier(1)


def test_kernels_of_further_kinds_are_kept_apart_in_the_cache(monkeypatch):
    first = compiled_name(monkeypatch, "user_cone", low_distance)
    assert compiled_name(monkeypatch, "user_cone", low_distance) == first
    # the same name in another project, and the same function under another name, which has another number
    assert compiled_name(monkeypatch, "user_cone", high_distance) != first
    assert compiled_name(monkeypatch, "user_wedge", low_distance) != first


def test_function_for_an_unknown_kind_is_refused():
    with pytest.raises(ValueError, match="no distance function 'cone'; choose one of plane, sphere"):
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
        part.kind, part.radius = shape_number(name), 1.0
        parts.append(part)
    distance = wp.zeros(2, dtype=wp.float64, device="cpu")
    wp.launch(
        height, dim=2, inputs=[wp.array(parts, dtype=part_struct(wp.float64), device="cpu"), distance], device="cpu"
    )
    assert distance.numpy()[0] == 2.0
    assert np.isnan(distance.numpy()[1])
