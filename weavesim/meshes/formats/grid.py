"""Nodes and elements by their numbers, and where an instance of them is placed."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..source import Source


@dataclass(frozen=True)
class Block:
    """Elements of one type: numbers (m,), node numbers (m, k), lines of the file (m,)."""

    kind: str
    name: str
    ids: np.ndarray
    nodes: np.ndarray
    lines: np.ndarray


@dataclass(frozen=True)
class Placement:
    """A translation, then a rotation by ``angle`` degrees about the axis through ``point``."""

    translation: np.ndarray = field(default_factory=lambda: np.zeros(3))
    point: np.ndarray = field(default_factory=lambda: np.zeros(3))
    axis: np.ndarray = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    angle: float = 0.0

    def of(self, position: np.ndarray) -> np.ndarray:
        """``position`` (n, 3) of the part, in the assembly."""
        moved = position + self.translation
        if self.angle == 0.0:
            return moved
        # Rodrigues' formula
        axis = self.axis / np.linalg.norm(self.axis)
        arm = moved - self.point
        sine, cosine = np.sin(np.deg2rad(self.angle)), np.cos(np.deg2rad(self.angle))
        along = np.outer(arm @ axis, axis)
        return self.point + along + cosine * (arm - along) + sine * np.cross(axis, arm)


@dataclass
class Grid:
    """Nodes and elements of one numbering, as they come: several blocks of either."""

    name: str
    nodes: list[tuple[np.ndarray, np.ndarray]] = field(default_factory=list)
    blocks: list[Block] = field(default_factory=list)

    def with_more(self, other: Grid) -> Grid:
        """This grid and what ``other`` has of it, under its own name."""
        return Grid(self.name, self.nodes + other.nodes, self.blocks + other.blocks)

    def resolved(self, source: Source, notes: list[str]) -> tuple[np.ndarray, np.ndarray, list[Block]]:
        """Numbers of the nodes in order, their positions, and blocks whose nodes are rows of these.

        Raises:
            InputError: a node with two positions, an element given twice, or one of a node that is not there.
        """
        if not self.nodes:
            if self.blocks:
                raise source.error(f"{self.name} has elements but no nodes")
            return np.empty(0, dtype=np.int64), np.empty((0, 3)), []
        ids = np.concatenate([ids for ids, _ in self.nodes])
        position = np.concatenate([position for _, position in self.nodes])
        order = np.argsort(ids, kind="stable")
        ids, position = ids[order], position[order]
        again = np.append(False, ids[1:] == ids[:-1])
        if np.any(again):
            moved = again & np.append(False, np.any(position[1:] != position[:-1], axis=1))
            if np.any(moved):
                raise source.error(
                    f"node {ids[int(np.argmax(moved))]} of {self.name} is given twice, at different places",
                    "number it anew",
                )
            notes.append(f"{int(again.sum())} nodes given twice at the same place taken once")
            ids, position = ids[~again], position[~again]
        blocks = self._once(source, notes)
        result = []
        for block in blocks:
            rows = np.searchsorted(ids, block.nodes).clip(max=len(ids) - 1)
            missing = ids[rows] != block.nodes
            if np.any(missing):
                element = int(np.argmax(np.any(missing, axis=1)))
                node = block.nodes[element][missing[element]][0]
                raise source.error(
                    f"line {block.lines[element]}: element {block.ids[element]} uses node {node} of {self.name}, which "
                    f"is not there ({int(np.any(missing, axis=1).sum())} elements do so)"
                )
            result.append(Block(block.kind, block.name, block.ids, rows, block.lines))
        return ids, position, result

    def _once(self, source: Source, notes: list[str]) -> list[Block]:
        """Blocks without elements that are repeated word for word."""
        if not self.blocks:
            return []
        ids = np.concatenate([block.ids for block in self.blocks])
        found, first, count = np.unique(ids, return_index=True, return_counts=True)
        if np.all(count == 1):
            return self.blocks
        rows = [(block.name, *nodes) for block in self.blocks for nodes in block.nodes.tolist()]
        keep = np.zeros(len(ids), dtype=bool)
        keep[first] = True
        first_of = dict(zip(found.tolist(), first.tolist(), strict=True))
        for row in np.flatnonzero(~keep):
            if rows[row] != rows[first_of[int(ids[row])]]:
                lines = np.concatenate([block.lines for block in self.blocks])
                raise source.error(
                    f"line {lines[row]}: element {ids[row]} of {self.name} is given twice, with different nodes",
                    "number it anew",
                )
        notes.append(f"{int((~keep).sum())} elements given twice with the same nodes taken once")
        result, position = [], 0
        for block in self.blocks:
            mask = keep[position : position + len(block.ids)]
            position += len(block.ids)
            result.append(Block(block.kind, block.name, block.ids[mask], block.nodes[mask], block.lines[mask]))
        return [block for block in result if len(block.ids)]
