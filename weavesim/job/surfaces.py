"""The surface of each tool of a job, where it is drawn."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ..checks import Parameters
from ..errors import InputError, did_you_mean
from ..meshes import read_mesh
from ..ranges import quantity_of
from ..tools.mesh_tool import MeshShape, MeshSurface
from ..tools.shapes import Shape
from ..tools.surfaces.offset import offset_surface
from ..tools.surfaces.rim import facing_up, rim_faces, ring_over_rim
from .read import JobFile
from .schema import ToolTable
from .units import in_units, length_unit

# Rows are the world's axes in the frame of the file: each is a turn that takes its direction up.
TURNS: dict[str, tuple[tuple[int, int, int], ...]] = {
    "+z": ((1, 0, 0), (0, 1, 0), (0, 0, 1)), "-z": ((1, 0, 0), (0, -1, 0), (0, 0, -1)),
    "+y": ((1, 0, 0), (0, 0, -1), (0, 1, 0)), "-y": ((1, 0, 0), (0, 0, 1), (0, -1, 0)),
    "+x": ((0, 0, -1), (0, 1, 0), (1, 0, 0)), "-x": ((0, 0, 1), (0, 1, 0), (-1, 0, 0)),
}  # fmt: skip


def turned(vertices: np.ndarray, up: str) -> np.ndarray:
    """Points (n, 3) of a file in the frame whose z is the file's direction ``up``."""
    return vertices @ np.array(TURNS[up], dtype=np.float64).T


class Surfaces:
    """The shapes of the tools of a job, where they are drawn; those of others are made from theirs.

    Args:
        file: the job.
        thickness: of all plies together [m].
    """

    def __init__(self, file: JobFile, thickness: float) -> None:
        self._file, self._thickness = file, thickness
        self._names = [tool.name for tool in file.job.tool]
        self._read: dict[str, MeshShape] = {}

    def shape(self, index: int) -> Shape:
        """Of one tool, moved as it says.

        Raises:
            InputError: a file that cannot be read, or a surface that cannot be made.
        """
        tool = self._file.job.tool[index]
        if tool.file is not None:
            shape: Shape = self._from_file(index)
        elif tool.shape is not None:
            shape = self._built_in(index, tool.shape)
        else:
            shape = self._from_other(index)
        return shape.placed(tool.move) if any(tool.move) else shape

    def facing(self, index: int) -> str | None:
        """ "up" or "down", towards the sheet; None if a built-in shape does not say it."""
        tool = self._file.job.tool[index]
        other = tool.offset_of or tool.ring_of
        if other is None:
            return tool.faces
        return "down" if self.facing(self._names.index(other)) == "up" else "up"

    def _from_file(self, index: int) -> MeshShape:
        tool = self._file.job.tool[index]
        if tool.name not in self._read:
            path = self._file.file(tool.file or "", ["tool", index, "file"])
            try:
                self._read[tool.name] = _mesh_of(tool, path)
            except InputError as error:
                self._file.refuse(["tool", index, "file"], error)
        return self._read[tool.name]

    def _built_in(self, index: int, values: dict[str, Any]) -> Shape:
        keys = ["tool", index, "shape"]
        kinds = {name: kind for name, kind in Shape.kinds().items() if kind is not MeshShape}
        name = values.get("kind")
        if name not in kinds:
            hint = did_you_mean(str(name), kinds)
            self._file.refuse(keys, f"shape: kind = {name!r}: one of {', '.join(kinds)} is needed{hint}")
        try:
            shape = kinds[name](**_numbers(kinds[name], {k: v for k, v in values.items() if k != "kind"}))
        except (InputError, ValueError) as error:
            self._file.refuse(keys, f"shape: {error}")
        self._file.ask(keys, shape)
        return shape

    def _from_other(self, index: int) -> MeshShape:
        """An offset surface, or a ring."""
        tool = self._file.job.tool[index]
        key = "offset_of" if tool.offset_of else "ring_of"
        other = self._names.index(tool.offset_of or tool.ring_of or "")
        base = self._file.job.tool[other]
        surface = self.shape(other).surface
        assert surface is not None
        up = self.facing(other) == "up"
        flip = np.array([1.0, 1.0, 1.0] if up else [1.0, -1.0, -1.0])
        shift = np.array(base.move)
        part = facing_up((surface.vertices + shift) * flip, surface.faces)
        try:
            if key == "ring_of":
                made = ring_over_rim(f"tool {base.name}", part.vertices, part.faces, self._thickness)
                vertices, faces = made.vertices, made.faces
            else:
                faces = part.faces
                if any(each.ring_of == base.name for each in self._file.job.tool):
                    faces = faces[~rim_faces(part.vertices, faces)]
                if not len(faces):
                    raise InputError(
                        f"tool {base.name} has no opening: all of it is the flat rim, over which a ring lies; leave "
                        "the ring out, or give the punch as a file"
                    )
                vertices = offset_surface(f"tool {base.name}", part.vertices, faces, float(tool.gap or 0.0))
                faces = faces[:, ::-1]
            side = (0.0, 0.0, -1.0 if up else 1.0)
            return MeshShape.from_triangles(vertices * flip, faces, name=f"tool {tool.name}", side=side)
        except InputError as error:
            self._file.refuse(["tool", index, key], error)


def _mesh_of(tool: ToolTable, path: Path) -> MeshShape:
    """A tool's surface from a file, in the frame of the world."""
    mesh = read_mesh(path, "tool mesh")
    faces, notes = mesh.triangles()
    scale = mesh.metres_per_unit if tool.unit is None else length_unit(tool.unit)
    if scale is None:
        raise InputError(
            f"unit: is required with {path.name}, whose format does not say it: the length of one unit of the file, "
            "such as mm, inch or m"
        )
    mesh.check_unit(scale)
    side = (0.0, 0.0, 1.0 if tool.faces == "up" else -1.0)
    vertices = turned(scale * mesh.vertices, tool.up)
    options: dict[str, Any] = {"name": f"tool {tool.name} ({path.name})", "side": side, "source_notes": notes}
    if tool.offset != 0.0:
        surface = MeshSurface(vertices, faces, mirror=tool.mirror, **options)
        moved = offset_surface(f"tool {tool.name}", surface.vertices, surface.faces, tool.offset)
        return MeshShape.from_triangles(moved, surface.faces, path=str(path), **options)
    return MeshShape.from_triangles(vertices, faces, mirror=tool.mirror, path=str(path), **options)


def _numbers(cls: type[Parameters], values: dict[str, Any]) -> dict[str, Any]:
    """Values of a built-in shape in SI units."""
    result: dict[str, Any] = {}
    for name, value in values.items():
        field = cls.model_fields.get(name)
        quantity = quantity_of(field) if field else None
        try:
            if quantity is not None:
                value = in_units(value, quantity.row)
        except ValueError as error:
            raise InputError(f"{name} = {value!r}: {error}") from None
        result[name] = value
    return result
