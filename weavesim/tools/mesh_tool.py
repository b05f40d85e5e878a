"""A tool shape from a triangle mesh: checked, made solid where it is an open sheet, sampled as a signed distance.

A forming tool from CAD is often an open sheet: it has a side that faces the fabric, not an inside. It is made solid by
extruding it away from that side, farther than the sampled box reaches. The distance is then that of a closed body
everywhere: behind the sheet it is negative, and beyond an open border it is positive, on either side of the sheet's
level, because the border has become a wall.
"""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

import numpy as np
import warp as wp

from ..checks import Vector, positive, unit_vector
from ..errors import InputError
from ..kernels.contact import tool_shapes as kinds
from ..kernels.contact.mesh_distance import (
    TILE_REACH,
    TILE_SIZE,
    fill_tiles_kernel,
    mesh_distance_kernel,
    volume_distance_kernel,
)
from .mesh_repair import (
    SEAM,
    WELD,
    check_size,
    checked_triangles,
    directed_border,
    ends_at,
    extruded,
    mirrored_mesh,
    neighbours,
    open_border,
    oriented,
    triangle_areas,
    turned_outwards,
    welded,
)
from .shapes import Shape, Triangles

# Voxels that may be sampled: chosen spacings stay below the first, given ones below the second.
CHOSEN_VOXEL_COUNT = 6_000_000
LARGEST_VOXEL_COUNT = 150_000_000
# Edges sharper than this [rad] are edges, not the facets of a rounding.
SHARP = math.radians(50.0)
ERROR_SAMPLE_COUNT = 20_000


