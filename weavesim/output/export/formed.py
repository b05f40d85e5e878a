"""Formed sheets as parts: on their own meshes, computed part or whole, or mapped onto another mesh."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ...errors import InputError
from ...meshes.reading import read_mesh
from ...sheet.symmetry import on_plane
from ..stored.file import StoredRun, StoredSheet
from ..stored.values import ElementValue
from .nearest import nearest
from .part import CORNERS, Cells, Part, Ply, ShellMesh, across_normal

# Elements of the other mesh may lie this many elements of the sheet away from it.
USUAL_DISTANCE = 2.0
# Beyond this angle between the normals of an element and of the sheet beneath it, they are not the same surface.
LARGEST_TILT_DEG = 60.0


def own_parts(run: StoredRun, *, whole: bool = False, layers_per_ply: int = 2) -> tuple[Part, ...]:
    """Each sheet on its own mesh, with the numbers of the mesh that its user gave, else counted from 1.

    Where a sheet has a number that one before it has, all of its numbers go on behind the largest so far.

    Args:
        run: whose end it is.
        whole: with the mirrored copies of a sheet that is cut at planes of symmetry.
        layers_per_ply: see ``Part``.
    """
    parts: list[Part] = []
    for sheet in run.sheets:
        mesh, ply = _own_ply(sheet, whole)
        nodes = _first_free([part.mesh.node_labels for part in parts], mesh.node_labels)
        elements = _first_free([part.mesh.labels for part in parts], mesh.labels)
        mesh = ShellMesh(
            mesh.nodes, mesh.node_labels + nodes, tuple(replace(c, labels=c.labels + elements) for c in mesh.cells)
        )
        notes: tuple[str, ...] = ()
        if sheet.symmetry.planes and not whole:
            notes = (f"sheet {sheet.name}: the computed part only, cut at {_planes(sheet)}; --whole adds the rest",)
        if (nodes or elements) and (sheet.blank.node_number is not None or sheet.blank.element_number is not None):
            notes += (f"sheet {sheet.name}: numbers of its mesh plus {nodes} (nodes) and {elements} (elements)",)
        parts.append(Part(part_name(sheet.name), mesh, (ply,), layers_per_ply, notes))
    return tuple(parts)


def _first_free(used: list[np.ndarray], own: np.ndarray) -> int:
    """What is added to numbers so that none is used twice; 0 if none is."""
    so_far = np.concatenate(used) if used else np.zeros(0, dtype=int)
    return int(so_far.max()) if np.isin(own, so_far).any() else 0


def part_name(name: str) -> str:
    """A name that every format takes: letters, digits and underscores."""
    text = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_")
    return text if text and text[0].isalpha() else f"part_{text}".rstrip("_")


def _planes(sheet: StoredSheet) -> str:
    return " and ".join(f"{plane} = 0" for plane in sheet.symmetry.planes)


def _own_ply(sheet: StoredSheet, whole: bool) -> tuple[ShellMesh, Ply]:
    copies = sheet.symmetry.mirror_factors if whole else ((1, 1),)
    nodes: list[np.ndarray] = []
    quads: list[np.ndarray] = []
    directions: list[list[np.ndarray]] = []
    yarns = [sheet.values[f"{yarn}_direction"].values for yarn in ("warp", "weft")]
    for factors in copies:
        mirror = np.array([*factors, 1.0])
        rows = sheet.blank.quads + len(nodes) * sheet.blank.node_count
        # a mirror turns elements over
        quads.append(rows if np.prod(factors) > 0 else rows[:, ::-1])
        nodes.append(sheet.position * mirror)
        directions.append([yarn * mirror for yarn in yarns])
    points, corners = np.concatenate(nodes), np.concatenate(quads)
    kept = np.arange(len(points))
    if len(copies) > 1:
        kept, corners = _joined(sheet, points, corners, copies)
    blank, points = sheet.blank, points[kept]
    labels = np.arange(1, len(points) + 1)
    if blank.node_number is not None:
        labels = _of_copies(blank.node_number, blank.node_count * len(copies), copies)[kept]
    mesh = ShellMesh(points, labels, (Cells("quad", corners, _of_copies(blank.element_number, len(corners), copies)),))
    warp, weft = (np.concatenate([pair[k] for pair in directions]) for k in (0, 1))
    names = sheet.values if not whole else [n for n, v in sheet.values.items() if v.values.ndim == 1]
    left_out = ("warp_direction", "weft_direction", "warp_angle_deg", "weft_angle_deg")
    values = {
        name: replace(sheet.values[name], values=np.concatenate([sheet.values[name].values] * len(copies)))
        for name in names
        if name not in left_out
    }
    thickness = values["thickness"].values if "thickness" in values else np.full(len(corners), sheet.thickness)
    return mesh, Ply(sheet.name, sheet.fabric, warp, weft, thickness, sheet.thickness, values)


def _of_copies(numbers: np.ndarray | None, count: int, copies: tuple[tuple[int, int], ...]) -> np.ndarray:
    """Numbers of what all copies have, (count,): those of the first, then likewise behind the largest so far."""
    if numbers is None:
        return np.arange(1, count + 1)
    return np.concatenate([numbers + k * int(numbers.max()) for k in range(len(copies))])


def _joined(
    sheet: StoredSheet, points: np.ndarray, corners: np.ndarray, copies: tuple[tuple[int, int], ...]
) -> tuple[np.ndarray, np.ndarray]:
    """Nodes that stay, (n,), and corners, where copies share the nodes on the planes of symmetry."""
    count, own = sheet.blank.node_count, np.arange(len(points))
    held = {axis: on_plane(sheet.blank, plane) for axis, plane in enumerate("xy") if plane in sheet.symmetry.planes}
    place = {factors: k for k, factors in enumerate(copies)}
    for k, factors in enumerate(copies):
        for node in range(count):
            # the copy on the positive side of every plane that the node lies on
            x, y = (1 if axis in held and held[axis][node] else factors[axis] for axis in (0, 1))
            own[k * count + node] = place[x, y] * count + node
    kept, corners = np.unique(own[corners], return_inverse=True)
    return kept, corners.reshape(-1, 4)


@dataclass(frozen=True, eq=False)
class Mapping:
    """How the plies came onto another mesh.

    Attributes:
        part: the other mesh with the plies.
        largest_distance: from a centre of its elements to a formed sheet [m].
        mean_distance: the mean [m].
        largest_tilt: between the normals of an element and of the sheet beneath it [degrees].
    """

    part: Part
    largest_distance: float
    mean_distance: float
    largest_tilt: float


def mapped_part(
    run: StoredRun, path: str | Path, *, unit: float = 1.0, within: float | None = None, layers_per_ply: int = 2
) -> Mapping:
    """All sheets on the mesh of a file, each value from the nearest point of the formed sheet in space.

    Sheets are mapped with their mirrored copies. Their order in the lay-up is that along the normals of the mesh.

    Args:
        run: whose end it is.
        path: of a mesh file of triangles and quadrilaterals.
        unit: metres per unit of the file.
        within: largest distance allowed between an element's centre and a sheet [m]; by default two elements of the
            sheet.
        layers_per_ply: see ``Part``.

    Raises:
        InputError: a file that cannot be read, without shells, or a mesh that does not lie on the formed sheets.
    """
    mesh, notes = read_shells(path, unit)
    plies, sides, tilts = [], [], []
    for sheet in run.sheets:
        ply, side, tilt = _mapped_ply(sheet, mesh, within, str(path))
        plies.append(ply)
        sides.append(side)
        tilts.append(tilt)
    order = np.argsort(sides, kind="stable")
    plies = [plies[k] for k in order]
    if len(plies) > 1:
        notes = (*notes, "plies from the bottom to the top: " + ", ".join(ply.name for ply in plies))
    distances = np.concatenate([ply.distance for ply in plies if ply.distance is not None])
    part = Part(part_name(Path(path).stem), mesh, tuple(plies), layers_per_ply, notes)
    return Mapping(part, float(distances.max()), float(distances.mean()), max(tilts))


def read_shells(path: str | Path, unit: float) -> tuple[ShellMesh, tuple[str, ...]]:
    """Triangles and quadrilaterals of a mesh file, with its numbers.

    Raises:
        InputError: other cells, or none.
    """
    file = read_mesh(path, "mesh to map onto")
    file.check_unit(unit)
    cells, notes = [], list(file.notes)
    for block in file.cells:
        kind = {"triangle7": "triangle6", "quad9": "quad8"}.get(block.kind, block.kind)
        if kind not in CORNERS:
            raise InputError(
                f"{file.name}: {len(block.nodes)} {block.called} are no shell elements; triangles and quadrilaterals "
                "of three, four, six or eight nodes are needed"
            )
        if kind != block.kind:
            notes.append(f"{file.name}: the nodes at the centres of {len(block.nodes)} {block.called} are left out")
        count = {"triangle": 3, "quad": 4, "triangle6": 6, "quad8": 8}[kind]
        if len(block.nodes):
            cells.append(Cells(kind, block.nodes[:, :count], np.asarray(block.labels)))
    if not cells:
        raise InputError(f"{file.name}: it has no triangles or quadrilaterals; give the shell mesh of the part")
    labels = np.arange(1, len(file.vertices) + 1) if file.node_labels is None else np.asarray(file.node_labels)
    used = np.unique(np.concatenate([block.nodes.ravel() for block in cells]))
    place = np.full(len(file.vertices), -1)
    place[used] = np.arange(len(used))
    mesh = ShellMesh(
        unit * file.vertices[used], labels[used], tuple(replace(block, nodes=place[block.nodes]) for block in cells)
    )
    if len(np.unique(mesh.labels)) < mesh.element_count:
        raise InputError(f"{file.name}: two elements have the same number; give each its own")
    return mesh, tuple(notes)


def _mapped_ply(sheet: StoredSheet, mesh: ShellMesh, within: float | None, name: str) -> tuple[Ply, float, float]:
    """The ply, how far it lies on the side of the normals [m], and the largest angle between normals [degrees]."""
    own, ply = _own_ply(sheet, bool(sheet.symmetry.planes))
    quads = own.cells[0].nodes
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    points, found = nearest(own.nodes[triangles], mesh.centres)
    element = found % len(quads)
    distance = np.linalg.norm(points - mesh.centres, axis=1)
    size = float(np.sqrt(np.linalg.norm(np.cross(*_diagonals(own)), axis=1).max() / 2.0))
    limit = USUAL_DISTANCE * size if within is None else within
    if (far := distance > limit).any():
        worst = int(np.argmax(distance))
        raise InputError(
            f"mesh to map onto {name}: {int(far.sum())} of {mesh.element_count} elements lie farther than {limit:.4g} "
            f"m from the formed sheet {sheet.name}, element {mesh.labels[worst]} {distance[worst]:.4g} m: move or trim "
            "the mesh to the formed part, check its unit (--unit), or allow a larger distance (--within)"
        )
    normal = mesh.frames[:, 2]
    tilt = np.degrees(np.arccos(np.clip(np.abs(np.einsum("ei,ei->e", own.frames[element, 2], normal)), 0.0, 1.0)))
    if (steep := tilt > LARGEST_TILT_DEG).any():
        worst = int(np.argmax(tilt))
        raise InputError(
            f"mesh to map onto {name}: {int(steep.sum())} elements stand across the formed sheet {sheet.name} beneath "
            f"them, element {mesh.labels[worst]} by {tilt[worst]:.3g} degrees: they are not the same surface; move or "
            "trim the mesh to the formed part"
        )
    side = float(np.einsum("ei,ei->e", points - mesh.centres, normal).mean())
    values = {key: replace(v, values=v.values[element]) for key, v in ply.values.items()}
    values["distance"] = ElementValue("m", "from the element's centre to the formed sheet", distance)
    mapped = Ply(
        ply.name, ply.fabric, across_normal(ply.warp[element], normal), across_normal(ply.weft[element], normal),
        ply.thickness[element], ply.initial_thickness, values, distance,
    )  # fmt: skip
    return mapped, side, float(tilt.max())


def _diagonals(mesh: ShellMesh) -> tuple[np.ndarray, np.ndarray]:
    corner = mesh.nodes[mesh.cells[0].nodes]
    return corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1]
