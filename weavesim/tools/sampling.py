"""Samples of the signed distance of triangle meshes in sparse tiles, and their accuracy."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import numpy as np
import warp as wp

from ..errors import InputError
from ..kernels.contact.fill_samples import (
    doubt_cells_kernel,
    fill_tiles_kernel,
    mark_cells_kernel,
    mesh_distance_kernel,
    sampled_distance_kernel,
    share_corners_kernel,
    tell_sides_kernel,
)
from ..kernels.contact.list_nearest import count_nearest_kernel, list_nearest_kernel
from ..kernels.contact.mesh_samples import SampledMesh
from . import solid_triangles
from .mesh_features import points_near
from .mesh_tool import MeshSurface
from .samples import candidates as candidates_module
from .samples import tiles as tiles_module
from .samples.candidates import nearest_candidates
from .samples.grid import HALF_CELL, Grid, chosen_grid, preferred_spacing
from .samples.stored import Inputs, StoredArrays
from .samples.tiles import doubt_above, doubted_cells, filled_values, record_of
from .solid_triangles import SolidTriangles

if TYPE_CHECKING:
    from .tool import Tool

ERROR_SAMPLE_COUNT = 20_000
# Points with the largest errors that are kept.
WORST_COUNT = 2_000
# Where samples err by more than this share of their spacing, or of the thinnest sheet, triangles are searched; and by
# more than the other share of their spacing without a sheet, when time does not matter.
ALLOWED_ERROR = 0.08
ALLOWED_ERROR_ALONE = 0.03
# Error of 99 % of the points near the surface over the thickness of the thinnest sheet: more is doubtful, or refused.
DOUBTFUL_ERROR = 0.1
LARGEST_ERROR = 0.5
# Samples of simplified triangles err by at most this beyond interpolation, in spacings.
SIMPLIFIED_ERROR = 0.03


# All that computes samples and lists: what is kept depends on them.
SAMPLING_KERNELS = (
    mesh_distance_kernel, fill_tiles_kernel, tell_sides_kernel, share_corners_kernel, doubt_cells_kernel,
    mark_cells_kernel, count_nearest_kernel, list_nearest_kernel,
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class SampledDistance:
    """Signed distance of a mesh in sparse tiles of samples, with the error of what the kernels read.

    The kernels search the triangles where the samples are doubted, as at edges and in thin walls.

    Attributes:
        record: a ``kernels.contact.mesh_samples.SampledMesh``, (1,).
        values: the samples, with marks on doubted cells.
        others: further arrays that ``record`` refers to.
        mesh: the triangles.
        centre: of the frame of all these, in the frame of the mesh, (3,) [m].
        spacing: of the samples [m].
        reach: distances are truncated to plus and minus this [m].
        voxel_count: number of values.
        checked: up to this distance the samples of each cell were compared with the triangles [m].
        band: samples within this distance are those of ``mesh`` to 0.002 of the spacing, the others to 0.02 [m].
        tolerance: error of the samples from which on triangles are searched [m].
        largest_error: largest difference to the mesh at random points near its surface [m]:
            within three voxels, or the thickness of the sheet.
        usual_error: 99th percentile at these points [m].
        mean_error: root mean square at these points [m].
        worst_points: those of them with the largest errors, in the frame of the mesh, (k, 3) [m].
        worst_errors: there, from the largest to the smallest, (k,) [m].
    """

    record: wp.array
    values: wp.array
    others: tuple[wp.array, ...]
    mesh: wp.Mesh
    centre: np.ndarray
    spacing: float
    reach: float
    voxel_count: int
    checked: float
    band: float
    tolerance: float
    largest_error: float
    usual_error: float
    mean_error: float
    worst_points: np.ndarray
    worst_errors: np.ndarray

    def dimensions(self) -> dict[str, Any]:
        """Values that the kernels read; see ``ShapeKind`` in ``kernels/contact/tool_shapes.py``."""
        # between right samples: the way to them
        error_between = (1.05 * HALF_CELL + SIMPLIFIED_ERROR) * self.spacing
        return {
            "volume": self.record.ptr,
            "reach": self.reach,
            "checked": self.checked,
            "error": min(2.0 * max(self.tolerance, self.largest_error), error_between),
            "largest_error": error_between,
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


def _sample(
    surface: MeshSurface, device: str, thickness: float, thickest: float, other: SampledDistance | None
) -> SampledDistance:
    """Sample a surface; the ``other`` samples serve again."""
    spacing = preferred_spacing(surface, thickness, ALLOWED_ERROR)
    triangles = SolidTriangles(surface, device, spacing)
    grid = chosen_grid(triangles, spacing, thickest)
    needed = thickness or min(3.5 * grid.spacing, grid.reach)
    # all corners of a cell whose middle may be doubted
    band = max(needed + 2.1 * HALF_CELL * grid.spacing, other.band if other else 0.0)
    same = other is not None and (other.spacing, other.reach, other.band) == (grid.spacing, grid.reach, band)
    tolerance = ALLOWED_ERROR * min(grid.spacing, thickness) if thickness else ALLOWED_ERROR_ALONE * grid.spacing
    searched = _searched(grid, needed)
    tiles: wp.array = wp.array(grid.tiles, dtype=wp.int32, device=device)
    stored = _stored(triangles, grid, (band, tolerance, needed, searched, float(bool(other and same))))
    if (kept := stored.get("values", "doubted")) is not None:
        doubted = kept[1]
        values: wp.array = wp.array(kept[0], dtype=wp.float32, device=device)
        sampled = record_of(grid, tiles, values)
    else:
        values = wp.clone(other.values) if other and same else filled_values(triangles, grid, tiles, band)
        sampled = record_of(grid, tiles, values)
        doubted = doubted_cells(triangles, grid, sampled, values, doubt_above(grid.spacing, tolerance, needed))
        stored.add(values=values, doubted=doubted)
    candidates = nearest_candidates(triangles, grid, doubted, 4.0 * searched, stored)
    stored.keep()
    sampled.nearest, sampled.searched = candidates.record, searched
    record: wp.array = wp.array([sampled], dtype=SampledMesh, device=device)
    offset = min(3.0 * grid.spacing, 0.5 * grid.reach, thickness or math.inf)
    points, error = _errors(triangles, record, offset)
    worst = np.argsort(-error, kind="stable")[:WORST_COUNT]
    return SampledDistance(
        record=record,
        values=values,
        others=(tiles, *candidates.arrays),
        mesh=triangles.mesh,
        centre=surface.centre,
        spacing=grid.spacing,
        reach=grid.reach,
        voxel_count=grid.voxel_count,
        checked=needed,
        band=band,
        tolerance=tolerance,
        largest_error=float(error.max()),
        usual_error=float(np.quantile(error, 0.99)),
        mean_error=float(np.sqrt(np.mean(error**2))),
        worst_points=points[worst],
        worst_errors=error[worst],
    )


def _stored(triangles: SolidTriangles, grid: Grid, limits: tuple[float, ...]) -> StoredArrays:
    """Samples and lists of a mesh that an earlier command has kept: all that takes long."""
    meshes = {mesh.id: mesh for mesh in (triangles.mesh, triangles.near, triangles.far)}.values()

    def inputs() -> Inputs:
        return (
            *(array.numpy() for mesh in meshes for array in (mesh.points, mesh.indices)),
            *(grid.lower, grid.upper, grid.tiles, grid.first_voxel, triangles.surface.centre),
            *(triangles.crossed, triangles.largest, grid.spacing, grid.reach),
            *(triangles.mesh.id == triangles.near.id, triangles.near.id == triangles.far.id),
            *limits,
        )

    files = (__file__, tiles_module.__file__, candidates_module.__file__, solid_triangles.__file__)
    return StoredArrays(SAMPLING_KERNELS, files, inputs, wp.get_device(triangles.device))


def _searched(grid: Grid, needed: float) -> float:
    """Sampled distance up to which triangles are searched [m], for right distances up to the ``needed`` one.

    Between right samples distances are wrong by no more than the way to the corners, half a cell's diagonal. Cells with
    a truncated corner are left as they are.
    """
    return min(needed + 1.05 * HALF_CELL * grid.spacing, max(grid.reach - 2.0 * grid.spacing, 0.0))


def _errors(triangles: SolidTriangles, record: wp.array, offset: float) -> tuple[np.ndarray, np.ndarray]:
    """Random points (n, 3) up to ``offset`` [m] off the surface, and how wrong the kernels read there, (n,) [m]."""
    surface, device = triangles.surface, triangles.device
    points = points_near(surface.vertices, surface.faces, ERROR_SAMPLE_COUNT, offset)
    value = wp.zeros(len(points), dtype=float, device=device)
    inputs = [record, wp.array(points - surface.centre, dtype=wp.vec3, device=device)]
    wp.launch(sampled_distance_kernel, dim=len(points), inputs=inputs, outputs=[value], device=device)
    return points, np.abs(value.numpy() - triangles.distance(points, triangles.mesh, triangles.crossed))
