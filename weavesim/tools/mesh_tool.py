"""A tool shape from a triangle mesh: checked, and made solid if it is an open sheet.

A forming tool from CAD is often an open sheet: it has a side that faces the fabric, but no interior. It is made solid
by extruding it away from that side, beyond the sampled box. The distance is then that of a closed body everywhere:
negative behind the sheet, and positive beyond an open border, both above and below the sheet, because the border has
become a wall. ``sampling.py`` samples it for the kernels.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Sequence
from functools import cached_property
from typing import Annotated, Any, Self

import numpy as np
from pydantic import Field, model_validator

from ..arrays import FloatArray, IntArray
from ..checks import Parameters
from ..errors import InputError
from ..meshes import read_mesh
from ..quantities import FiniteVector, Vector, positive, unit_vector
from ..ranges import Quantity, argument
from .mesh_bodies import Parts, far_flecks, parts_of, united
from .mesh_duplicates import separated
from .mesh_features import Facets, face_normals, fillet_radius, sharp_edges, smallest_width
from .mesh_repair import (
    SEAM,
    WELD,
    check_size,
    checked_triangles,
    diagonal,
    directed_border,
    ends_at,
    extent,
    extruded,
    mirrored_mesh,
    triangle_areas,
    turned_outwards,
    welded,
    without_unused,
)
from .mesh_topology import border_in_words, place
from .shapes import Shape, Triangles

logger = logging.getLogger(__name__)

# An open sheet of less than this share of the area beside closed bodies is no part of the tool, but a leftover.
LEAST_SHEET = 0.01
# A sheet of which more than this share, seen along its side, faces away from it is a body with a hole.
LARGEST_REVERSE = 0.1
# From this number of triangles on, work that takes seconds is announced.
MANY_TRIANGLES = 300_000
ANNOUNCED = {"announced": True}


class MeshSurface:
    """A checked triangle mesh, in the mesh's own frame [m].

    Attributes:
        vertices: (n, 3), faces: (m, 3): cleaned, mirrored, and oriented outwards or towards ``side``.
        closed: whether all of the mesh encloses bodies. If not, the rest is a sheet that faces ``side``.
        side: unit direction from the sheet to the fabric, None for a closed mesh.
        centre: origin of the samples, (3,) [m]; zero unless the mesh lies far from its origin.
        solid_vertices, solid_faces: the closed bodies whose distance is sampled.
        open_edge_count: border edges of a sheet; border: they, (k, 2).
        turned: corners of the triangles that were given the other way round, and are turned, (k, 3, 3) [m].
        cut_planes: "x", "y": planes at which the mesh ends, like a half model.
        parts: faces (k, 3) of each closed body with its cavities, and of the sheet; together ``faces``.
        warnings: what is probably wrong, in sentences.
        removed_triangle_count: degenerate triangles that were removed.
        fillet_radius: smallest of the convex fillets, estimated from the facets [m]; sharp edges are ignored.
        sharp_edges: convex ones, pairs of vertices (k, 2); sharp_edge_normals: of their two faces, (k, 2, 3).
        spacing, reach: of the samples, as given [m]; None leaves the choice to ``sampling.py``.
        first_spacing: preferred spacing of the samples, used unless it needs too many [m].
        source_notes: what was converted or left out when the mesh was read, for the log.
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
        source_notes: Sequence[str] = (),
    ) -> None:
        self.name = name
        self.source_notes = tuple(source_notes)
        vertices, faces = checked_triangles(name, vertices, faces)
        if len(faces) > MANY_TRIANGLES:
            logger.info("%s: checking %s triangles", name, f"{len(faces):,}", extra=ANNOUNCED)
        size = extent(vertices, faces)
        for plane in mirror:
            vertices, faces = mirrored_mesh(name, vertices, faces, plane, SEAM * size)
        vertices, faces = welded(vertices, faces, max(WELD * size, 5e-7 * float(np.ptp(vertices, axis=0).max())))
        keep = triangle_areas(vertices, faces) > (WELD * size) ** 2
        if not np.any(keep):
            raise InputError(f"{name}: all {len(faces)} triangles are degenerate; export the tool's mesh again.")
        self.removed_triangle_count = int(np.count_nonzero(~keep))
        vertices, (faces,) = without_unused(vertices, [faces[keep]])
        self.cut_planes = [plane for plane in "xy" if ends_at(vertices[:, "xy".index(plane)], SEAM * size)]
        vertices, faces, self._repairs = separated(name, vertices, faces)
        parts = parts_of(name, vertices, faces, SEAM * size)
        self._repairs += parts.notes
        self._make_solid(vertices, parts, side)
        # far from the origin single precision would be coarse
        middle = 0.5 * (self.vertices.min(axis=0) + self.vertices.max(axis=0))
        self.centre = middle if np.linalg.norm(middle) > diagonal(self.vertices) else np.zeros(3)
        facets = Facets.of(self.vertices, self.faces)
        self.fillet_radius = fillet_radius(self.vertices, self.faces, facets)
        self.sharp_edges, self.sharp_edge_normals = sharp_edges(self.vertices, self.faces, facets)
        several = len(self.parts) > 1
        size = max(diagonal(self.vertices[part]) for part in self.parts) if several else diagonal(self.vertices)
        self._choose_samples(spacing, reach, size)

    def _make_solid(self, vertices: np.ndarray, parts: Parts, side: Any) -> None:
        """Unite the bodies, and make the open sheet a solid behind its side."""
        self.closed = len(parts.sheet) == 0
        self.open_edge_count = len(parts.border)
        self.side: Vector | None = None
        turned = parts.turned
        vertices, shown = self._united(vertices, parts.bodies)
        border = parts.border
        if not self.closed:
            self.side, sheet = self._facing_side(vertices, parts, side)
            shown, border = [*shown, sheet], directed_border(border, sheet)
            turned = np.concatenate([turned, sheet[sheet[:, 0] != parts.given[:, 0]]])
        self.turned = vertices[turned]
        self._tell_turned(sum(map(len, parts.bodies)) + len(parts.sheet))
        self.vertices, (*self.parts, border) = without_unused(vertices, [*shown, border])
        self.border = border
        self.faces = np.concatenate(self.parts)
        self.warnings = far_flecks(self.name, self.vertices, self.parts)
        self.solid_vertices, self.solid_faces = self.vertices, self.faces
        if self.side is not None:
            # far enough that the lower end is outside the sampled box by more than any reach
            depth = float(np.ptp(self.vertices @ np.array(self.side))) + 3.0 * diagonal(self.vertices)
            solid_vertices, column = extruded(self.vertices, self.parts[-1], border, -depth * np.array(self.side))
            solid_vertices, solids = self._united(solid_vertices, [*self.parts[:-1], column])
            self.solid_vertices, (self.solid_faces,) = without_unused(solid_vertices, [np.concatenate(solids)])

    def _tell_turned(self, count: int) -> None:
        """Note the triangles that were turned, of ``count`` in all."""
        number = len(self.turned)
        if number == count:
            self._repairs.append(f"{self.name}: all triangles faced away from the side of the sheet: turned")
        elif number:
            self._repairs.append(
                f"{self.name}: {number} of {count} triangles faced the other way, one about "
                f"{place(self.turned[0].mean(axis=0))}: turned"
            )

    def _united(self, vertices: np.ndarray, solids: list[np.ndarray]) -> tuple[np.ndarray, list[np.ndarray]]:
        if len(solids) < 2:
            return vertices, solids
        vertices, result, joined, failed = united(vertices, solids)
        if joined > failed:
            self._repairs.append(f"{self.name}: {joined - failed} of {len(solids)} solids meet and are united")
        if failed:
            self._repairs.append(
                f"{self.name}: {failed} solids meet, but could not be united: inside them distances are bounds"
            )
        return vertices, result

    def _facing_side(self, vertices: np.ndarray, parts: Parts, side: Any) -> tuple[Vector, np.ndarray]:
        """Direction from an open sheet to the fabric, and its faces oriented towards it."""
        normal, area = face_normals(vertices, parts.sheet)
        total, mean = float(area.sum()), area @ normal
        border = border_in_words(vertices, parts.border)
        what = f"{self.name} is an open sheet ({border})"
        if parts.bodies:
            body_area = sum(float(face_normals(vertices, body)[1].sum()) for body in parts.bodies)
            what = f"{self.name} has closed bodies and an open sheet ({border})"
            if total < LEAST_SHEET * (total + body_area):
                raise InputError(
                    f"{what} with {100 * total / (total + body_area):.2g} % of the area, probably a leftover: remove "
                    "its triangles, or close its holes."
                )
            self._repairs.append(what)
        if side is None and np.linalg.norm(mean) < 0.02 * total:
            raise InputError(
                f"{what} whose triangles face in all directions. If it should enclose a body, close its holes; if not, "
                "give the direction from the sheet to the fabric as side, for example (0, 0, 1)."
            )
        direction = unit_vector(f"{self.name}: side", mean if side is None else side)
        faces = turned_outwards(parts.sheet, parts.patch, area * (normal @ np.array(direction)), area)
        normal = np.where((faces[:, 0] != parts.sheet[:, 0])[:, None], -normal, normal)
        facing = area * (normal @ np.array(direction))
        if facing.sum() < 0.02 * total:
            raise InputError(
                f"{what} that is edge-on, or faces both sides equally, along side = {direction}. Give another "
                "direction from the sheet to the fabric as side; if the mesh should enclose a body, close its holes."
            )
        reverse = -float(facing[facing < 0.0].sum() / facing[facing > 0.0].sum())
        if reverse > LARGEST_REVERSE:
            raise InputError(
                f"{what}, but part of it faces away from side = {direction}: {100 * reverse:.3g} % as "
                "much as faces it, so that it is no sheet with the fabric on one side. If the mesh should enclose a "
                "body, close its holes; if not, remove what does not face the fabric."
            )
        return direction, faces

    def _choose_samples(self, spacing: float | None, reach: float | None, size: float) -> None:
        name = self.name
        self.spacing = None if spacing is None else positive(f"{name}: spacing", spacing)
        chosen = float(np.clip(self.fillet_radius / 10.0, size / 1500.0, size / 150.0))
        self.first_spacing = chosen if self.spacing is None else self.spacing
        self.reach = None if reach is None else positive(f"{name}: reach", reach)
        if self.reach is not None and not 4.0 * self.first_spacing <= self.reach <= size:
            raise InputError(
                f"{name}: reach is {self.reach} m; it must be at least four times the spacing, "
                f"{4.0 * self.first_spacing:.4g} m, and at most the size of the mesh, {size:.4g} m."
            )
        if self.first_spacing > 0.1 * size:
            raise InputError(f"{name}: spacing is {spacing} m; it must be at most a tenth of the size, {size:.4g} m.")

    @property
    def smallest_radius(self) -> float:
        """Smallest convex radius [m]: zero where an edge is sharp; the border of a sheet is none."""
        return 0.0 if len(self.sharp_edges) else self.fillet_radius

    def smallest_width(self, axis: Any) -> float:
        """Width of the most slender part of the mesh, seen along ``axis`` in its own frame [m].

        The diameter of the largest circle in its silhouette.
        """
        return smallest_width(self.vertices, self.parts, np.asarray(axis, dtype=np.float64))

    def notes(self) -> list[str]:
        """Notes about the mesh for the log."""
        lines = [f"{self.name}: {len(self.faces)} triangles, {'closed' if self.closed else 'open sheet'}"]
        lines += [f"{self.name}: {note}" for note in self.source_notes]
        if self.removed_triangle_count:
            lines.append(f"{self.name}: {self.removed_triangle_count} degenerate triangles removed")
        lines += [*self._repairs, *self.warnings]
        if self.side is not None:
            lines.append(f"{self.name}: faces ({', '.join(f'{c:.3g}' for c in self.side)}), solid behind it")
        for plane in self.cut_planes:
            lines.append(f'{self.name}: ends at {plane} = 0; if it was cut there, give mirror=("{plane}",)')
        return lines


