"""The plies of a job: blanks with their fabrics."""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...errors import InputError
from ...fabric.fabric import Fabric
from ...fabric.file import fabric_of_table, load_fabric, resolve_fabric
from ...meshes import read_mesh
from ...meshes.mesh_file import TRIANGLE
from ...ranges import ACCEPTING
from ...sheet.blank import Blank
from ...sheet.fitted_mesh import fitted_mesh
from ...sheet.lay_up_code import angles_of
from ...sheet.slits import cut_open
from ..placing import Box
from ..read import JobFile
from ..schema import OUTLINES, PlyTable
from ..units import length_unit
from .outlines import Loops, border_of, read_drawing

# Corners of a polygon that stands for a disc.
DISC_CORNERS = 360
# More elements take minutes to make, and days to form.
LARGEST_USUAL_COUNT = 1.0e6


def plies_of(file: JobFile) -> tuple[tuple[int, PlyTable], ...]:
    """Every ply with the place of its table, from below to above; those of a lay-up each on their own."""
    found: list[tuple[int, PlyTable]] = []
    for index, ply in enumerate(file.job.ply):
        if ply.layup is None:
            found.append((index, ply))
            continue
        for number, angle in enumerate(angles_of(ply.layup), start=1):
            values = {name: getattr(ply, name) for name in ply.model_fields_set if name != "layup"}
            made = PlyTable(**{**values, "name": f"{ply.name}_{number}", "angle": angle})
            file.ask(["ply", index, "layup"], made)
            found.append((index, made))
    names = [ply.name for _, ply in found]
    used = {ply.fabric for ply in file.job.ply}
    for name in file.job.fabric:
        if name not in used:
            file.refuse(["fabric", name], f"no ply is of it; write fabric = {name!r} in its [[ply]], or leave it out")
    for place, (index, ply) in enumerate(found):
        if ply.name in names[:place]:
            file.refuse(["ply", index, "name"], f"name = {ply.name!r}: another ply has it; give each its own")
    return tuple(found)


def fabric_of(file: JobFile, index: int) -> Fabric:
    """The fabric of a ply.

    Raises:
        InputError: there is none of this name, or it has mistakes.
    """
    name, keys = file.job.ply[index].fabric, ["ply", index, "fabric"]
    if name in file.job.fabric:
        return fabric_of_table(
            file.document, file.values["fabric"][name], ("fabric", name), accept_unusual=file.job.accept_unusual
        )
    if name.lower().endswith((".toml", ".json")):
        return load_fabric(file.file(name, keys), accept_unusual=file.job.accept_unusual)
    try:
        return resolve_fabric(name, accept_unusual=file.job.accept_unusual)
    except InputError as error:
        file.refuse(keys, error)


class PlyOutline(NamedTuple):
    """The outline of a ply in its place, or its mesh.

    Attributes:
        loops: outline, holes and slits; of a mesh, only its box.
        mesh: of a file of quadrilaterals, as it stands there; None for an outline that is yet to be meshed.
    """

    loops: Loops
    mesh: Blank | None = None

    @property
    def box(self) -> Box:
        """Around it, in plan."""
        return Box(self.loops.outline.min(axis=0), self.loops.outline.max(axis=0))


def outline_of(file: JobFile, index: int, ply: PlyTable) -> PlyOutline:
    """The outline of a ply, turned and in its place.

    Raises:
        InputError: a file that cannot be read.
    """
    if ply.outline is not None:
        path = file.file(ply.outline, ["ply", index, "outline"])
        try:
            return _from_file(ply, path)
        except InputError as error:
            file.refuse(["ply", index, "outline"], error)
    if ply.rectangle is not None:
        x, y = 0.5 * np.array(ply.rectangle)
        corners = np.array([[-x, -y], [x, -y], [x, y], [-x, y]])
    elif ply.disc is not None:
        angle = np.linspace(0.0, 2.0 * math.pi, DISC_CORNERS, endpoint=False)
        corners = 0.5 * ply.disc * np.column_stack([np.cos(angle), np.sin(angle)])
    else:
        corners = np.array(ply.polygon)
    return PlyOutline(_placed(Loops(corners), ply))


def _from_file(ply: PlyTable, path: Path) -> PlyOutline:
    scale = None if ply.unit is None else length_unit(ply.unit)
    if path.suffix.lower() == ".dxf":
        return PlyOutline(_placed(read_drawing(path, layer=ply.layer, metres_per_unit=scale), ply))
    mesh = read_mesh(path, "blank mesh")
    scale = mesh.metres_per_unit if scale is None else scale
    if scale is None:
        raise InputError(f"unit: is required with {path.name}, whose format does not say it: mm, inch, ...")
    if all(len(cells.nodes) == 0 or cells.kind == TRIANGLE for cells in mesh.cells):
        faces, _ = mesh.triangles()
        mesh.check_unit(scale)
        if ply.numbering is not None:
            raise InputError(
                f"numbering: {path.name} has triangles, which give an outline that is meshed; leave it out"
            )
        return PlyOutline(_placed(border_of(mesh, faces, scale), ply))
    if ply.holes or ply.slits:
        raise InputError("holes and slits: a mesh of quadrilaterals has its own; leave them out")
    blank = Blank.from_file(path, unit_scale=scale, yarn_angle=ply.angle, numbering=ply.numbering or "kept")
    position = blank.node_position.copy()
    position[:, :2] = placed(position[:, :2], ply)
    notes = (*blank.source_notes, f"{mesh.name}: its own elements are used")
    return PlyOutline(Loops(position[:, :2]), _moved(blank, position, ply, notes))


