"""Signed distance and outward normal of every kind of tool part: one function each.

A function takes the part and points in the part's frame, and is negative inside. A further kind is a module anywhere
with a ``SHAPE``, a ``ShapeKind``; its name is the module's full name.
"""

import sys
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from itertools import product
from types import MappingProxyType
from typing import Any
from zlib import crc32

import warp as wp

from ..lanes import fill, from_rows, larger, magnitude, smaller, square_root, where_positive
from ..operators import add, div, mul, sub  # noqa: F401
from .mesh_samples import volume_distance


@cache
def part_struct(real: type):
    """One part of a tool: kind, frame and dimensions [m]."""
    vec3 = wp.types.vector(3, real)

    @wp.struct
    class ToolPart:
        kind: wp.int32  # see shape_number
        origin: wp.vec3d  # in double precision, so that a part may be far from zero
        rotation: wp.types.matrix((3, 3), real)  # columns: the part's axes in the world
        radius: real
        major_radius: real
        half_length: real
        edge_radius: real
        volume: wp.uint64  # address of a SampledMesh in the part's frame
        lower: vec3  # further dimensions, see number
        upper: vec3
        reach: real  # of a sampled mesh: up to which distances are sampled; beyond it begins what is not [m]

    return ToolPart


@wp.func
def stadium_profile(x: Any, y: Any, half_length: Any):
    """Distance to a segment along x in the plan view, and the two components of its vector."""
    zero = fill(x, 0.0)
    over = larger(magnitude(x) - fill(x, half_length), zero)
    along = where_positive(x, over, -over)
    return square_root(along * along + y * y), along, y


@wp.func
def safe_inverse(length: Any):
    tiny = fill(length, 1.0e-12)
    return fill(length, 1.0) / larger(length, tiny)


@wp.func
def segment_distance(x: Any, y: Any, z: Any, half_length: Any, radius: Any):
    """Distance and normal of all points within ``radius`` of the segment |x| <= half_length."""
    out, along, across = stadium_profile(x, y, half_length)
    length = square_root(out * out + z * z)
    inverse = safe_inverse(length)
    distance = length - fill(x, radius)
    return distance, from_rows(along * inverse, across * inverse, z * inverse)


@wp.func
def plane_distance(part: Any, p: Any):
    """Solid z < 0."""
    zero = fill(p[2], 0.0)
    return p[2], from_rows(zero, zero, fill(p[2], 1.0))


@wp.func
def sphere_distance(part: Any, p: Any):
    """A ball about the origin."""
    return segment_distance(p[0], p[1], p[2], part.radius.dtype(0.0), part.radius)


@wp.func
def capsule_distance(part: Any, p: Any):
    """All points within ``radius`` of a segment along x."""
    return segment_distance(p[0], p[1], p[2], part.half_length, part.radius)


@wp.func
def dome_punch_distance(part: Any, p: Any):
    """Lower half of a capsule along x, extruded to z = +infinity."""
    return segment_distance(p[0], p[1], smaller(p[2], fill(p[2], 0.0)), part.half_length, part.radius)


@wp.func
def torus_distance(part: Any, p: Any):
    """A tube along a circle about z."""
    x = p[0]
    y = p[1]
    z = p[2]
    out = square_root(x * x + y * y)
    a = out - fill(x, part.major_radius)
    length = square_root(a * a + z * z)
    inverse = safe_inverse(length)
    inverse_out = safe_inverse(out)
    distance = length - fill(x, part.radius)
    return distance, from_rows(a * inverse * x * inverse_out, a * inverse * y * inverse_out, z * inverse)


@wp.func
def dome_opening_distance(part: Any, p: Any):
    """Plate z < 0 with an opening around a segment along x, its upper edge rounded."""
    x = p[0]
    z = p[2]
    zero = fill(x, 0.0)
    one = fill(x, 1.0)
    out, along, across = stadium_profile(x, p[1], part.half_length)
    inverse_out = safe_inverse(out)
    edge = fill(x, part.edge_radius)
    # coordinates from the centre of the edge circle: a < 0 over the opening, b > 0 above
    a = out - fill(x, part.radius + part.edge_radius)
    b = z + edge
    wall = smaller(a, zero)
    top = larger(b, zero)
    corner = square_root(wall * wall + top * top)
    # in the corner quadrant the rounded edge; elsewhere in the solid the nearer of wall and top
    rounded = corner - edge
    inner = larger(-a, b) - edge
    distance = where_positive(corner, rounded, inner)
    inverse_corner = safe_inverse(corner)
    wall_nearer = where_positive(-a - b, one, zero)
    normal_out = where_positive(corner, wall * inverse_corner, -wall_nearer)
    normal_up = where_positive(corner, top * inverse_corner, one - wall_nearer)
    return distance, from_rows(normal_out * along * inverse_out, normal_out * across * inverse_out, normal_up)