@dataclass(frozen=True)
class SampledDistance:
    """Signed distance of a mesh on the voxels of a volume, with what that costs in accuracy.

    Attributes:
        volume: sparse, float32; its background is ``reach``.
        lower, upper: box within which the volume is read, (3,) [m].
        spacing: of the voxels [m].
        reach: distances are cut to plus and minus this [m].
        voxel_count: number of values.
        largest_error: largest difference to the mesh at random points within three voxels of its surface [m].
        usual_error: that 99 % of these points stay below [m]; the largest errors sit at sharp edges.
        mean_error: root mean square of the same [m].
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


class MeshSurface:
    """A checked triangle mesh and its sampled distance, in the mesh's own frame [m].

    Attributes:
        vertices: (n, 3), faces: (m, 3), as given, cleaned, mirrored, and facing outwards or to ``side``.
        closed: whether the mesh encloses a body. If not, it is a sheet that faces ``side``.
        side: unit direction from the sheet to the fabric, None for a closed mesh.
        solid_vertices, solid_faces: the closed body whose distance is sampled.
        open_edge_count: edges of the border of a sheet.
        cut_planes: "x", "y": planes at which the mesh ends, as a half model does.
        removed_triangle_count: degenerate triangles that were left out.
        smallest_radius: of the convex roundings, estimated from the facets [m]; sharp edges do not count.
        spacing, reach: of the sampling, as given [m]; None leaves the choice to it.
    """

    def __init__(
        self,
        vertices: Any,
        faces: Any,
        *,
        name: str = "mesh",
        side: Any = None,
        mirror: Sequence[str] = (),
        spacing: float | None = None,
        reach: float | None = None,
    ) -> None:
        self.name = name
        vertices, faces = checked_triangles(name, vertices, faces)
        size = float(np.linalg.norm(np.ptp(vertices, axis=0)))
        for plane in mirror:
            vertices, faces = mirrored_mesh(name, vertices, faces, plane, SEAM * size)
        vertices, faces = welded(vertices, faces, WELD * size)
        keep = triangle_areas(vertices, faces) > (WELD * size) ** 2
        if not np.any(keep):
            raise InputError(f"{name}: all {len(faces)} triangles are degenerate; export the tool's mesh again.")
        self.removed_triangle_count = int(np.count_nonzero(~keep))
        self.vertices, faces = vertices, faces[keep]
        self.cut_planes = [plane for plane in "xy" if ends_at(vertices[:, "xy".index(plane)], SEAM * size)]
        border = open_border(self.vertices, faces, SEAM * size)
        self.closed = len(border) == 0
        self.open_edge_count = len(border)
        faces, component = oriented(faces)
        p, q, r = (self.vertices[faces[:, k]] for k in range(3))
        normal = np.cross(q - p, r - p)
        area = np.linalg.norm(normal, axis=1)
        if self.closed:
            self.side: Vector | None = None
            # the volume tells inside from outside
            self.faces = faces if np.einsum("ij,ij->", p, np.cross(q, r)) > 0.0 else faces[:, ::-1]
        else:
            mean = normal.sum(axis=0)
            if side is None and np.linalg.norm(mean) < 0.02 * area.sum():
                raise InputError(
                    f"{name} is an open sheet ({len(border)} open edges) whose triangles face all ways. If it should "
                    "enclose a body, close its holes; if not, give the direction from the sheet to the fabric as side, "
                    "for example (0, 0, 1)."
                )
            self.side = unit_vector(f"{name}: side", mean if side is None else side)
            self.faces = turned_outwards(faces, component, normal @ np.array(self.side), area)
            p, q, r = (self.vertices[self.faces[:, k]] for k in range(3))
            if (np.cross(q - p, r - p) @ np.array(self.side)).sum() < 0.02 * area.sum():
                raise InputError(
                    f"{name} is an open sheet ({len(border)} open edges) that is seen edge-on, or from both sides "
                    f"alike, along side = {self.side}. Give another direction from the sheet to the fabric as side; "
                    "if the mesh should enclose a body, close its holes."
                )
        self.smallest_radius = _smallest_radius(self.vertices, self.faces)
        self.spacing = None if spacing is None else positive(f"{name}: spacing", spacing)
        chosen = float(np.clip(self.smallest_radius / 10.0, size / 1500.0, size / 150.0))
        self._first_spacing = chosen if self.spacing is None else self.spacing
        self.reach = None if reach is None else positive(f"{name}: reach", reach)
        if self.reach is not None and not 4.0 * self._first_spacing <= self.reach <= size:
            raise InputError(
                f"{name}: reach is {self.reach} m; it must be at least four times the spacing, "
                f"{4.0 * self._first_spacing:.4g} m, and at most the size of the mesh, {size:.4g} m."
            )
        if self._first_spacing > 0.1 * size:
            raise InputError(f"{name}: spacing is {spacing} m; it must be at most a tenth of the size, {size:.4g} m.")
        self.solid_vertices, self.solid_faces = vertices, self.faces
        if not self.closed:
            # far enough for the lower end to stay out of the sampled box by more than any reach
            depth = float(np.ptp(vertices @ np.array(self.side))) + 3.0 * size
            self.solid_vertices, self.solid_faces = extruded(
                vertices, self.faces, directed_border(border, self.faces), -depth * np.array(self.side)
            )
        self._sampled: dict[str, SampledDistance] = {}

    def notes(self) -> list[str]:
        """What a log should say about the mesh."""
        lines = [f"{self.name}: {len(self.faces)} triangles, {'closed' if self.closed else 'open sheet'}"]
        if self.removed_triangle_count:
            lines.append(f"{self.name}: {self.removed_triangle_count} degenerate triangles removed")
        if self.side is not None:
            lines.append(f"{self.name}: faces ({', '.join(f'{c:.3g}' for c in self.side)}), solid behind it")
        for plane in self.cut_planes:
            lines.append(f'{self.name}: ends at {plane} = 0; if it was cut there, give mirror=("{plane}",)')
        for sampled in self._sampled.values():
            lines.append(
                f"{self.name}: distance sampled every {sampled.spacing * 1e3:.3g} mm at {sampled.voxel_count} points, "
                f"error near the surface {sampled.mean_error * 1e3:.2g} mm rms, {sampled.usual_error * 1e3:.2g} mm "
                f"for 99 % of all points, {sampled.largest_error * 1e3:.2g} mm at most"
            )
        return lines

    def sampled(self, device: str = "cpu") -> SampledDistance:
        """The sampled distance on ``device``; made at the first call."""
        key = str(device)
        if key not in self._sampled:
            self._sampled[key] = self._sample(key)
        return self._sampled[key]

    def exact_distance(self, points: np.ndarray, device: str = "cpu") -> np.ndarray:
        """Signed distance (n,) [m] of ``points`` (n, 3) by a search through the triangles."""
        return _query(self._warp_mesh(device), self._largest(), points, device)

    def _warp_mesh(self, device: str) -> wp.Mesh:
        return wp.Mesh(
            points=wp.array(self.solid_vertices, dtype=wp.vec3, device=device),
            indices=wp.array(self.solid_faces.ravel(), dtype=wp.int32, device=device),
            support_winding_number=True,
        )

    def _largest(self) -> float:
        return 10.0 * float(np.linalg.norm(np.ptp(self.solid_vertices, axis=0)))

    def _sample(self, device: str) -> SampledDistance:
        mesh = self._warp_mesh(device)
        spacing = self._first_spacing
        while True:
            reach = 6.0 * spacing if self.reach is None else self.reach
            lower, upper = self.vertices.min(axis=0) - reach, self.vertices.max(axis=0) + reach
            tiles, centre_distance, voxel_count = self._tiles(mesh, lower, upper, spacing, reach, device)
            if voxel_count <= (CHOSEN_VOXEL_COUNT if self.spacing is None else LARGEST_VOXEL_COUNT):
                break
            if self.spacing is not None:
                raise InputError(
                    f"{self.name}: a spacing of {spacing} m takes {voxel_count} samples, above {LARGEST_VOXEL_COUNT}; "
                    f"give at least {spacing * (voxel_count / LARGEST_VOXEL_COUNT) ** 0.5:.2g} m, or a smaller reach."
                )
            spacing *= 1.02 * (voxel_count / CHOSEN_VOXEL_COUNT) ** (1.0 / 3.0)
            if self.reach is not None and spacing > 0.5 * self.reach:
                raise InputError(
                    f"{self.name}: a reach of {self.reach} m takes too many samples at a spacing that resolves it; "
                    "leave reach out, or give a spacing too."
                )
        volume = wp.Volume.allocate_by_tiles(
            wp.array(tiles, dtype=wp.vec3i, device=device),
            voxel_size=spacing,
            bg_value=float(reach),
            translation=tuple(lower),
            device=device,
        )
        wp.launch(
            fill_tiles_kernel,
            dim=(len(tiles), int(TILE_SIZE) ** 3),
            inputs=[
                mesh.id,
                wp.array(tiles, dtype=wp.vec3i, device=device),
                wp.array(centre_distance, dtype=float, device=device),
                wp.vec3(*lower),
                spacing,
                reach,
            ],
            outputs=[volume.id],
            device=device,
        )
        points = self._points_near_surface(min(3.0 * spacing, 0.5 * reach))
        value = wp.zeros(len(points), dtype=float, device=device)
        inputs = [volume.id, wp.array(points, dtype=wp.vec3, device=device)]
        wp.launch(volume_distance_kernel, dim=len(points), inputs=inputs, outputs=[value], device=device)
        error = value.numpy() - _query(mesh, self._largest(), points, device)
        return SampledDistance(
            volume=volume,
            lower=lower,
            upper=upper,
            spacing=spacing,
            reach=reach,
            voxel_count=len(tiles) * int(TILE_SIZE) ** 3,
            largest_error=float(np.abs(error).max()),
            usual_error=float(np.quantile(np.abs(error), 0.99)),
            mean_error=float(np.sqrt(np.mean(error**2))),
        )

    def _tiles(
        self, mesh: wp.Mesh, lower: np.ndarray, upper: np.ndarray, spacing: float, reach: float, device: str
    ) -> tuple[np.ndarray, np.ndarray, int]:
        """Tiles with distances below the reach: first voxel of each, distance at its centre, number of all voxels."""
        size = int(TILE_SIZE)
        # one voxel beyond the box on every side, so that interpolation within the box never reads the background inside
        counts = np.floor((upper - lower) / spacing / size).astype(int) + 1
        if np.prod(counts.astype(float) + 1) > LARGEST_VOXEL_COUNT / 16:
            return np.empty((0, 3)), np.empty(0), int(np.prod(counts.astype(float) + 1)) * size**3
        index = np.stack(np.meshgrid(*(np.arange(-1, n + 1) for n in counts), indexing="ij"), axis=-1).reshape(-1, 3)
        first = size * index
        centre_distance = _query(mesh, self._largest(), lower + spacing * (first + 0.5 * (size - 1)), device)
        near = centre_distance < reach + float(TILE_REACH) * spacing
        return first[near], centre_distance[near], int(np.count_nonzero(near)) * size**3

    def _points_near_surface(self, offset: float) -> np.ndarray:
        random = np.random.default_rng(0)
        area = triangle_areas(self.vertices, self.faces)
        face = self.faces[random.choice(len(area), size=ERROR_SAMPLE_COUNT, p=area / area.sum())]
        weight = random.dirichlet([1.0, 1.0, 1.0], size=ERROR_SAMPLE_COUNT)
        points = np.einsum("ij,ijk->ik", weight, self.vertices[face])
        direction = random.normal(size=points.shape)
        direction /= np.linalg.norm(direction, axis=1, keepdims=True)
        return points + offset * random.random((ERROR_SAMPLE_COUNT, 1)) * direction


@dataclass(frozen=True, eq=False)
class MeshShape(Shape):
    """A shape bounded by a triangle mesh.

    Attributes:
        surface: the checked mesh, in the shape's own frame.
    """

    surface: MeshSurface = field(repr=False)

    @classmethod
    def from_file(cls, path: str | os.PathLike[str], *, unit_scale: float = 1.0, **options: Any) -> Self:
        """Read STL, OBJ, PLY or any other format that trimesh reads.

        Args:
            path: of the file.
            unit_scale: metres per unit of the file: 1 for metres, 0.001 for millimetres.
            **options: those of ``from_triangles``.

        Raises:
            InputError: the file cannot be read, or the mesh cannot be used.
        """
        unit_scale = positive("unit_scale", unit_scale)
        path = Path(path)
        if not path.is_file():
            raise InputError(f"tool mesh {path} does not exist; give the path of an STL, OBJ or PLY file.")
        import trimesh

        try:
            mesh = trimesh.load_mesh(path, process=False)
            vertices, faces = np.asarray(mesh.vertices, dtype=np.float64), np.asarray(mesh.faces)
        except Exception as error:  # every format's reader raises exceptions of its own
            raise InputError(
                f"tool mesh {path} cannot be read ({type(error).__name__}: {error}); "
                "give a triangle mesh, for example in STL, OBJ or PLY."
            ) from error
        check_size(f"tool mesh {path}", vertices, unit_scale)
        return cls.from_triangles(unit_scale * vertices, faces, name=f"tool mesh {path}", **options)

    @classmethod
    def from_triangles(
        cls,
        vertices: Any,
        faces: Any,
        *,
        name: str = "tool mesh",
        side: Any = None,
        mirror: Sequence[str] = (),
        spacing: float | None = None,
        reach: float | None = None,
        origin: Any = (0.0, 0.0, 0.0),
        rotation: Any = None,
    ) -> Self:
        """A shape from vertices (n, 3) [m] and triangles (m, 3).

        Args:
            vertices: [m].
            faces: three vertex indices each.
            name: for messages.
            side: of an open sheet, the direction from it to the fabric, in the mesh's frame. By default the mean of
                its triangles' normals. A closed mesh needs none.
            mirror: "x" or "y" or both, for a mesh that was cut at x = 0 or y = 0: the other half is added. Without it
                the cut is a wall of the tool.
            spacing: of the samples of the distance [m]; by default a tenth of the smallest rounding, if the number of
                samples allows.
            reach: distances are sampled up to it [m], at least four and by default six times the spacing. A node that
                gets deeper than this is no longer pushed out.
            origin: where the mesh's origin lies [m].
            rotation: 3 x 3, columns: the mesh's axes in the world.

        Raises:
            InputError: no triangles, vertices that are not finite, or a size that no tool has.
        """
        surface = MeshSurface(vertices, faces, name=name, side=side, mirror=mirror, spacing=spacing, reach=reach)
        frame = {} if rotation is None else {"rotation": rotation}
        return cls(surface=surface, origin=origin, **frame)

    @property
    def smallest_radius(self) -> float:
        return self.surface.smallest_radius

    @property
    def distance_error(self) -> float:
        """Largest measured error of the sampled distance near the surface [m]."""
        sampled = self.surface._sampled or {"cpu": self.surface.sampled("cpu")}
        return max(entry.largest_error for entry in sampled.values())

    def _fill_dimensions(self, part: Any, device: Any) -> None:
        sampled = self.surface.sampled(str(device))
        part.kind = int(kinds.VOLUME)
        part.volume = sampled.volume.id
        part.lower = tuple(sampled.lower)
        part.upper = tuple(sampled.upper)
        part.reach = sampled.reach

    def _local_display_triangles(self) -> Triangles:
        return self.surface.vertices, self.surface.faces


def _query(mesh: wp.Mesh, largest: float, points: np.ndarray, device: str) -> np.ndarray:
    distance = wp.zeros(len(points), dtype=float, device=device)
    inputs = [mesh.id, wp.array(points, dtype=wp.vec3, device=device), largest]
    wp.launch(mesh_distance_kernel, dim=len(points), inputs=inputs, outputs=[distance], device=device)
    return distance.numpy().astype(np.float64)


# --- checks and repairs -----------------------------------------------------------------------------------------------


def _smallest_radius(vertices: np.ndarray, faces: np.ndarray) -> float:
    """Radius that a twentieth of the convex, rounded area undercuts [m]; infinite where nothing is rounded.

    Per face the second fundamental form that fits best the turn of the vertex normals along its three edges.
    """
    corners = vertices[faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = 0.5 * np.linalg.norm(normal, axis=1)
    normal /= 2.0 * area[:, None]
    pairs = neighbours(faces) // 3
    sharp = np.einsum("ij,ij->i", normal[pairs[:, 0]], normal[pairs[:, 1]]) < math.cos(SHARP)
    # a vertex at a sharp edge has no normal: its faces do not count
    rounded_vertex = np.ones(len(vertices), dtype=bool)
    rounded_vertex[faces[np.unique(pairs[sharp])].ravel()] = False
    vertex_normal = np.zeros_like(vertices)
    for k in range(3):
        u, v = corners[:, (k + 1) % 3] - corners[:, k], corners[:, (k + 2) % 3] - corners[:, k]
        angle = np.arctan2(np.linalg.norm(np.cross(u, v), axis=1), np.einsum("ij,ij->i", u, v))
        np.add.at(vertex_normal, faces[:, k], angle[:, None] * normal)
    vertex_normal /= np.maximum(np.linalg.norm(vertex_normal, axis=1, keepdims=True), 1e-30)
    axis = corners[:, 1] - corners[:, 0]
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    other = np.cross(normal, axis)
    rows, right = [], []
    for k in range(3):
        edge = corners[:, (k + 1) % 3] - corners[:, k]
        turn = vertex_normal[faces[:, (k + 1) % 3]] - vertex_normal[faces[:, k]]
        s, t = np.einsum("ij,ij->i", edge, axis), np.einsum("ij,ij->i", edge, other)
        zero = np.zeros_like(s)
        rows += [np.stack([s, t, zero], axis=-1), np.stack([zero, s, t], axis=-1)]
        right += [np.einsum("ij,ij->i", turn, axis), np.einsum("ij,ij->i", turn, other)]
    matrix, turned = np.stack(rows, axis=1), np.stack(right, axis=1)
    usable = np.all(rounded_vertex[faces], axis=1) & (area > 1e-6 * area.max())
    if not np.any(usable):
        return math.inf
    xx, xy, yy = np.einsum("ijk,ik->ij", np.linalg.pinv(matrix[usable]), turned[usable]).T
    curvature = 0.5 * (xx + yy) + np.hypot(0.5 * (xx - yy), xy)
    size = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    convex = curvature > 0.5 / size
    if not np.any(convex):
        return math.inf
    radius, weight = 1.0 / curvature[convex], area[usable][convex]
    order = np.argsort(radius)
    share = np.cumsum(weight[order]) / weight.sum()
    return float(radius[order][np.searchsorted(share, 0.05)])
