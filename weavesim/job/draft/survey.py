"""What the surface of a tool tells: its unit, the direction of the press, the rim, and how large a blank must be."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...errors import InputError
from ...input_files import unit_name
from ...meshes import read_mesh
from ...tools.mesh_features import face_normals, fillet_radius
from ...tools.mesh_repair import without_unused
from ...tools.mesh_tool import MeshSurface
from ...tools.surfaces.rim import facing_up, rim_faces
from ..surfaces import TURNS, turned
from ..units import length_unit

# Sizes of a file in its own unit from which on it is in millimetres, and up to which it is in metres; inches between.
LEAST_MILLIMETRES = 20.0
MOST_METRES = 3.0
# An open sheet whose normals' mean is further from an axis than this is asked about [degrees].
SLANTED = 20.0
# A surface of less depth than this share of its size tells no direction.
LEAST_DEPTH = 0.01


@dataclass(frozen=True)
class Survey:
    """What was found of a tool's file, in metres and with its direction up along z.

    Attributes:
        unit: of the file.
        unit_reason: how it is known.
        up: direction in the file.
        up_reason: how it was found.
        lower, upper: corners of the box around the part that faces the sheet, (3,) [m].
        opening: corners of the box around what is not rim, in plan, (2, 2) [m].
        rim_height: of the flat rim [m]; None without one.
        is_female: whether the rim is the highest part, so that the sheet lies on it.
        radius: smallest convex radius [m]; infinite if nothing is round.
        arc: lengths of the sections along x and y through the middle of the opening, without the rim, (2,) [m].
        rim_area: [m^2].
    """

    unit: str
    unit_reason: str
    up: str
    up_reason: str
    lower: np.ndarray
    upper: np.ndarray
    opening: np.ndarray
    rim_height: float | None
    is_female: bool
    radius: float
    arc: np.ndarray
    rim_area: float

    @property
    def size(self) -> np.ndarray:
        """Sides of the box along x, y and z, (3,) [m]."""
        return self.upper - self.lower

    @property
    def centre(self) -> np.ndarray:
        """Of the opening, in plan, (2,) [m]."""
        return self.opening.mean(axis=0)


def survey(path: Path, *, unit: str | None = None, up: str | None = None) -> Survey:
    """Look at the file of a tool.

    Args:
        path: of the mesh or CAD file.
        unit: of the file; None finds it from the size.
        up: direction in the file towards the punch; None finds it.

    Raises:
        InputError: a file that cannot be read, or that shows no direction.
    """
    mesh = read_mesh(path, "tool mesh")
    faces, _ = mesh.triangles()
    vertices, (faces,) = without_unused(mesh.vertices, [faces])
    unit, unit_reason = _unit(vertices, mesh.metres_per_unit, unit)
    vertices = length_unit(unit) * vertices
    surface = MeshSurface(vertices, faces, name=mesh.name, side=None if up is None else TURNS[up][2])
    up, up_reason = (up, "as given") if up is not None else _up(surface)
    placed = turned(surface.vertices, up)
    surface_faces = surface.faces
    part = facing_up(placed, surface_faces)
    if not len(part.faces):
        raise InputError(f"{mesh.name}: nothing of it faces {up}; give another direction with --up")
    rim = rim_faces(part.vertices, part.faces)
    area = face_normals(part.vertices, part.faces)[1]
    lower, upper = part.vertices.min(axis=0), part.vertices.max(axis=0)
    if np.all(rim):  # a plate
        rim = np.zeros(len(rim), dtype=bool)
    inside = part.vertices[part.faces[~rim].ravel()]
    height = float(part.vertices[part.faces[rim]][:, :, 2].mean()) if np.any(rim) else None
    opening = np.stack([inside[:, :2].min(axis=0), inside[:, :2].max(axis=0)])
    female = height is not None and height > 0.5 * (lower[2] + upper[2])
    arc = np.array([_arc(part.vertices, part.faces[~rim], opening.mean(axis=0), k) for k in range(2)])
    return Survey(
        unit=unit,
        unit_reason=unit_reason,
        up=up,
        up_reason=up_reason,
        lower=lower,
        upper=upper,
        opening=opening,
        rim_height=height,
        is_female=female,
        radius=fillet_radius(part.vertices, part.faces),
        arc=np.maximum(arc, opening[1] - opening[0]),
        rim_area=float(area[rim].sum()),
    )


def _unit(vertices: np.ndarray, metres_per_unit: float | None, given: str | None) -> tuple[str, str]:
    """Unit of a file, and how it is known."""
    if given is not None:
        try:
            length_unit(given)
        except ValueError as error:
            raise InputError(f"--unit {given}: {error}") from None
        return given, "as given"
    sides = np.ptp(vertices, axis=0)
    text = " x ".join(f"{side:.4g}" for side in sides)
    if metres_per_unit is not None:
        name = unit_name(metres_per_unit)
        if name is not None:
            return name, "as the file says"
    size = float(sides.max())
    unit = "mm" if size >= LEAST_MILLIMETRES else "m" if size <= MOST_METRES else "inch"
    return unit, f"guessed from the size of {text}"


def _up(surface: MeshSurface) -> tuple[str, str]:
    """Direction from a tool to the sheet, as an axis of the file, and how it was found."""
    if surface.side is not None:
        side = np.array(surface.side)
        axis = int(np.argmax(np.abs(side)))
        name = ("+" if side[axis] > 0.0 else "-") + "xyz"[axis]
        angle = math.degrees(math.acos(min(1.0, abs(float(side[axis])))))
        slanted = f", {angle:.0f} degrees off: turn it in the CAD if the press is vertical" if angle > SLANTED else ""
        return name, f"the open surface faces {name} by its triangles{slanted}"
    # of a block, the side that is hollow or raised
    depths = {}
    for name in TURNS:
        part = facing_up(turned(surface.vertices, name), surface.faces)
        if len(part.faces):
            depths[name] = _depth(part.vertices, part.faces)
    best = max(depths, key=lambda name: depths[name])
    if depths[best] < LEAST_DEPTH * float(np.linalg.norm(np.ptp(surface.vertices, axis=0))):
        raise InputError(f"{surface.name}: all its sides are flat; give the direction to the sheet with --up")
    return best, f"the side {best} of the body is not flat"


def _depth(vertices: np.ndarray, faces: np.ndarray) -> float:
    """Height between the faces that face up, weighted with their area: of a flat side zero [m]."""
    normal, area = face_normals(vertices, faces)
    height, weight = vertices[faces].mean(axis=1)[:, 2], area * np.maximum(normal[:, 2], 0.0)
    mean = np.average(height, weights=weight)
    return 2.0 * math.sqrt(float(np.average((height - mean) ** 2, weights=weight)))


def _arc(vertices: np.ndarray, faces: np.ndarray, centre: np.ndarray, along: int) -> float:
    """Length of the section of a surface along an axis, through ``centre`` in plan [m]."""
    corner = vertices[faces]
    place = corner[:, :, 1 - along] - centre[1 - along] - 1.0e-9
    crossed = (place > 0.0) != np.roll(place > 0.0, -1, axis=1)
    triangle = np.flatnonzero(crossed.any(axis=1))
    if not len(triangle):
        return 0.0
    side = np.argsort(~crossed[triangle], axis=1, kind="stable")[:, :2]
    start, end = (triangle[:, None], side), (triangle[:, None], (side + 1) % 3)
    share = place[start] / (place[start] - place[end])
    point = corner[start] + share[:, :, None] * (corner[end] - corner[start])
    return float(np.linalg.norm(point[:, 1] - point[:, 0], axis=1).sum())