@wp.func
def dome_cavity_distance(part: Any, p: Any):
    """Block z < 0 with a hollow, the lower half of a capsule along x."""
    x = p[0]
    z = p[2]
    zero = fill(x, 0.0)
    one = fill(x, 1.0)
    out, along, across = stadium_profile(x, p[1], part.half_length)
    inverse_out = safe_inverse(out)
    # below the top: the hollow, or the top itself where that is nearer
    deep = square_root(out * out + z * z)
    inverse_deep = safe_inverse(deep)
    hollow = fill(x, part.radius) - deep
    top_nearer = z - hollow
    # above it: the rim, or the top next to it
    wall = larger(fill(x, part.radius) - out, zero)
    high = square_root(wall * wall + z * z)
    inverse_high = safe_inverse(high)
    distance = where_positive(z, high, larger(hollow, z))
    normal_out = where_positive(
        z, -(wall * inverse_high) * inverse_out, where_positive(top_nearer, zero, -inverse_deep)
    )
    normal_up = where_positive(z, z * inverse_high, where_positive(top_nearer, one, -(z * inverse_deep)))
    return distance, from_rows(normal_out * along, normal_out * across, normal_up)


# Fields of the part that a kind may have among its dimensions.
NAMED_DIMENSIONS = ("radius", "major_radius", "half_length", "edge_radius", "volume", "reach")
# Where the others stand: a formula has no box. A vector of their own in the part, which is copied in the innermost
# loop, made a step of the double dome 8 % slower (16 lanes, float32).
NUMBER_PLACES = (*product(("lower", "upper"), range(3)),)


@wp.func
def number(part: Any, index: int):
    """Dimension of a part that is no field of it, see ``ShapeKind``."""
    return wp.where(index < 3, part.lower[index % 3], part.upper[index % 3])


@dataclass(frozen=True, eq=False)
class ShapeKind:
    """A kind of part.

    Attributes:
        distance: Warp function (part, points as rows of lanes) -> (distance, normals as rows of lanes).
        dimensions: what it reads of the part in addition to the frame. Those of ``NAMED_DIMENSIONS`` are fields of the
            part; the others are ``number(part, 0)``, ``number(part, 1)`` and so on, in this order.

    Raises:
        ValueError: there are more than six others.
    """

    distance: Any
    dimensions: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        others = [name for name in self.dimensions if name not in NAMED_DIMENSIONS]
        if len(others) > len(NUMBER_PLACES):
            raise ValueError(
                f"a shape has at most {len(NUMBER_PLACES)} dimensions beside {', '.join(NAMED_DIMENSIONS)}; these are "
                f"{len(others)}: {', '.join(others)}"
            )

    @property
    def places(self) -> dict[str, tuple[str, int]]:
        """Field of the part, and index in it, of every dimension that is no field of its own."""
        others = (name for name in self.dimensions if name not in NAMED_DIMENSIONS)
        return dict(zip(others, NUMBER_PLACES, strict=False))


SHAPE_KINDS: Mapping[str, ShapeKind] = MappingProxyType(
    {
        "plane": ShapeKind(plane_distance),
        "sphere": ShapeKind(sphere_distance, ("radius",)),
        "capsule": ShapeKind(capsule_distance, ("radius", "half_length")),
        "torus": ShapeKind(torus_distance, ("radius", "major_radius")),
        "dome_punch": ShapeKind(dome_punch_distance, ("radius", "half_length")),
        "dome_opening": ShapeKind(dome_opening_distance, ("radius", "half_length", "edge_radius")),
        "dome_cavity": ShapeKind(dome_cavity_distance, ("radius", "half_length")),
        "volume": ShapeKind(volume_distance, ("volume", "reach", "checked", "error", "largest_error")),
    }
)


def shape_kind(name: str) -> ShapeKind:
    """The kind of a name: one of ``SHAPE_KINDS``, or the ``SHAPE`` of a module, given by its full name.

    A name can be sent to another process, functions cannot.

    Raises:
        ValueError: there is no such kind.
    """
    if name in SHAPE_KINDS:
        return SHAPE_KINDS[name]
    kind = getattr(import_module(name), "SHAPE", None) if _is_module(name) else None
    if not isinstance(kind, ShapeKind):
        raise ValueError(
            f"no distance function {name!r}; choose one of {', '.join(SHAPE_KINDS)}, or give the full name of a module "
            "with a SHAPE (kernels/contact/tool_shapes.py)"
        )
    return kind


def _is_module(name: str) -> bool:
    if not all(part.isidentifier() for part in name.split(".")):
        return False
    try:
        return name in sys.modules or find_spec(name) is not None
    except ModuleNotFoundError:  # the package of the module
        return False


def further_kinds(names: tuple[str, ...]) -> tuple[str, ...]:
    """Those of ``names`` that are not in ``SHAPE_KINDS``."""
    return tuple(name for name in names if name not in SHAPE_KINDS)


def shape_number(name: str) -> int:
    """Number of a kind, as the kernels know it; it depends on the name alone, and is the same in every process."""
    known = list(SHAPE_KINDS)
    return known.index(name) if name in SHAPE_KINDS else len(known) + crc32(name.encode()) % 2**30
