"""Samples of the signed distance of triangle meshes on sparse volumes, and their accuracy."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import numpy as np
import warp as wp

from ..errors import InputError
from ..kernels.contact.mesh_distance import (
    BLOCK_SIZE,
    TILE_REACH,
    TILE_SIZE,
    SampledMesh,
    doubt_cells_kernel,
    fill_tiles_kernel,
    sampled_distance_kernel,
)
from .mesh_features import points_near
from .mesh_tool import MeshSurface
from .solid_triangles import SolidTriangles

if TYPE_CHECKING:
    from .tool import Tool

# Largest number of voxels: the first for an automatic spacing, the second for a given one.
CHOSEN_VOXEL_COUNT = 6_000_000
LARGEST_VOXEL_COUNT = 150_000_000
ERROR_SAMPLE_COUNT = 20_000
# Where samples err by more than this share of their spacing, or of the thinnest sheet, triangles are searched; and by
# more than the other share of their spacing without a sheet, when time does not matter.
ALLOWED_ERROR = 0.08
ALLOWED_ERROR_ALONE = 0.03
# Error of 99 % of the points near the surface over the thickness of the thinnest sheet: more is doubtful, or refused.
DOUBTFUL_ERROR = 0.1
LARGEST_ERROR = 0.5
# Half the diagonal of a cell, in spacings.
HALF_CELL = 0.5 * math.sqrt(3.0)
# Places of the eight cubes in one of twice their edge.
HALVES = np.array(list(product(range(2), repeat=3)))


@dataclass(frozen=True, eq=False)
class SampledDistance:
    """Signed distance of a mesh on the voxels of a volume, with the error of what the kernels read.

    The kernels search the triangles where the samples are doubted, as at edges and in thin walls.

    Attributes:
        record: a ``kernels.contact.mesh_distance.SampledMesh``, (1,).
        volume: sparse, float32; its background is ``reach``.
        doubted: sparse, int32: 1 in each cell whose triangles are searched.
        mesh: the triangles.
        centre: of the frame of all these, in the frame of the mesh, (3,) [m].
        lower, upper: box within which the volume is read, about ``centre``, (3,) [m].
        spacing: of the voxels [m].
        reach: distances are truncated to plus and minus this [m].
        voxel_count: number of values.
        band: samples within this distance are those of ``mesh`` to 0.002 of the spacing, the others to 0.02 [m].
        tolerance: error of the samples from which on triangles are searched [m].
        largest_error: largest difference to the mesh at random points near its surface [m]:
            within three voxels, or the thickness of the sheet.
        usual_error: 99th percentile at these points [m].
        mean_error: root mean square at these points [m].
    """

    record: wp.array
    volume: wp.Volume
    doubted: wp.Volume
    mesh: wp.Mesh
    centre: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    spacing: float
    reach: float
    voxel_count: int
    band: float
    tolerance: float
    largest_error: float
    usual_error: float
    mean_error: float

    def dimensions(self) -> dict[str, Any]:
        """Values that the kernels read; see ``ShapeKind`` in ``kernels/contact/tool_shapes.py``."""
        return {
            "volume": self.record.ptr,
            "lower": tuple(self.lower),
            "upper": tuple(self.upper),
            "reach": self.reach,
        }

    def note(self, name: str) -> str:
        """Note about the sampling for the log."""
        return (
            f"{name}: distance sampled every {self.spacing * 1e3:.3g} mm at {self.voxel_count} points, and from the "
            f"triangles where samples err by more than {self.tolerance * 1e3:.2g} mm; "
            f"error near the surface {self.mean_error * 1e3:.2g} mm rms, {self.usual_error * 1e3:.2g} mm "
            f"for 99 % of all points, {self.largest_error * 1e3:.2g} mm at most"
        )


Samples = Mapping[MeshSurface, SampledDistance]

# The samples of each surface by device and thicknesses, kept as long as the surface exists.
_kept: WeakKeyDictionary[MeshSurface, dict[tuple[str, float, float], SampledDistance]] = WeakKeyDictionary()


def mesh_parts(tools: Iterable[Tool]) -> dict[str, MeshSurface]:
    """Triangle meshes among the tools and their parts, by name."""
    return {
        f"{tool.name} {index}": part.surface
        for tool in tools
        for index, part in enumerate(tool.shape.parts())
        if part.surface is not None
    }


def sample_meshes(tools: Iterable[Tool], device: str, thickness: float = 0.0, thinnest: float | None = None) -> Samples:
    """The sampled distance of every mesh of the tools, on ``device``.

    Args:
        tools: only their meshes are sampled.
        device: name in Warp.
        thickness: of the sheet that the tools will meet [m]: samples must reach from one of its faces to the other.
        thinnest: of the sheets [m], the measure of the error; the same by default.

    Raises:
        InputError: a mesh needs too many samples, its reach is below the thickness, or its error is too large for it.
    """
    samples = {}
    thinnest = thickness if thinnest is None else thinnest
    for name, surface in mesh_parts(tools).items():
        sampled = samples[surface] = sampled_distance(surface, device, thinnest, thickness)
        if sampled.reach < thickness:
            raise InputError(
                f"{name}: its mesh is sampled up to a distance of {sampled.reach:.4g} m, but the sheet is "
                f"{thickness:.4g} m thick: give the mesh a reach of at least the thickness"
            )
        if thinnest and sampled.usual_error > LARGEST_ERROR * thinnest:
            raise InputError(f"{name}: {error_in_words(sampled, thinnest)}: {ERROR_ADVICE}")
    return samples


ERROR_ADVICE = "contact with it would be wrong by as much; give the mesh a smaller spacing, or clean it"


def error_in_words(sampled: SampledDistance, thickness: float) -> str:
    """The error of a sampled distance beside the thickness of a sheet [m]."""
    return (
        f"its distance errs by {sampled.usual_error * 1e3:.2g} mm near the surface (samples every "
        f"{sampled.spacing * 1e3:.3g} mm), {100 * sampled.usual_error / thickness:.3g} % of the sheet's thickness of "
        f"{thickness * 1e3:.3g} mm"
    )


def sampled_distance(
    surface: MeshSurface, device: str = "cpu", thickness: float = 0.0, thickest: float = 0.0
) -> SampledDistance:
    """The sampled distance on ``device``; computed on the first call.

    Args:
        surface: a mesh.
        device: name in Warp.
        thickness: of the thinnest sheet that will meet it [m], zero if none: its share limits the error.
        thickest: of the thickest sheet [m]: an automatic reach is not below it.

    Raises:
        InputError: its spacing or its reach needs too many samples.
    """
    of_surface = _kept.setdefault(surface, {})
    key = device, thickness, thickest
    if key not in of_surface:
        other = next((kept for (where, *_), kept in of_surface.items() if where == device), None)
        of_surface[key] = _sample(surface, device, thickness, thickest, other)
    return of_surface[key]


def exact_distance(surface: MeshSurface, points: np.ndarray, device: str = "cpu") -> np.ndarray:
    """Exact signed distance (n,) [m] of ``points`` (n, 3), by searching the triangles."""
    triangles = SolidTriangles(surface, device)
    return triangles.distance(points, triangles.mesh, triangles.crossed)


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


def _sample(
    surface: MeshSurface, device: str, thickness: float, thickest: float, other: SampledDistance | None
) -> SampledDistance:
    """Sample a surface; the volume of ``other`` samples serves again."""
    spacing = _preferred_spacing(surface, thickness)
    triangles = SolidTriangles(surface, device, spacing)
    grid = _chosen_grid(triangles, spacing, thickest)
    needed = thickness or min(3.5 * grid.spacing, grid.reach)
    # all corners of a cell whose middle may be doubted
    band = max(needed + 2.1 * HALF_CELL * grid.spacing, other.band if other else 0.0)
    same = other is not None and (other.spacing, other.reach, other.band) == (grid.spacing, grid.reach, band)
    volume = other.volume if other and same else _filled_volume(triangles, grid, band)
    tolerance = ALLOWED_ERROR * min(grid.spacing, thickness) if thickness else ALLOWED_ERROR_ALONE * grid.spacing
    doubted = _doubted_cells(triangles, volume, grid, tolerance, needed)
    record = SampledMesh()
    record.volume, record.doubted, record.mesh = volume.id, doubted.id, triangles.mesh.id
    record.crossed, record.searched = triangles.crossed, _searched(grid, needed)
    record = wp.array([record], dtype=SampledMesh, device=device)
    offset = min(3.0 * grid.spacing, 0.5 * grid.reach, thickness or math.inf)
    error = np.abs(_errors(triangles, record, offset))
    return SampledDistance(
        record=record,
        volume=volume,
        doubted=doubted,
        mesh=triangles.mesh,
        centre=surface.centre,
        lower=grid.lower,
        upper=grid.upper,
        spacing=grid.spacing,
        reach=grid.reach,
        voxel_count=grid.voxel_count,
        band=band,
        tolerance=tolerance,
        largest_error=float(error.max()),
        usual_error=float(np.quantile(error, 0.99)),
        mean_error=float(np.sqrt(np.mean(error**2))),
    )


def _searched(grid: _Grid, needed: float) -> float:
    """Sampled distance up to which triangles are searched [m], for right distances up to the ``needed`` one.

    Between right samples distances are wrong by no more than the way to the corners, half a cell's diagonal. Cells with
    a truncated corner are left as they are.
    """
    return min(needed + 1.05 * HALF_CELL * grid.spacing, max(grid.reach - 2.0 * grid.spacing, 0.0))


def _doubted_cells(
    triangles: SolidTriangles, volume: wp.Volume, grid: _Grid, tolerance: float, needed: float
) -> wp.Volume:
    """Cells whose samples err by more than ``tolerance`` [m], and whose distances may be below the ``needed`` one [m].

    A crease that turns the gradient by twice an angle makes samples err by h/2 sin(angle) in the middle of a cell of
    size h, where the gradient has the length cos(angle).
    """
    device, searched = triangles.device, _searched(grid, needed)
    near = np.abs(grid.centre_distance) < searched + 2.0 * float(TILE_REACH) * grid.spacing
    first_voxel: wp.array = wp.array(grid.first_voxel[near], dtype=wp.vec3i, device=device)
    doubted = wp.Volume.allocate_by_tiles(first_voxel, voxel_size=grid.spacing, bg_value=0, device=device)
    least = math.sqrt(1.0 - min(2.0 * tolerance / grid.spacing, 1.0) ** 2)
    gradient_range = wp.vec2(grid.spacing * least, grid.spacing * (2.0 - least))
    inputs = [triangles.near.id, triangles.crossed, volume.id, first_voxel, tolerance, gradient_range]
    limits = wp.vec2(needed + 2.05 * HALF_CELL * grid.spacing, needed + HALF_CELL * grid.spacing)
    wp.launch(
        doubt_cells_kernel,
        dim=(len(first_voxel), int(TILE_SIZE) ** 3),
        inputs=[*inputs, limits],
        outputs=[doubted.id],
        device=device,
    )
    return doubted


def _preferred_spacing(surface: MeshSurface, thickness: float) -> float:
    spacing = surface.first_spacing
    if surface.spacing is None and surface.reach is None and thickness and math.isfinite(surface.fillet_radius):
        # samples of a curvature 1/r err by h^2 / 4 r: fine enough that fillets need no search
        spacing = min(spacing, math.sqrt(4.0 * surface.fillet_radius * ALLOWED_ERROR * thickness))
    return spacing


def _chosen_grid(triangles: SolidTriangles, spacing: float, thickest: float) -> _Grid:
    """The preferred grid, or the finest one within the voxel limit."""
    surface, name = triangles.surface, triangles.surface.name
    while True:
        grid = _grid(triangles, spacing, thickest)
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


def _grid(triangles: SolidTriangles, spacing: float, thickest: float) -> _Grid:
    """The grid for one spacing; without tiles if those near the surface are too many to compute.

    Large blocks of tiles are halved again and again where they come near the surface or lie inside.
    """
    surface, size = triangles.surface, int(TILE_SIZE)
    reach = 6.0 * spacing if surface.reach is None else surface.reach
    if surface.reach is None and reach < thickest:  # a small tool
        reach = thickest + 3.0 * spacing
    vertices = surface.vertices - surface.centre
    lower, upper = vertices.min(axis=0) - reach, vertices.max(axis=0) + reach
    # one voxel beyond the box on every side, so that interpolation within the box never reads the background
    counts = np.floor((upper - lower) / spacing / size).astype(int) + 2
    level = max(0, math.ceil(math.log2(max(counts.max() / 16, 1))))
    index = np.stack(np.meshgrid(*(np.arange(-(-n // 2**level)) for n in counts), indexing="ij"), axis=-1)
    index = index.reshape(-1, 3)
    while True:
        width = size * 2**level
        # as the distance from a tile's middle to its farthest voxel, rounded up
        spread = float(TILE_REACH) + 0.5 * math.sqrt(3.0) * (width - size)
        first = width * index - size
        centre = surface.centre + lower + spacing * (first + 0.5 * (width - 1))
        distance = triangles.distance(centre, triangles.far, triangles.crossed)
        near = distance < reach + spread * spacing
        index = index[near]
        if level == 0 or len(index) * size**3 > LARGEST_VOXEL_COUNT:
            break
        level -= 1
        index = (2 * index[:, None] + HALVES).reshape(-1, 3)
        index = index[np.all(index < counts, axis=1)]
    if level:
        return _Grid(lower, upper, spacing, reach, np.empty((0, 3)), np.empty(0), len(index) * (size * 2**level) ** 3)
    return _Grid(lower, upper, spacing, reach, first[near], distance[near], len(index) * size**3)


def _filled_volume(triangles: SolidTriangles, grid: _Grid, band: float) -> wp.Volume:
    device = triangles.device
    first_voxel: wp.array = wp.array(grid.first_voxel, dtype=wp.vec3i, device=device)
    volume = wp.Volume.allocate_by_tiles(
        first_voxel,
        voxel_size=grid.spacing,
        bg_value=float(grid.reach),
        translation=tuple(grid.lower),
        device=device,
    )
    middle = grid.first_voxel[:, None] + int(BLOCK_SIZE) * (HALVES + 0.5) - 0.5
    points = triangles.surface.centre + grid.lower + grid.spacing * middle.reshape(-1, 3)
    distance = triangles.distance(points, triangles.far, triangles.crossed)
    centre_distance: wp.array = wp.array(distance.reshape(-1, 8), dtype=float, device=device)
    inputs = [triangles.sampled(band), first_voxel, centre_distance, wp.vec3(*grid.lower)]
    wp.launch(
        fill_tiles_kernel,
        dim=(len(grid.first_voxel), int(TILE_SIZE) ** 3),
        inputs=[*inputs, grid.spacing, grid.reach],
        outputs=[volume.id],
        device=device,
    )
    return volume


def _errors(triangles: SolidTriangles, record: wp.array, offset: float) -> np.ndarray:
    """Differences between what the kernels read and the mesh at random points up to ``offset`` off its surface [m]."""
    surface, device = triangles.surface, triangles.device
    points = points_near(surface.vertices, surface.faces, ERROR_SAMPLE_COUNT, offset)
    value = wp.zeros(len(points), dtype=float, device=device)
    inputs = [record, wp.array(points - surface.centre, dtype=wp.vec3, device=device)]
    wp.launch(sampled_distance_kernel, dim=len(points), inputs=inputs, outputs=[value], device=device)
    return value.numpy() - triangles.distance(points, triangles.mesh, triangles.crossed)
