"""The surface of a tool in its place, without the error of samples: of a mesh the triangles themselves."""

from __future__ import annotations

import numpy as np
import warp as wp

from ...device import initialise
from ...kernels.contact.mesh_nearest import nearest_face_kernel
from ...process.motions.paths import Place, Pose
from ..mesh_features import face_normals
from ..mesh_tool import MeshSurface
from ..shapes import Union
from ..solid_triangles import SolidTriangles
from ..tool import Tool
from .distance import ToolDistance

# The nearest triangle is found in single precision: another one may be nearer by this share of the largest coordinate.
ROUNDING = 5.0e-7
# Below this distance the nearest face tells the side of a point, not the difference to the nearest point [m].
TOUCHING = 1.0e-9


class ExactSurface:
    """Signed distance and outward normal of a tool in its place, (points (k, 3) [m]) -> (k,) [m], (k, 3).

    Analytic shapes have their own; of meshes the nearest point of all triangles is taken, in double precision.

    Args:
        tool: of any shape.
        place: where it is: its displacement along its axis [m], or its pose.

    Attributes:
        error: of the distance [m].
    """

    def __init__(self, tool: Tool, place: Place = 0.0) -> None:
        initialise()
        self._place, self._axis = place, np.array(tool.axis)
        parts = tool.shape.parts()
        self._meshes = [
            _Triangles(part.surface, np.array(part.origin), np.array(part.rotation))
            for part in parts
            if part.surface is not None
        ]
        others = tuple(part for part in parts if part.surface is None)
        self._analytic = ToolDistance(tool.model_copy(update={"shape": Union(others)})) if others else None
        self.error = max((mesh.error for mesh in self._meshes), default=0.0)

    def __call__(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        own = self._own(points)
        found = [mesh.nearest(own) for mesh in self._meshes]
        if self._analytic is not None:
            found.append(self._analytic(own))
        which = np.argmin([distance for distance, _ in found], axis=0)
        row = np.arange(len(own))
        distance, normal = (np.stack(values)[which, row] for values in zip(*found, strict=True))
        return distance, self._place.turned(normal) if isinstance(self._place, Pose) else normal

    def beyond(self, points: np.ndarray) -> np.ndarray:
        """Whether points (k, 3) lie beside the border of a mesh that is an open sheet, (k,) bool."""
        own = self._own(points)
        if not self._meshes or (self._analytic is None and all(mesh.surface.closed for mesh in self._meshes)):
            return np.zeros(len(own), dtype=bool)
        sheets = np.stack([mesh.nearest(own)[0] for mesh in self._meshes])
        each = np.stack([mesh.beyond(own, away) for mesh, away in zip(self._meshes, sheets, strict=True)])
        nearest = each[sheets.argmin(axis=0), np.arange(len(own))]
        if self._analytic is not None:
            nearest &= sheets.min(axis=0) < self._analytic(own)[0]
        return nearest

    def _own(self, points: np.ndarray) -> np.ndarray:
        """Points where the tool is not displaced."""
        points = np.asarray(points, dtype=np.float64).reshape(-1, 3)
        return self._place.back(points) if isinstance(self._place, Pose) else points - self._place * self._axis


class _Triangles:
    """The triangles of one mesh, in the frame of the tool."""

    def __init__(self, surface: MeshSurface, origin: np.ndarray, rotation: np.ndarray) -> None:
        self.surface, self._origin, self._rotation = surface, origin, rotation
        self._solid = SolidTriangles(surface, "cpu")
        self._corner = surface.solid_vertices[surface.solid_faces]
        self._normal = face_normals(surface.solid_vertices, surface.solid_faces)[0]
        self._shown = surface.vertices[surface.faces]
        self._shown_mesh = self._solid.mesh if surface.closed else self._on_cpu(surface.vertices, surface.faces)
        self.error = ROUNDING * float(np.abs(surface.vertices - surface.centre).max())

    def _on_cpu(self, vertices: np.ndarray, faces: np.ndarray) -> wp.Mesh:
        return wp.Mesh(
            points=wp.array(vertices - self.surface.centre, dtype=wp.vec3, device="cpu"),
            indices=wp.array(faces.ravel(), dtype=wp.int32, device="cpu"),
            support_winding_number=True,
        )

    def nearest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Signed distance (k,) [m] and outward normal (k, 3)."""
        own = (points - self._origin) @ self._rotation
        face, rough = self._faces(self._solid.mesh, own)
        away, size = _away(self._corner[face], own)
        facing = self._normal[face]
        sign = np.where(np.abs(rough) > self.error, np.sign(rough), np.sign(np.einsum("ki,ki->k", away, facing)))
        sign[sign == 0.0] = 1.0
        distance = sign * size
        outward = np.where((size > TOUCHING)[:, None], away / np.where(size > 0.0, distance, 1.0)[:, None], facing)
        return distance, outward @ self._rotation.T

    def beyond(self, points: np.ndarray, distance: np.ndarray) -> np.ndarray:
        """Whether the wall that makes a sheet solid is nearer than the sheet, (k,) bool; with the ``nearest`` [m]."""
        if self.surface.closed:
            return np.zeros(len(points), dtype=bool)
        own = (points - self._origin) @ self._rotation
        face, _ = self._faces(self._shown_mesh, own)
        return _away(self._shown[face], own)[1] > np.abs(distance) + self.error

    def _faces(self, mesh: wp.Mesh, own: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The nearest face of each point, and the signed distance in single precision."""
        face = wp.zeros(len(own), dtype=wp.int32, device="cpu")
        distance = wp.zeros(len(own), dtype=float, device="cpu")
        near: wp.array = wp.array(own - self.surface.centre, dtype=wp.vec3, device="cpu")
        inputs = [mesh.id, near, float(np.finfo(np.float32).max), self._solid.crossed]
        wp.launch(nearest_face_kernel, dim=len(own), inputs=inputs, outputs=[face, distance], device="cpu")
        return face.numpy(), distance.numpy().astype(np.float64)


def _away(corners: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """From the nearest point of each triangle to its point (k, 3) [m], and the length of that (k,)."""
    from trimesh.triangles import closest_point

    # its tolerances are lengths: every triangle is made as large as one, around its point
    seen = corners - points[:, None]
    scale = np.maximum(np.ptp(seen, axis=1).max(axis=1), 1.0e-300)
    away = -scale[:, None] * closest_point(seen / scale[:, None, None], np.zeros_like(points))
    return away, np.linalg.norm(away, axis=1)
