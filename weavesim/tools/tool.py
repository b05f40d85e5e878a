"""A rigid tool: its shape and motion."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from pydantic import SerializeAsAny, field_validator

from ..checks import Parameters, Share
from ..names import Label
from ..process.friction import NO_YARNS, Friction, FrictionValue, YarnAngleFriction
from ..process.motions.paths import Place, moved_points, place_of
from ..process.strokes import Fixed, Motion
from ..quantities import UnitVector
from .shapes import Shape, Triangles

if TYPE_CHECKING:
    import trimesh


# A face whose normal has less than this along a direction neither faces it nor turns away from it.
LEAST_FACING = 0.05


class Tool(Parameters):
    """A rigid body that moves along an axis, or on a path and about an axis; it may touch the sheet on either face.

    Attributes:
        name: "punch", "die", "blank_holder", or any other.
        shape: at zero displacement.
        motion: along ``axis``; a ``PathMotion`` carries and turns the tool in addition.
        friction: between tool and sheet: a Coulomb coefficient, or a law (docs/plies.md).
        axis: direction of the motion, scaled to length one.
        colour: for drawing: red, green and blue from 0 to 1.
    """

    positional = ("name", "shape", "motion", "friction", "axis", "colour")

    name: Label
    shape: SerializeAsAny[Shape]
    motion: SerializeAsAny[Motion] = Fixed()
    friction: FrictionValue = 0.2
    axis: UnitVector = (0.0, 0.0, 1.0)
    colour: tuple[Share, Share, Share] = (0.62, 0.65, 0.70)

    @field_validator("friction")
    @classmethod
    def _knows_its_argument(cls, value: Friction | float) -> Friction | float:
        if isinstance(value, YarnAngleFriction):
            raise ValueError(NO_YARNS)
        return value

    @field_validator("motion")
    @classmethod
    def _moves_a_tool(cls, value: Motion) -> Motion:
        if not value.moves_tools:
            kinds = [name for name, kind in Motion.kinds().items() if kind.moves_tools]
            raise ValueError(f"it must be one of {', '.join(kinds)}")
        return value

    @property
    def smallest_radius(self) -> float:
        """Smallest radius over which the sheet may bend [m]."""
        return self.shape.smallest_radius

    @property
    def fillet_radius(self) -> float:
        """As ``smallest_radius``, but the sharp edges of meshes are ignored [m]."""
        parts = self.shape.parts()
        return min(part.smallest_radius if part.surface is None else part.surface.fillet_radius for part in parts)

    @cached_property
    def smallest_width(self) -> float:
        """Width of the most slender part of the shape, seen along the tool's axis [m]; infinite if wide or unknown.

        The nodes of a sheet may pass a part that is more slender than its elements.
        """
        return self.shape.smallest_width(self.axis)

    def display_triangles(self) -> Triangles:
        """Triangles for drawing, at zero displacement: vertices (n, 3) [m] and faces (m, 3)."""
        return self.shape.display_triangles()

    def display_mesh(self) -> trimesh.Trimesh:
        """``display_triangles`` as a trimesh, for measuring or export."""
        return self.shape.display_mesh()

    def sharp_edges_facing(self, points: np.ndarray) -> np.ndarray:
        """Middles (k, 3) [m] of convex sharp edges of its meshes over which a sheet of ``points`` (n, 3) may be drawn.

        They face the points along the axis and lie within their outline, both at zero displacement. Edges along the
        axis, and those on the tool's back, are left out.
        """
        axis = np.array(self.axis)
        across = np.linalg.svd(axis[None])[2][1:].T
        plan, level = points @ across, float(np.mean(points @ axis))
        found = []
        for part in self.shape.parts():
            surface = part.surface
            if surface is None or not len(surface.sharp_edges):
                continue
            turn = np.array(part.rotation)
            middle = surface.vertices[surface.sharp_edges].mean(axis=1) @ turn.T + np.array(part.origin)
            up = surface.sharp_edge_normals @ turn.T @ axis
            towards = up * np.sign(level - middle @ axis)[:, None]
            seen = (towards.min(axis=1) > -LEAST_FACING) & (towards.max(axis=1) > LEAST_FACING)
            within = np.all((middle @ across >= plan.min(axis=0)) & (middle @ across <= plan.max(axis=0)), axis=1)
            found.append(middle[seen & within])
        return np.concatenate([np.empty((0, 3)), *found])

    def elements_per_quarter_turn(self, element_size: float) -> float:
        """Elements of ``element_size`` [m] along 90 degrees of the fillet radius; below five is coarse."""
        return 0.5 * np.pi * self.fillet_radius / element_size

    def place(self, displacement: float, time: float) -> Place:
        """Where it is, displaced along its axis [m], at a time [s]: a pose if it is carried, else ``displacement``."""
        return place_of(self.motion, self.axis, displacement, time)

    def place_at(self, time: float) -> Place:
        """Where an unhindered motion has brought it at ``time`` [s]; one that a force moves is not displaced."""
        return self.place(0.0 if self.motion.by_force else self.motion.displacement_at(time), time)

    def moved(self, points: np.ndarray, place: Place) -> np.ndarray:
        """Points (n, 3) of the tool as drawn, where it is at ``place`` [m]."""
        return moved_points(points, self.axis, place)

    def distance(self, points: np.ndarray, place: Place = 0.0, device: str = "cpu") -> tuple[np.ndarray, np.ndarray]:
        """Signed distance of ``points`` (n, 3) [m], in double precision, and the outward normals (n, 3).

        Args:
            points: (n, 3) [m].
            place: where the tool is: its displacement along its axis [m], or its pose.
            device: name in Warp.
        """
        from .surfaces.distance import ToolDistance

        return ToolDistance(self, device)(points, place)
