"""Triangles of a tool mesh on a device, and simplified ones for the samples of their distance."""

from __future__ import annotations

import logging
import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import warp as wp

from ..device import launch_on_all_cores
from ..kernels.contact.fill_samples import SampledTriangles, mesh_distance_kernel
from .mesh_bodies import simplified
from .mesh_features import face_normals
from .mesh_repair import diagonal
from .mesh_tool import ANNOUNCED, MANY_TRIANGLES, MeshSurface

logger = logging.getLogger(__name__)

# Meshes of more triangles are simplified for the samples: within these shares of the spacing near the surface and far.
SIMPLIFIED_FACE_COUNT = 20_000
NEAR_TOLERANCE, FAR_TOLERANCE = 0.002, 0.02
# Faces whose outside is looked at.
PROBED_FACE_COUNT = 8_000
# How far from the middle of a face its outside is looked at, over the size of the mesh.
FACE_PROBE = 1e-4


class SolidTriangles:
    """The solid of a surface on a device, about its centre.

    Large meshes are simplified for samples ``spacing`` [m] apart, if given: ``near`` the surface and ``far`` from it.
    ``crossed`` says whether surfaces lie inside the solid, ``largest`` how far is searched [m].
    """

    def __init__(self, surface: MeshSurface, device: str, spacing: float | None = None) -> None:
        self.surface, self.device = surface, device
        vertices, faces = surface.solid_vertices, surface.solid_faces
        if len(surface.faces) > MANY_TRIANGLES:
            count = f"{len(surface.faces):,}"
            logger.info("%s: sampling the distance to %s triangles", surface.name, count, extra=ANNOUNCED)
        self.largest = 10.0 * diagonal(vertices)
        if spacing is not None and len(faces) > SIMPLIFIED_FACE_COUNT:
            tolerances = NEAR_TOLERANCE * spacing, FAR_TOLERANCE * spacing
            near, (vertices, faces) = self._simplified_meanwhile(tolerances)
            self.near, self.far = self._on_device(*near), self._on_device(vertices, faces)
        else:
            self.near = self.far = self.mesh = self._on_device(vertices, faces)
        self.crossed = int(self._has_inner_faces(vertices, faces))

    def _simplified_meanwhile(self, tolerances: tuple[float, float]) -> list[tuple[np.ndarray, np.ndarray]]:
        """Simplified triangles, made while ``mesh`` is built from those as given.

        manifold3d does not let Python go on while it works, but Warp does: it must have begun.
        """
        vertices, faces = self.surface.solid_vertices, self.surface.solid_faces
        begin = threading.Event()

        def simplify() -> list[tuple[np.ndarray, np.ndarray]]:
            begin.wait()
            return simplified(vertices, faces, tolerances)

        with ThreadPoolExecutor(1) as pool:
            others = pool.submit(simplify)
            try:
                self.mesh = self._on_device(vertices, faces, begin)
            finally:  # else the other would wait for ever
                begin.set()
            return others.result()

    def _on_device(self, vertices: np.ndarray, faces: np.ndarray, begin: threading.Event | None = None) -> wp.Mesh:
        """A mesh on the device; ``begin`` is set just before its tree is built."""
        points: wp.array = wp.array(vertices - self.surface.centre, dtype=wp.vec3, device=self.device)
        indices: wp.array = wp.array(faces.ravel(), dtype=wp.int32, device=self.device)
        if begin is not None:
            begin.set()
        return wp.Mesh(points=points, indices=indices, support_winding_number=True)

    def sampled(self, band: float) -> SampledTriangles:
        """What is sampled, the finer triangles within ``band`` [m] of the surface."""
        result = SampledTriangles()
        result.near, result.far, result.band, result.crossed = self.near.id, self.far.id, band, self.crossed
        return result

    def _has_inner_faces(self, vertices: np.ndarray, faces: np.ndarray) -> bool:
        """Whether the outside of a face of ``far`` lies inside the solid."""
        if len(faces) > PROBED_FACE_COUNT:
            faces = faces[np.random.default_rng(0).choice(len(faces), PROBED_FACE_COUNT, replace=False)]
        normal, area = face_normals(vertices, faces)
        size = diagonal(self.surface.vertices)
        points = (vertices[faces].mean(axis=1) + FACE_PROBE * size * normal)[area > (FACE_PROBE * size) ** 2]
        return bool(len(points)) and bool(np.any(self.distance(points, self.far, 1) < 0.0))

    def distance(self, points: np.ndarray, mesh: wp.Mesh, crossed: int) -> np.ndarray:
        """Signed distance (n,) [m] of ``points`` (n, 3) to one of the meshes."""
        distance = wp.zeros(len(points), dtype=float, device=self.device)
        near: wp.array = wp.array(points - self.surface.centre, dtype=wp.vec3, device=self.device)
        launch_on_all_cores(
            mesh_distance_kernel,
            (len(points),),
            lambda own: [mesh.id, near[own], self.largest, crossed, distance[own]],
            self.device,
        )
        return distance.numpy().astype(np.float64)
