"""Shapes of rigid tools: analytic signed distances and their unions, each placed by an origin and a rotation.

A shape is solid where its distance is negative. ``kernels/contact/tool_shapes.py`` contains the formula of each kind; a
shape names its kind, gives its dimensions, and provides triangles for drawing.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import BeforeValidator, SerializeAsAny, field_validator, model_validator

from ..checks import Kinded, NotNegative, Positive
from ..errors import InputError
from ..quantities import FiniteVector, Vector, unit_vector, vector
from ..ranges import Quantity, argument
from .drawing import CIRCLE_COUNT, Triangles, ring_triangles, stadium_rings, swept

if TYPE_CHECKING:
    import trimesh

    from .mesh_tool import MeshSurface

Matrix = tuple[Vector, Vector, Vector]
IDENTITY: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def rotation_matrix(axis: Any, angle: float) -> Matrix:
    """Rotation by ``angle`` [rad] about ``axis``; its columns are the rotated coordinate axes.

    Raises:
        InputError: no direction, or an angle beyond a whole turn.
    """
    angle = argument("angle", angle, "turn", negative=True)
    x, y, z = unit_vector("axis of the rotation", axis)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    matrix = np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * (cross @ cross)
    # sin(pi) is not exactly zero: make half a turn exact
    return _matrix(np.where(np.abs(matrix) < 1.0e-15, 0.0, matrix))


def _matrix(value: Any) -> Matrix:
    try:
        rows = [vector(f"row {k}", row) for k, row in enumerate(value)]
    except TypeError:
        rows = []
    array = np.array(rows)
    if array.shape != (3, 3) or np.abs(array @ array.T - np.eye(3)).max() > 1e-6 or np.linalg.det(array) < 0.0:
        raise InputError(
            "a 3 x 3 rotation matrix is needed (orthonormal columns, right-handed), for example "
            "weavesim.rotation_matrix((0, 1, 0), angle)"
        )
    return (rows[0], rows[1], rows[2])


class Shape(Kinded):
    """A shape with its own frame: its point p is at ``origin + rotation @ p`` at zero displacement of the tool.

    Attributes:
        origin: [m].
        rotation: 3 x 3, its columns are the shape's axes in the world.
        distance_function: its name in ``kernels/contact/tool_shapes.py``, or the full name of the module of its
            ``SHAPE``.
        dimension_names: attributes that are the function's dimensions.
    """

    distance_function: ClassVar[str] = ""
    dimension_names: ClassVar[tuple[str, ...]] = ()

    origin: Annotated[FiniteVector, Quantity("position")] = (0.0, 0.0, 0.0)
    rotation: Annotated[Matrix, BeforeValidator(_matrix)] = IDENTITY

    @property
    def smallest_radius(self) -> float:
        """Smallest convex radius over which a sheet may bend [m]; infinite for a plane."""
        raise NotImplementedError

    def smallest_width(self, axis: Any = (0.0, 0.0, 1.0)) -> float:
        """Width of the most slender part seen along ``axis`` in the world [m]; infinite if it is wide or unknown.

        The sheet's nodes may pass a part that is more slender than its elements.
        """
        return math.inf

    def parts(self) -> tuple[Shape, ...]:
        """The shapes of a union, all in one frame; a single shape is its only part."""
        return (self,)

    @property
    def surface(self) -> MeshSurface | None:
        """The mesh whose sampled distance is this shape's; None if a formula gives the distance."""
        return None

    def placed(self, origin: Any, rotation: Any = IDENTITY) -> Self:
        """This shape moved as a whole: rotated by ``rotation`` about the world's origin, then shifted by ``origin``."""
        turn = np.array(_matrix(rotation))
        place = turn @ np.array(self.origin) + np.array(vector("origin", origin))
        return self.model_copy(update={"origin": place, "rotation": turn @ np.array(self.rotation)})

    def dimensions(self) -> dict[str, float]:
        """Dimensions for the distance function [m]."""
        return {name: getattr(self, name) for name in self.dimension_names}

    def display_triangles(self) -> Triangles:
        """Triangles for drawing, in the world, at zero displacement: vertices (n, 3) [m] and faces (m, 3)."""
        vertices, faces = self.local_triangles()
        return vertices @ np.array(self.rotation).T + np.array(self.origin), faces

    def display_mesh(self) -> trimesh.Trimesh:
        """``display_triangles`` as a trimesh, for measuring or export."""
        import trimesh

        vertices, faces = self.display_triangles()
        return trimesh.Trimesh(vertices=vertices, faces=faces, process=False)

    def local_triangles(self) -> Triangles:
        """Triangles to draw, in the shape's own frame: vertices (n, 3) [m] and faces (m, 3), seen from outside."""
        raise NotImplementedError


