"""What every format is written from: a shell mesh, and the plies on each of its elements."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ...errors import InputError
from ..stored.values import ElementValue

# Number of corners by kind of cell, as ``weavesim.meshes`` names kinds; further nodes lie between the corners.
CORNERS = {"triangle": 3, "quad": 4, "triangle6": 3, "quad8": 4}
# Of a node or an element that fits into eight columns.
LARGEST_LABEL = 99_999_999


@dataclass(frozen=True, eq=False)
class Cells:
    """Elements of one kind.

    Attributes:
        kind: one of ``CORNERS``.
        nodes: rows of the nodes, (m, k).
        labels: numbers of the elements, (m,).
    """

    kind: str
    nodes: np.ndarray
    labels: np.ndarray

    @property
    def corners(self) -> np.ndarray:
        """Their corner nodes, (m, 3) or (m, 4)."""
        return self.nodes[:, : CORNERS[self.kind]]


@dataclass(frozen=True, eq=False)
class ShellMesh:
    """Triangles and quadrilaterals.

    Attributes:
        nodes: (n, 3) [m].
        node_labels: numbers of the nodes, (n,).
        cells: one after the other they are the elements of all arrays over elements.
    """

    nodes: np.ndarray
    node_labels: np.ndarray
    cells: tuple[Cells, ...]

    @property
    def element_count(self) -> int:
        """Elements of all kinds."""
        return sum(len(cells.labels) for cells in self.cells)

    @cached_property
    def labels(self) -> np.ndarray:
        """Numbers of all elements, (element_count,)."""
        return np.concatenate([cells.labels for cells in self.cells])

    @cached_property
    def centres(self) -> np.ndarray:
        """Means of the corners, (element_count, 3) [m]."""
        return np.concatenate([self.nodes[cells.corners].mean(axis=1) for cells in self.cells])

    @cached_property
    def frames(self) -> np.ndarray:
        """Axes of each element as rows, (element_count, 3, 3): x from its first corner to the second, y, the normal.

        The normal is that of the diagonals, about which the corners run counter-clockwise; x is projected onto the
        plane across it.
        """
        frames = []
        for cells in self.cells:
            corner = self.nodes[cells.corners]
            normal = np.cross(corner[:, 2] - corner[:, 0], corner[:, -1] - corner[:, 1])
            if cells.corners.shape[1] == 3:
                normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
            normal /= np.linalg.norm(normal, axis=1, keepdims=True)
            along = across_normal(corner[:, 1] - corner[:, 0], normal)
            frames.append(np.stack([along, np.cross(normal, along), normal], axis=1))
        return np.concatenate(frames)


@dataclass(frozen=True, eq=False)
class Ply:
    """A ply of woven fabric on the elements of a mesh.

    Attributes:
        name: of its sheet.
        fabric: name of its fabric.
        warp, weft: unit directions in the planes of the elements, (element_count, 3).
        thickness: current, (element_count,) [m].
        initial_thickness: of the undeformed fabric [m].
        values: further values of the elements, by name.
        distance: from the element's centre to the formed sheet, (element_count,) [m]; zero on its own mesh.
    """

    name: str
    fabric: str
    warp: np.ndarray
    weft: np.ndarray
    thickness: np.ndarray
    initial_thickness: float
    values: dict[str, ElementValue] = field(default_factory=dict)
    distance: np.ndarray | None = None


@dataclass(frozen=True, eq=False)
class Layer:
    """The yarns of one direction in a ply, as structural codes take them: a layer of unidirectional material.

    Attributes:
        name: of the layer, unique in its part.
        ply: number of the ply, from 0 at the bottom.
        direction: unit fibre direction, (element_count, 3).
        angle: of the fibres in the frame of the element, (element_count,) [degrees], above -90 and up to 90.
        thickness: (element_count,) [m].
        initial_thickness: [m].
    """

    name: str
    ply: int
    direction: np.ndarray
    angle: np.ndarray
    thickness: np.ndarray
    initial_thickness: float


@dataclass(frozen=True, eq=False)
class Part:
    """A mesh with its plies.

    Attributes:
        name: of the part, for names of files and sets.
        mesh: its elements.
        plies: from the bottom to the top of each element, along its normal.
        layers_per_ply: 2 for a layer of each yarn, of half the thickness; 1 for a layer with axis 1 along the warp.
        notes: what a reader of the files must know.
    """

    name: str
    mesh: ShellMesh
    plies: tuple[Ply, ...]
    layers_per_ply: int = 2
    notes: tuple[str, ...] = ()

    @cached_property
    def layers(self) -> tuple[Layer, ...]:
        """Of all plies, from the bottom to the top."""
        return tuple(layer for number, ply in enumerate(self.plies) for layer in self._layers_of(number, ply))

    def _layers_of(self, number: int, ply: Ply) -> Iterator[Layer]:
        yarns = {"warp": ply.warp, "weft": ply.weft}
        if self.layers_per_ply == 1:
            del yarns["weft"]
        for yarn, direction in yarns.items():
            yield Layer(
                f"ply{number + 1}_{yarn}", number, direction, angle_in(self.mesh.frames, direction),
                ply.thickness / len(yarns), ply.initial_thickness / len(yarns),
            )  # fmt: skip


def across_normal(vectors: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Unit directions of ``vectors`` in the planes across unit normals, both (k, 3)."""
    flat = vectors - np.einsum("ei,ei->e", vectors, normal)[:, None] * normal
    return flat / np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), 1.0e-300)


def angle_in(frames: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """Angle of a line along ``direction`` in each frame, (k,) [degrees], above -90 and up to 90."""
    x, y = (np.einsum("ei,ei->e", frames[:, axis], direction) for axis in (0, 1))
    angle = np.rad2deg(np.arctan2(y, x))
    return 90.0 - np.mod(90.0 - angle, 180.0)


def check_columns(parts: Sequence[Part], code: str) -> None:
    """Check that the numbers of nodes and elements fit into the eight columns that decks of ``code`` have for them.

    Raises:
        InputError: a number that is too long.
    """
    for part in parts:
        if max(part.mesh.labels.max(), part.mesh.node_labels.max()) > LARGEST_LABEL:
            raise InputError(f"part {part.name}: {code} takes numbers up to {LARGEST_LABEL}; renumber the mesh")