def _moved(blank: Blank, position: np.ndarray, ply: PlyTable, notes: tuple[str, ...]) -> Blank:
    """A blank of the same mesh with its nodes at ``position``, its yarns at the angle of the ply."""
    moved = Blank.from_mesh(position, blank.quads, yarn_angle=ply.angle, merge_nodes=0.0)
    kept = {"node_number": blank.node_number, "element_number": blank.element_number}
    return moved.model_copy(update={**kept, "source_notes": notes})


def _placed(loops: Loops, ply: PlyTable) -> Loops:
    """Loops turned and shifted as their ply says, with the holes and slits that it has itself."""
    return Loops(
        placed(loops.outline, ply),
        tuple(placed(np.asarray(hole), ply) for hole in (*loops.holes, *ply.holes)),
        tuple(placed(np.asarray(slit), ply) for slit in (*loops.slits, *ply.slits)),
        loops.notes,
    )


def placed(points: np.ndarray, ply: PlyTable) -> np.ndarray:
    """Points (n, 2) of an outline, turned and shifted as its ply says."""
    cosine, sine = math.cos(math.radians(ply.turn)), math.sin(math.radians(ply.turn))
    if ply.turn:
        points = points @ np.array([[cosine, sine], [-sine, cosine]])
    return points + np.array(ply.centre)


def blank_of(file: JobFile, index: int, ply: PlyTable, outline: PlyOutline, height: float) -> Blank:
    """The mesh of a ply.

    Args:
        file: the job.
        index: of its table.
        ply: the ply.
        outline: its outline.
        height: of its middle [m]; a curved mesh is raised by it.

    Raises:
        InputError: an outline that cannot be meshed.
    """
    try:
        if outline.mesh is None and not file.job.accept_unusual:
            _check_count(outline.loops.outline, ply.mesh_size)
        return _blank(ply, outline, height)
    except InputError as error:
        file.refuse(["ply", index, next(name for name in OUTLINES if getattr(ply, name) is not None)], error)


def _check_count(corners: np.ndarray, mesh_size: float) -> None:
    """Ask about a mesh without end before it is made."""
    x, y = corners.T
    area = 0.5 * abs(float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))))
    if area > LARGEST_USUAL_COUNT * mesh_size**2:
        width, length = np.ptp(corners, axis=0)
        raise InputError(
            f"a ply of {width:.4g} x {length:.4g} m has about {area / mesh_size**2:,.0f} elements of {mesh_size:g} m: "
            f"check the unit of the outline, or take larger elements. {ACCEPTING}"
        )


def _blank(ply: PlyTable, outline: PlyOutline, height: float) -> Blank:
    if outline.mesh is not None:
        position = outline.mesh.node_position.copy()
        is_flat = np.ptp(position[:, 2]) <= 1e-9 * np.ptp(position)
        position[:, 2] = height if is_flat else position[:, 2] + height
        return _moved(outline.mesh, position, ply, outline.mesh.source_notes)
    loops = outline.loops
    whole = not loops.holes and not loops.slits
    straight = whole and ply.rectangle is not None and ply.turn % 90.0 == 0.0
    corners = loops.outline
    if straight and (ply.mesh_along == "outline" or ply.angle % 90.0 == 0.0):
        lower, upper = corners.min(axis=0), corners.max(axis=0)
        return Blank.rectangle(
            (float(lower[0]), float(lower[1])), (float(upper[0]), float(upper[1])), ply.mesh_size,
            yarn_angle=ply.angle, height=height,
        )  # fmt: skip
    side = np.roll(corners, -1, axis=0) - corners
    longest = side[int(np.argmax(np.linalg.norm(side, axis=1)))]
    along = math.degrees(math.atan2(longest[1], longest[0])) if ply.mesh_along == "outline" else ply.angle
    plan, quads = fitted_mesh(corners, ply.mesh_size, holes=loops.holes, mesh_angle=along)
    notes_of = list(loops.notes)
    if loops.slits:
        plan, quads, off = cut_open(plan, quads, loops.slits, ply.mesh_size)
        notes_of.append(f"{ply.name}: slits are cut along edges of elements, up to {1e3 * off:.2g} mm beside them")
    blank = Blank.from_mesh(
        np.column_stack([plan, np.full(len(plan), height)]), quads, yarn_angle=ply.angle,
        merge_nodes=0.0 if loops.slits else None,
    )  # fmt: skip
    return blank.model_copy(update={"source_notes": tuple(notes_of)}) if notes_of else blank
