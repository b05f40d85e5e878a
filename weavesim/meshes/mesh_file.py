"""What a mesh file holds: vertices, and every cell that bounds a surface, under the names that the file gives them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import InputError
from ..input_files import unit_wish
from .source import Source, counted, listed
from .triangles import Crossing, out_of_plane, polygon_triangles, quad_triangles, without_repeats

# Kinds of cells by their number of nodes; anything else with three or more corners is a "polygon".
TRIANGLE, QUAD, POLYGON = "triangle", "quad", "polygon"
# Corners first, then the nodes between them in the same order, then the centre, as in VTK, Abaqus and Gmsh.
SECOND_ORDER = {"triangle6": 3, "triangle7": 3, "quad8": 4, "quad9": 4}

MOST_CORNERS = 10_000
# Polygons whose corners lie farther off a plane than this share of their size are noted.
FLAT = 1e-3


@dataclass(frozen=True)
class Cells:
    """Cells of one kind.

    Attributes:
        kind: "triangle", "quad", "polygon", or one of ``SECOND_ORDER``.
        called: what the file's format calls such a cell, for messages.
        nodes: rows of ``MeshFile.vertices``, (m, k).
        labels: numbers of the cells for messages, (m,): the file's own, or counted from 1.
    """

    kind: str
    called: str
    nodes: np.ndarray
    labels: np.ndarray


@dataclass(frozen=True)
class MeshFile:
    """A mesh as its file has it: every surface cell, and a word on whatever else there is.

    Attributes:
        name: of the file, for messages.
        format: in words, such as "binary STL".
        vertices: (n, 3), in the unit of the file.
        cells: all surface cells; ``triangles`` and ``quads`` say how they are taken.
        notes: what was found beside them and left out, or converted.
        label_word: what the labels of the cells count: "element", "triangle", "line", ...
        node_labels: the file's own numbers of the vertices, (n,); None where it has none.
        metres_per_unit: of coordinates, where the file says it.
    """

    name: str
    format: str
    vertices: np.ndarray
    cells: tuple[Cells, ...]
    notes: tuple[str, ...] = ()
    label_word: str = "element"
    node_labels: np.ndarray | None = None
    metres_per_unit: float | None = None

    def triangles(self) -> tuple[np.ndarray, tuple[str, ...]]:
        """All cells as triangles (m, 3), and notes on what was converted.

        Quadrilaterals are split along the shorter diagonal, concave ones along the one inside; polygons by clipping
        ears; cells of second order along the lines between all of their nodes.

        Raises:
            InputError: no cells, or one whose outline crosses itself.
        """
        notes = list(self.notes)
        parts = []
        for cells in self.cells:
            triangles = self._split(cells, notes)
            parts.append(triangles)
            if cells.kind != TRIANGLE:
                kind = "of second order " if cells.kind in SECOND_ORDER else ""
                notes.append(f"{len(cells.nodes)} {cells.called} {kind}split into {len(triangles)} triangles")
        if not sum(map(len, parts)):
            raise InputError(f"{self.name} has no triangles; export the tool's surface as a triangle mesh.")
        return np.concatenate(parts), tuple(notes)

    def quads(self) -> tuple[np.ndarray, np.ndarray]:
        """All cells as quadrilaterals (m, 4), and their labels (m,).

        Raises:
            InputError: no cells, or cells of another kind.
        """
        others = [cells for cells in self.cells if cells.kind != QUAD and len(cells.nodes)]
        if others:
            found = "; ".join(
                f"{len(c.nodes)} {c.called} ({self.label_word}s {listed(c.labels.tolist())})"
                if len(c.nodes) > 1
                else f"1 {c.called} ({self.label_word} {c.labels[0]})"
                for c in others
            )
            quads = sum(len(cells.nodes) for cells in self.cells if cells.kind == QUAD)
            raise InputError(
                f"{self.name} contains cells that are no elements of a blank: {found}, beside "
                f"{counted(quads, 'quadrilateral')}. Only quadrilaterals are needed, of four nodes each: without the "
                "others the blank would have holes. Mesh it with quadrilaterals only."
            )
        if not sum(len(cells.nodes) for cells in self.cells):
            raise InputError(f"{self.name} has no quadrilaterals; mesh the blank with quadrilaterals.")
        return np.concatenate([c.nodes for c in self.cells]), np.concatenate([c.labels for c in self.cells])

    def check_unit(self, unit_scale: float) -> None:
        """Check the metres per unit that a user gives, where the file says them too.

        Raises:
            InputError: they differ.
        """
        unit = self.metres_per_unit
        if unit is not None and abs(unit_scale - unit) > 1e-6 * unit:
            raise InputError(
                f"{self.name} says that its unit is {unit:g} m, but {unit_wish(unit_scale)} is given: give "
                f"{unit_wish(unit)}, or leave the unit out."
            )

    def _split(self, cells: Cells, notes: list[str]) -> np.ndarray:
        try:
            return _as_triangles(self.vertices, cells, notes)
        except Crossing as error:
            raise InputError(
                f"{self.name}: the outline of {self.label_word} {cells.labels[error.row]} ({cells.called}) crosses "
                "itself, so that it bounds no surface; order its corners along the outline."
            ) from None


def _as_triangles(vertices: np.ndarray, cells: Cells, notes: list[str]) -> np.ndarray:
    if cells.kind == TRIANGLE:
        return cells.nodes
    if cells.kind in SECOND_ORDER:
        return cells.nodes[:, _PIECES[cells.kind]].reshape(-1, 3)
    repeated, shorter = without_repeats(cells.nodes)
    parts = []
    if np.any(repeated):
        notes.append(f"{int(repeated.sum())} {cells.called} with a repeated corner taken with one corner less")
        for row, polygon in shorter:
            parts.append(_outline_triangles(vertices, polygon[None], np.array([row])))
    rows = np.flatnonzero(~repeated)
    parts.append(_outline_triangles(vertices, cells.nodes[rows], rows))
    if cells.kind == POLYGON and len(rows):
        bent = out_of_plane(vertices, cells.nodes[rows])
        if np.any(bent > FLAT):
            count = int(np.count_nonzero(bent > FLAT))
            notes.append(
                f"{count} {cells.called} are not flat, by up to {100.0 * bent.max():.2g} % "
                "of their size: the surface between their corners is a guess"
            )
    return np.concatenate(parts)


def _outline_triangles(vertices: np.ndarray, polygons: np.ndarray, rows: np.ndarray) -> np.ndarray:
    split = {3: lambda _, nodes: nodes, 4: quad_triangles}.get(polygons.shape[1], polygon_triangles)
    try:
        return split(vertices, polygons)
    except Crossing as error:
        raise Crossing(int(rows[error.row])) from None


# Triangles of a cell of second order: the corners cut off, and what is left in the middle.
_CORNERS_OF_TRIANGLE = ((0, 3, 5), (3, 1, 4), (5, 4, 2))
_CORNERS_OF_QUAD = ((0, 4, 7), (4, 1, 5), (5, 2, 6), (6, 3, 7))
_PIECES = {
    "triangle6": np.array([*_CORNERS_OF_TRIANGLE, (3, 4, 5)]),
    "triangle7": np.array([(0, 3, 6), (3, 1, 6), (1, 4, 6), (4, 2, 6), (2, 5, 6), (5, 0, 6)]),
    "quad8": np.array([*_CORNERS_OF_QUAD, (4, 5, 6), (4, 6, 7)]),
    "quad9": np.array([(0, 4, 8), (4, 1, 8), (1, 5, 8), (5, 2, 8), (2, 6, 8), (6, 3, 8), (3, 7, 8), (7, 0, 8)]),
}


def cells_by_corners(
    source: Source, polygons: Sequence[Sequence[int]], labels: Sequence[int], called: str = "face"
) -> tuple[Cells, ...]:
    """Cells from lists of corners, those with equally many together."""
    by_count: dict[int, list[int]] = {}
    for row, polygon in enumerate(polygons):
        by_count.setdefault(len(polygon), []).append(row)
    result = []
    for count, rows in sorted(by_count.items()):
        nodes = np.array([polygons[row] for row in rows], dtype=np.int64).reshape(len(rows), count)
        result.append(cells_of(source, nodes, np.array([labels[row] for row in rows]), called))
    return tuple(result)


def cells_of(source: Source, nodes: np.ndarray, labels: np.ndarray, called: str = "face") -> Cells:
    """Cells of equally many corners (m, k), named by their number of corners."""
    count = nodes.shape[1]
    if count < 3:
        raise source.error(f"{called} {labels[0]} has {count} corners", "at least three are needed")
    if count > MOST_CORNERS:
        raise source.error(f"{called} {labels[0]} has {count} corners; at most {MOST_CORNERS} are read")
    kind = {3: TRIANGLE, 4: QUAD}.get(count, POLYGON)
    name = {3: "triangles", 4: "quadrilaterals"}.get(count, f"polygons of {count} corners")
    return Cells(kind, name, nodes, labels)


def check_references(source: Source, nodes: np.ndarray, labels: np.ndarray, count: int, word: str) -> None:
    """Check that all rows of ``nodes`` (m, k) name one of ``count`` vertices.

    Raises:
        InputError: one does not.
    """
    wrong = np.any((nodes < 0) | (nodes >= count), axis=1)
    if np.any(wrong):
        raise source.error(
            f"{word} {labels[int(np.argmax(wrong))]} uses a vertex that is not there (there are {count}), and "
            f"so do {int(wrong.sum()) - 1} others"
        )


def check_finite(source: Source, vertices: np.ndarray) -> None:
    """Check that all vertices are finite numbers.

    Raises:
        InputError: one is not.
    """
    bad = np.flatnonzero(~np.all(np.isfinite(vertices), axis=1))
    if len(bad):
        raise source.error(f"{len(bad)} vertices are not finite, the first is number {bad[0] + 1}")
