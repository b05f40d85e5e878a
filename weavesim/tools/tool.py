"""A rigid tool: its shape, and how it moves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..checks import Vector, finite, unit_vector, vector
from ..errors import InputError
from ..process.strokes import Fixed, Motion
from .shapes import Shape, Triangles

if TYPE_CHECKING:
    import trimesh


@dataclass(frozen=True)
class Tool:
    """A rigid body that moves along one axis and that the sheet may touch on either face.

    Attributes:
        name: "punch", "die", "blank_holder", or any other.
        shape: where it stands at zero displacement.
        motion: along ``axis``.
        friction: Coulomb coefficient between tool and sheet.
        axis: direction of the motion, scaled to length one.
        colour: to draw it, red, green and blue from 0 to 1.
    """

    name: str
    shape: Shape
    motion: Motion = Fixed()
    friction: float = 0.2
    axis: Vector = (0.0, 0.0, 1.0)
    colour: Vector = (0.62, 0.65, 0.70)

    def __post_init__(self) -> None:
        if not isinstance(self.shape, Shape):
            raise InputError(f"tool {self.name}: shape is {self.shape!r}; it must be a shape, such as Plane or Sphere.")
        if not isinstance(self.motion, Motion):
            raise InputError(f"tool {self.name}: motion is {self.motion!r}; it must be Fixed, Stroke or ForceDriven.")
        friction = finite(f"tool {self.name}: friction", self.friction)
        if friction < 0.0:
            raise InputError(f"tool {self.name}: friction is {friction}; it must not be negative.")
        colour = vector(f"tool {self.name}: colour", self.colour)
        if min(colour) < 0.0 or max(colour) > 1.0:
            raise InputError(f"tool {self.name}: colour is {colour}; each of red, green and blue goes from 0 to 1.")
        object.__setattr__(self, "friction", friction)
        object.__setattr__(self, "colour", colour)
        object.__setattr__(self, "axis", unit_vector(f"tool {self.name}: axis", self.axis))

    @property
    def smallest_radius(self) -> float:
        """Smallest radius that the sheet may be bent over [m]."""
        return self.shape.smallest_radius

    def display_triangles(self) -> Triangles:
        """Triangles to draw, at zero displacement: vertices (n, 3) [m] and faces (m, 3)."""
        return self.shape.display_triangles()

    def display_mesh(self) -> trimesh.Trimesh:
        """``display_triangles`` as a trimesh, to measure or to export."""
        return self.shape.display_mesh()

    def elements_per_quarter_turn(self, element_size: float) -> float:
        """Elements of ``element_size`` [m] along 90 degrees of the smallest radius; below five is coarse."""
        return 0.5 * np.pi * self.smallest_radius / element_size

    def distance(
        self, points: np.ndarray, displacement: float = 0.0, device: str = "cpu"
    ) -> tuple[np.ndarray, np.ndarray]:
        """Signed distance of ``points`` (n, 3) [m], in double precision, and the outward normals (n, 3)."""
        import warp as wp

        from ..kernels.contact.tool_distance import sample_distance_kernel
        from .device import build_device_tools
        from .sampling import sample_meshes

        points = np.asarray(points, dtype=np.float64).reshape(-1, 3)
        tools = build_device_tools([self], wp.float64, device, sample_meshes([self], device))
        distance = wp.zeros(len(points), dtype=wp.float64, device=device)
        normal = wp.zeros(len(points), dtype=wp.vec3d, device=device)
        wp.launch(
            sample_distance_kernel(wp.float64, 1),
            dim=len(points),
            inputs=[
                tools.tool,
                tools.part,
                0,
                wp.float64(displacement),
                wp.array(points, dtype=wp.vec3d, device=device),
            ],
            outputs=[distance, normal],
            device=device,
        )
        return distance.numpy(), normal.numpy()