class Plane(Shape):
    """Solid z < 0. ``display_size`` [m] is the drawn size along x and y; the plane itself is infinite."""

    distance_function = "plane"

    positional = ("display_size",)

    display_size: Annotated[tuple[Positive, Positive], Quantity("length")] = (0.6, 0.6)

    @property
    def smallest_radius(self) -> float:
        return math.inf

    def local_triangles(self) -> Triangles:
        half = 0.5 * np.array(self.display_size)
        corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half
        return np.column_stack([corners, np.zeros(4)]), np.array([[0, 1, 2], [0, 2, 3]])


class Sphere(Shape):
    """A ball of ``radius`` [m]."""

    distance_function = "sphere"
    dimension_names = ("radius",)
    positional = ("radius",)

    radius: Annotated[Positive, Quantity("length")]

    @property
    def smallest_radius(self) -> float:
        return self.radius

    def smallest_width(self, axis: Any = (0.0, 0.0, 1.0)) -> float:
        return 2.0 * self.radius

    def local_triangles(self) -> Triangles:
        latitude = np.linspace(-0.5, 0.5, CIRCLE_COUNT // 2 + 1) * np.pi
        return swept(self.radius * np.cos(latitude), self.radius * np.sin(latitude), 0.0)


class Capsule(Shape):
    """All points within ``radius`` [m] of a segment along x that extends ``half_length`` [m] to each side."""

    distance_function = "capsule"
    dimension_names = ("radius", "half_length")
    positional = ("radius", "half_length")

    radius: Annotated[Positive, Quantity("length")]
    half_length: Annotated[Positive, Quantity("length")]

    @property
    def smallest_radius(self) -> float:
        return self.radius

    def smallest_width(self, axis: Any = (0.0, 0.0, 1.0)) -> float:
        return 2.0 * self.radius

    def local_triangles(self) -> Triangles:
        latitude = np.linspace(-0.5, 0.5, CIRCLE_COUNT // 2 + 1) * np.pi
        return swept(self.radius * np.cos(latitude), self.radius * np.sin(latitude), self.half_length)


class Torus(Shape):
    """A tube of ``radius`` [m] along a circle of ``major_radius`` [m] about z."""

    distance_function = "torus"
    dimension_names = ("radius", "major_radius")
    positional = ("radius", "major_radius")

    radius: Annotated[Positive, Quantity("length")]
    major_radius: Annotated[Positive, Quantity("length")]

    @model_validator(mode="after")
    def _has_a_hole(self) -> Self:
        if self.radius >= self.major_radius:
            raise ValueError(f"radius = {self.radius} m: it must be below major_radius, {self.major_radius} m")
        return self

    @property
    def smallest_radius(self) -> float:
        return self.radius

    def smallest_width(self, axis: Any = (0.0, 0.0, 1.0)) -> float:
        return 2.0 * self.radius

    def local_triangles(self) -> Triangles:
        angle = np.linspace(-1.0, 1.0, CIRCLE_COUNT // 2 + 1) * np.pi
        return swept(self.major_radius + self.radius * np.cos(angle), self.radius * np.sin(angle), 0.0)


class _Dome(Shape):
    """Common base of ``DomePunch`` and ``DomeCavity``: two balls with centres 2 ``half_length`` apart along x."""

    is_kind: ClassVar[bool] = False
    dimension_names = ("radius", "half_length")
    positional: ClassVar[tuple[str, ...]] = ("radius", "half_length")

    radius: Annotated[Positive, Quantity("length")]
    half_length: Annotated[NotNegative, Quantity("length")]

    @property
    def smallest_radius(self) -> float:
        return self.radius


class DomePunch(_Dome):
    """Two half-balls joined by a half-cylinder along x, facing -z, with vertical walls that extend up to infinity.

    Attributes:
        radius: of balls and cylinder [m].
        half_length: half the distance between the balls' centres [m]; zero gives a hemispherical punch.
        display_height: drawn height of the walls above the centres [m]; None draws one radius.
    """

    distance_function = "dome_punch"

    positional = ("radius", "half_length", "display_height")

    display_height: Annotated[Positive, Quantity("length")] | None = None

    def smallest_width(self, axis: Any = (0.0, 0.0, 1.0)) -> float:
        return 2.0 * self.radius

    def local_triangles(self) -> Triangles:
        latitude = np.linspace(-0.5, 0.0, CIRCLE_COUNT // 4 + 1) * np.pi
        height = self.radius if self.display_height is None else self.display_height
        out = np.append(self.radius * np.cos(latitude), self.radius)
        z = np.append(self.radius * np.sin(latitude), height)
        return swept(out, z, self.half_length, capped=True)


class DomeOpening(Shape):
    """A plate, solid z < 0, with a vertical opening around a segment of the x axis and a rounded upper edge.

    Attributes:
        radius: distance of the opening's wall from the segment [m].
        half_length: of the segment [m]; zero gives a round opening.
        edge_radius: of the rounded entry [m]; zero gives a sharp edge.
        display_size: drawn size of the plate along x and y [m]; None leaves a border of twice the opening's radius.
        display_depth: drawn depth of the wall [m]; None draws one radius.
    """

    distance_function = "dome_opening"
    dimension_names: ClassVar[tuple[str, ...]] = ("radius", "half_length", "edge_radius")
    positional = ("radius", "half_length", "edge_radius", "display_size", "display_depth")

    radius: Annotated[Positive, Quantity("length")]
    half_length: Annotated[NotNegative, Quantity("length")]
    edge_radius: Annotated[NotNegative, Quantity("length")]
    display_size: Annotated[tuple[Positive, Positive], Quantity("length")] | None = None
    display_depth: Annotated[Positive, Quantity("length")] | None = None

    @property
    def smallest_radius(self) -> float:
        return self.edge_radius

    def local_triangles(self) -> Triangles:
        rim = self.radius + self.edge_radius
        if self.display_size is None:
            half = np.array([self.half_length + rim + 2.0 * self.radius, rim + 2.0 * self.radius])
        else:
            half = 0.5 * np.array(self.display_size)
        if half[0] <= self.half_length + rim or half[1] <= rim:
            raise InputError(
                f"DomeOpening.display_size is {self.display_size} m; the opening with its rounded edge alone takes "
                f"{2 * (self.half_length + rim):.4g} m by {2 * rim:.4g} m."
            )
        depth = self.radius if self.display_depth is None else self.display_depth
        depth = max(depth, 1.01 * self.edge_radius)
        angle = np.linspace(0.0, 0.5, CIRCLE_COUNT // 8 + 1 if self.edge_radius > 0.0 else 1) * np.pi
        out = np.concatenate([[self.radius], rim - self.edge_radius * np.cos(angle)])
        z = np.concatenate([[-depth], self.edge_radius * (np.sin(angle) - 1.0)])
        rings = stadium_rings(out, z, self.half_length)
        # the plate ends at a rectangle: rays from the centre, with the nearest one moved to each corner
        last = rings[-1]
        ray = np.min(half / np.maximum(np.abs(last[:, :2]), 1e-12), axis=1)
        border = np.column_stack([last[:, :2] * ray[:, None], np.zeros(len(last))])
        for corner in np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) * half:
            border[np.argmin(np.linalg.norm(border[:, :2] - corner, axis=1)), :2] = corner
        vertices, faces = ring_triangles(np.concatenate([rings, border[None]]))
        return vertices, faces[:, ::-1]  # rings run upwards along the wall: reversed to face the opening


class DomeCavity(_Dome):
    """A block, solid z < 0, with a hollow: two quarter-balls joined by a half-cylinder along x, open to +z.

    It closes a ``DomeOpening`` of the same radius at the bottom, and is the counterpart of a ``DomePunch``. A sheet
    lies in the hollow and does not bend over its rim, which the opening above covers: the smallest radius is the
    hollow's.

    Attributes:
        radius: of balls and cylinder [m].
        half_length: half the distance between the balls' centres [m]; zero gives a hemispherical hollow.
    """

    distance_function = "dome_cavity"

    def local_triangles(self) -> Triangles:
        latitude = np.linspace(-0.5, 0.0, CIRCLE_COUNT // 4 + 1) * np.pi
        vertices, faces = swept(self.radius * np.cos(latitude), self.radius * np.sin(latitude), self.half_length)
        return vertices, faces[:, ::-1]  # seen from inside the hollow


class Union(Shape):
    """Several shapes as one tool: its distance is that of the nearest shape.

    Exact outside; inside, where shapes overlap, it is a bound.
    """

    positional = ("shapes",)

    shapes: tuple[SerializeAsAny[Shape], ...]

    @field_validator("shapes")
    @classmethod
    def _are_some(cls, value: tuple[Shape, ...]) -> tuple[Shape, ...]:
        if not value:
            raise ValueError("it takes one or more shapes, such as Sphere or Capsule")
        return value

    @property
    def smallest_radius(self) -> float:
        return min(shape.smallest_radius for shape in self.shapes)

    def smallest_width(self, axis: Any = (0.0, 0.0, 1.0)) -> float:
        return min(part.smallest_width(axis) for part in self.parts())

    def parts(self) -> tuple[Shape, ...]:
        return tuple(part.placed(self.origin, self.rotation) for shape in self.shapes for part in shape.parts())

    def display_triangles(self) -> Triangles:
        vertices, faces = zip(*(part.display_triangles() for part in self.parts()), strict=True)
        first = np.cumsum([0, *(len(part) for part in vertices[:-1])])
        return np.concatenate(vertices), np.concatenate([f + start for f, start in zip(faces, first, strict=True)])


def shape_kinds(shapes: Iterable[Shape]) -> tuple[str, ...]:
    """Names of the distance functions of all parts of ``shapes``, each once, sorted."""
    return tuple(sorted({part.distance_function for shape in shapes for part in shape.parts()}))
