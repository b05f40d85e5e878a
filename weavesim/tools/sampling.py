"""Samples of the signed distance of triangle meshes on sparse volumes, and their accuracy."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import numpy as np
import warp as wp

from ..errors import InputError
from ..kernels.contact.mesh_distance import (
    TILE_REACH,
    TILE_SIZE,
    fill_tiles_kernel,
    mesh_distance_kernel,
    volume_distance_kernel,
)
from .mesh_repair import triangle_areas
from .mesh_tool import MeshSurface

if TYPE_CHECKING:
    from .tool import Tool

# Largest number of voxels: the first for an automatic spacing, the second for a given one.
CHOSEN_VOXEL_COUNT = 6_000_000
LARGEST_VOXEL_COUNT = 150_000_000
ERROR_SAMPLE_COUNT = 20_000


@dataclass(frozen=True, eq=False)
class SampledDistance:
    """Signed distance of a mesh on the voxels of a volume, with the sampling error.

    Attributes:
        volume: sparse, float32; its background is ``reach``.
        lower, upper: box within which the volume is read, (3,) [m].
        spacing: of the voxels [m].
        reach: distances are truncated to plus and minus this [m].
        voxel_count: number of values.
        largest_error: largest difference to the mesh at random points within three voxels of its surface [m].
        usual_error: 99th percentile at these points [m]; the largest errors are at sharp edges.
        mean_error: root mean square at these points [m].
    """

    volume: wp.Volume
    lower: np.ndarray
    upper: np.ndarray
    spacing: float
    reach: float
    voxel_count: int
    largest_error: float
    usual_error: float
    mean_error: float

    def dimensions(self) -> dict[str, Any]:
        """Values that the kernels read; see ``ShapeKind`` in ``kernels/contact/tool_shapes.py``."""
        return {
            "volume": self.volume.id,
            "lower": tuple(self.lower),
            "upper": tuple(self.upper),
            "reach": self.reach,
        }

    def note(self, name: str) -> str:
        """Note about the sampling for the log."""
        return (
            f"{name}: distance sampled every {self.spacing * 1e3:.3g} mm at {self.voxel_count} points, "
            f"error near the surface {self.mean_error * 1e3:.2g} mm rms, {self.usual_error * 1e3:.2g} mm "
            f"for 99 % of all points, {self.largest_error * 1e3:.2g} mm at most"
        )


Samples = Mapping[MeshSurface, SampledDistance]

# The samples of each surface by device, kept as long as the surface exists.
_kept: WeakKeyDictionary[MeshSurface, dict[str, SampledDistance]] = WeakKeyDictionary()


def mesh_parts(tools: Iterable[Tool]) -> dict[str, MeshSurface]:
    """Triangle meshes among the tools and their parts, by name."""
    return {
        f"{tool.name} {index}": part.surface
        for tool in tools
        for index, part in enumerate(tool.shape.parts())
        if part.surface is not None
    }


def sample_meshes(tools: Iterable[Tool], device: str, thickness: float = 0.0) -> Samples:
    """The sampled distance of every mesh of the tools, on ``device``.

    Args:
        tools: only their meshes are sampled.
        device: name in Warp.
        thickness: of the sheet that the tools will meet [m]: samples must reach from one of its faces to the other.

    Raises:
        InputError: a mesh needs too many samples, or its reach is below the thickness.
    """
    samples = {}
    for name, surface in mesh_parts(tools).items():
        sampled = samples[surface] = sampled_distance(surface, device)
        if sampled.reach < thickness:
            raise InputError(
                f"{name}: its mesh is sampled up to a distance of {sampled.reach:.4g} m, but the sheet is "
                f"{thickness:.4g} m thick: give the mesh a reach of at least the thickness"
            )
    return samples


def sampled_distance(surface: MeshSurface, device: str = "cpu") -> SampledDistance:
    """The sampled distance on ``device``; computed on the first call.

    Raises:
        InputError: its spacing or its reach needs too many samples.
    """
    of_surface = _kept.setdefault(surface, {})
    if device not in of_surface:
        of_surface[device] = _sample(surface, device)
    return of_surface[device]


def exact_distance(surface: MeshSurface, points: np.ndarray, device: str = "cpu") -> np.ndarray:
    """Exact signed distance (n,) [m] of ``points`` (n, 3), by searching the triangles."""
    return _query(_warp_mesh(surface, device), _largest(surface), points, device)


@dataclass(frozen=True)
class _Grid:
    """Sample locations: a box, and those of its tiles in which distances are below the reach."""

    lower: np.ndarray  # (3,) [m]
    upper: np.ndarray
    spacing: float  # [m]
    reach: float  # [m]
    first_voxel: np.ndarray  # of each tile, (tile_count, 3)
    centre_distance: np.ndarray  # at the middle of each tile, (tile_count,) [m]
    voxel_count: int  # of all tiles


def _sample(surface: MeshSurface, device: str) -> SampledDistance:
    mesh = _warp_mesh(surface, device)
    grid = _chosen_grid(surface, mesh, device)
    volume = _filled_volume(mesh, grid, device)
    error = np.abs(_errors(surface, mesh, volume, grid, device))
    return SampledDistance(
        volume=volume,
        lower=grid.lower,
        upper=grid.upper,
        spacing=grid.spacing,
        reach=grid.reach,
        voxel_count=grid.voxel_count,
        largest_error=float(error.max()),
        usual_error=float(np.quantile(error, 0.99)),
        mean_error=float(np.sqrt(np.mean(error**2))),
    )


def _warp_mesh(surface: MeshSurface, device: str) -> wp.Mesh:
    return wp.Mesh(
        points=wp.array(surface.solid_vertices, dtype=wp.vec3, device=device),
        indices=wp.array(surface.solid_faces.ravel(), dtype=wp.int32, device=device),
        support_winding_number=True,
    )


def _largest(surface: MeshSurface) -> float:
    """Largest distance that is searched [m]."""
    return 10.0 * float(np.linalg.norm(np.ptp(surface.solid_vertices, axis=0)))


def _query(mesh: wp.Mesh, largest: float, points: np.ndarray, device: str) -> np.ndarray:
    distance = wp.zeros(len(points), dtype=float, device=device)
    inputs = [mesh.id, wp.array(points, dtype=wp.vec3, device=device), largest]
    wp.launch(mesh_distance_kernel, dim=len(points), inputs=inputs, outputs=[distance], device=device)
    return distance.numpy().astype(np.float64)


def _chosen_grid(surface: MeshSurface, mesh: wp.Mesh, device: str) -> _Grid:
    """The preferred grid, or the finest one within the voxel limit."""
    name, spacing = surface.name, surface.first_spacing
    while True:
        grid = _grid(surface, mesh, spacing, device)
        if grid.voxel_count <= (CHOSEN_VOXEL_COUNT if surface.spacing is None else LARGEST_VOXEL_COUNT):
            return grid
        if surface.spacing is not None:
            raise InputError(
                f"{name}: a spacing of {spacing} m needs {grid.voxel_count} samples, above {LARGEST_VOXEL_COUNT}; "
                f"give at least {spacing * (grid.voxel_count / LARGEST_VOXEL_COUNT) ** 0.5:.2g} m, or a smaller reach."
            )
        spacing *= 1.02 * (grid.voxel_count / CHOSEN_VOXEL_COUNT) ** (1.0 / 3.0)
        if surface.reach is not None and spacing > 0.5 * surface.reach:
            raise InputError(
                f"{name}: a reach of {surface.reach} m needs too many samples at a spacing that resolves it; "
                "leave reach out, or give a spacing too."
            )


def _grid(surface: MeshSurface, mesh: wp.Mesh, spacing: float, device: str) -> _Grid:
    """The grid for one spacing; without tiles if even their centres are too many to compute."""
    size = int(TILE_SIZE)
    reach = 6.0 * spacing if surface.reach is None else surface.reach
    lower, upper = surface.vertices.min(axis=0) - reach, surface.vertices.max(axis=0) + reach
    # one voxel beyond the box on every side, so that interpolation within the box never reads the background
    counts = np.floor((upper - lower) / spacing / size).astype(int) + 1
    tile_count = np.prod(counts.astype(float) + 1)
    if tile_count > LARGEST_VOXEL_COUNT / 16:
        return _Grid(lower, upper, spacing, reach, np.empty((0, 3)), np.empty(0), int(tile_count) * size**3)
    index = np.stack(np.meshgrid(*(np.arange(-1, n + 1) for n in counts), indexing="ij"), axis=-1).reshape(-1, 3)
    first = size * index
    centre = lower + spacing * (first + 0.5 * (size - 1))
    centre_distance = _query(mesh, _largest(surface), centre, device)
    near = centre_distance < reach + float(TILE_REACH) * spacing
    voxel_count = int(np.count_nonzero(near)) * size**3
    return _Grid(lower, upper, spacing, reach, first[near], centre_distance[near], voxel_count)


def _filled_volume(mesh: wp.Mesh, grid: _Grid, device: str) -> wp.Volume:
    first_voxel: wp.array = wp.array(grid.first_voxel, dtype=wp.vec3i, device=device)
    volume = wp.Volume.allocate_by_tiles(
        first_voxel,
        voxel_size=grid.spacing,
        bg_value=float(grid.reach),
        translation=tuple(grid.lower),
        device=device,
    )
    centre_distance: wp.array = wp.array(grid.centre_distance, dtype=float, device=device)
    wp.launch(
        fill_tiles_kernel,
        dim=(len(grid.first_voxel), int(TILE_SIZE) ** 3),
        inputs=[mesh.id, first_voxel, centre_distance, wp.vec3(*grid.lower), grid.spacing, grid.reach],
        outputs=[volume.id],
        device=device,
    )
    return volume


def _errors(surface: MeshSurface, mesh: wp.Mesh, volume: wp.Volume, grid: _Grid, device: str) -> np.ndarray:
    """Differences between samples and mesh at random points near its surface [m]."""
    points = _points_near_surface(surface, min(3.0 * grid.spacing, 0.5 * grid.reach))
    value = wp.zeros(len(points), dtype=float, device=device)
    inputs = [volume.id, wp.array(points, dtype=wp.vec3, device=device)]
    wp.launch(volume_distance_kernel, dim=len(points), inputs=inputs, outputs=[value], device=device)
    return value.numpy() - _query(mesh, _largest(surface), points, device)


def _points_near_surface(surface: MeshSurface, offset: float) -> np.ndarray:
    random = np.random.default_rng(0)
    area = triangle_areas(surface.vertices, surface.faces)
    face = surface.faces[random.choice(len(area), size=ERROR_SAMPLE_COUNT, p=area / area.sum())]
    weight = random.dirichlet([1.0, 1.0, 1.0], size=ERROR_SAMPLE_COUNT)
    points = np.einsum("ij,ijk->ik", weight, surface.vertices[face])
    direction = random.normal(size=points.shape)
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    return points + offset * random.random((ERROR_SAMPLE_COUNT, 1)) * direction