class TriangleMesh(Parameters):
    """Triangles as given, and options for processing them; ``MeshShape.from_triangles`` explains these.

    Attributes:
        vertices: (n, 3) [m].
        faces: three vertex indices each, (m, 3).
        name: for messages.
        path: of the source file, if any.
        source_notes: what was converted or left out when the mesh was read, for the log.
    """

    vertices: FloatArray = Field(repr=False)
    faces: IntArray = Field(repr=False)
    name: str = "tool mesh"
    path: str | None = None
    source_notes: tuple[str, ...] = ()
    side: FiniteVector | None = None
    mirror: tuple[str, ...] = ()
    spacing: Annotated[float, Quantity("length")] | None = None
    reach: Annotated[float, Quantity("length")] | None = None

    @model_validator(mode="after")
    def _bounds_a_tool(self) -> Self:
        self.surface  # noqa: B018
        return self

    @cached_property
    def surface(self) -> MeshSurface:
        """The checked mesh."""
        options = {name: getattr(self, name) for name in ("name", "side", "mirror", "spacing", "reach", "source_notes")}
        return MeshSurface(self.vertices, self.faces, **options)


class MeshShape(Shape):
    """A shape bounded by a triangle mesh.

    Attributes:
        mesh: its triangles, in the shape's own frame.
    """

    distance_function = "volume"
    positional = ("mesh",)

    mesh: TriangleMesh

    @classmethod
    def from_file(cls, path: str | os.PathLike[str], *, unit_scale: float = 1.0, **options: Any) -> Self:
        """Read STL, OBJ, PLY, OFF, 3MF, glTF, decks of Abaqus and CalculiX, VTK, Gmsh or Medit.

        Quadrilaterals and polygons are split. What is converted or left out is said in the log.

        Args:
            path: of the file; its ending names the format.
            unit_scale: metres per unit of the file: 1 for metres, 0.001 for millimetres.
            **options: those of ``from_triangles``.

        Raises:
            InputError: the file cannot be read, holds something that cannot be taken, or the mesh cannot be used.
        """
        unit_scale = argument("unit_scale", unit_scale, "unit scale")
        mesh = read_mesh(path, "tool mesh")
        faces, notes = mesh.triangles()
        mesh.check_unit(unit_scale)
        check_size(mesh.name, without_unused(mesh.vertices, [faces])[0], unit_scale)
        options = {"name": mesh.name, "path": str(path), "source_notes": notes, **options}
        return cls.from_triangles(unit_scale * mesh.vertices, faces, **options)

    @classmethod
    def from_triangles(
        cls,
        vertices: Any,
        faces: Any,
        *,
        origin: Any = (0.0, 0.0, 0.0),
        rotation: Any = None,
        **options: Any,
    ) -> Self:
        """A shape from vertices (n, 3) [m] and triangles (m, 3).

        Args:
            vertices: [m].
            faces: three vertex indices each.
            origin: where the mesh's origin lies [m].
            rotation: 3 x 3, columns: the mesh's axes in the world.
            name: for messages.
            side: of an open sheet, the direction from it to the fabric, in the mesh's frame. By default the mean of
                its triangles' normals. A closed mesh needs none.
            mirror: "x" or "y" or both, for a mesh that was cut at x = 0 or y = 0: the other half is added. Without it
                the cut is a wall of the tool.
            spacing: of the distance samples [m]; by default a tenth of the smallest fillet radius, if the number of
                samples allows.
            reach: largest sampled distance [m], at least four and by default six times the spacing. A node that gets
                deeper than this is no longer pushed out.
            path: of the source file, for information.

        Raises:
            InputError: no triangles, vertices that are not finite, or a size that no tool has.
        """
        frame = {} if rotation is None else {"rotation": rotation}
        return cls(TriangleMesh(vertices=vertices, faces=faces, **options), origin=origin, **frame)

    @property
    def surface(self) -> MeshSurface:
        """The checked mesh, one for all copies of the shape."""
        return self.mesh.surface

    @property
    def smallest_radius(self) -> float:
        return self.surface.smallest_radius

    def smallest_width(self, axis: Any = (0.0, 0.0, 1.0)) -> float:
        return self.surface.smallest_width(np.asarray(axis) @ np.array(self.rotation))

    def local_triangles(self) -> Triangles:
        return self.surface.vertices, self.surface.faces
