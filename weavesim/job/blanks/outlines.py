"""Outlines of plies from files: DXF drawings, and the border of triangle meshes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...errors import InputError
from ...meshes.drawing import JOINED, joined, read_lines
from ...meshes.mesh_file import MeshFile
from ...sheet.outline import Outline

# Corners that turn by less are left out [rad].
STRAIGHT = 1.0e-7


class Loops(NamedTuple):
    """What bounds a ply, in metres.

    Attributes:
        outline: corners in order, (k, 2).
        holes: corners of each, (k, 2).
        slits: points of each, (k, 2).
        notes: what was joined or left out.
    """

    outline: np.ndarray
    holes: tuple[np.ndarray, ...] = ()
    slits: tuple[np.ndarray, ...] = ()
    notes: tuple[str, ...] = ()


def read_drawing(path: Path, *, layer: str | None = None, metres_per_unit: float | None = None) -> Loops:
    """The outline, holes and slits of a DXF drawing: the largest closed line, closed ones inside it, and open ones.

    Args:
        path: of the drawing.
        layer: whose lines are taken; None takes all.
        metres_per_unit: of the drawing; None takes what its header says.

    Raises:
        InputError: a drawing that cannot be read, has no unit, or no closed outline.
    """
    drawing = read_lines(path, layer=layer, metres_per_unit=metres_per_unit)
    for line in drawing.lines:
        if np.ptp(line[:, 2]) > 1e-6 * max(float(np.ptp(line, axis=0).max()), 1e-300):
            x, y, z = 1e3 * line[0]
            raise InputError(
                f"{drawing.name}: the line from ({x:.4g}, {y:.4g}, {z:.4g}) mm does not lie in a plane z; a flat "
                "outline is needed"
            )
    return _loops(drawing.name, [line[:, :2] for line in drawing.lines], list(drawing.notes))


def border_of(mesh: MeshFile, faces: np.ndarray, metres_per_unit: float) -> Loops:
    """The border of a flat triangle mesh.

    Raises:
        InputError: a mesh that is not flat, or has several parts.
    """
    vertices = metres_per_unit * mesh.vertices
    used = vertices[np.unique(faces)]
    size = float(np.ptp(used, axis=0).max())
    if np.ptp(used[:, 2]) > 1e-6 * size:
        raise InputError(
            f"{mesh.name}: a mesh of triangles gives only the outline of a ply, and must lie in a plane z; its heights "
            f"differ by {1e3 * np.ptp(used[:, 2]):.4g} mm"
        )
    edges = np.concatenate([faces[:, [k, (k + 1) % 3]] for k in range(3)])
    _, first, count = np.unique(np.sort(edges, axis=1), axis=0, return_index=True, return_counts=True)
    pieces = [vertices[edge, :2] for edge in edges[first[count == 1]]]
    return _loops(mesh.name, pieces, [f"{mesh.name}: its triangles give the outline, which is meshed anew"])


def _loops(name: str, pieces: Sequence[np.ndarray], notes: list[str]) -> Loops:
    """Closed and open lines, joined from pieces, as outline, holes and slits."""
    if not pieces:
        raise InputError(f"{name}: it has no lines")
    size = float(np.ptp(np.concatenate(pieces), axis=0).max())
    closed, opened = [], []
    pieces, again = _each_once(pieces, JOINED * size)
    for line in joined(pieces, JOINED * size):
        if len(line) > 3 and np.linalg.norm(line[0] - line[-1]) <= JOINED * size:
            closed.append(_without_straight(line[:-1]))
        elif len(line) > 1:
            opened.append(line)
    closed = [loop for loop in closed if abs(_area(loop)) > (JOINED * size) ** 2]
    if not closed:
        gap = min(opened, key=lambda line: float(np.linalg.norm(line[0] - line[-1])))
        x, y = 1e3 * gap[-1]
        raise InputError(
            f"{name}: no line is closed; the nearest ends are {1e3 * np.linalg.norm(gap[0] - gap[-1]):.4g} mm apart, "
            f"at ({x:.4g}, {y:.4g}) mm"
        )
    closed.sort(key=lambda loop: -abs(_area(loop)))
    single: list[np.ndarray] = []
    for loop in closed:
        if not any(_same(loop, each, 10.0 * JOINED * size) for each in single):
            single.append(loop)
    again += len(closed) - len(single)
    closed = single
    if again:
        notes = [*notes, f"{name}: {again} lines that are drawn twice left out"]
    outline, *holes = closed
    for loop in holes:
        if not _inside(loop, outline).all():
            x, y = 1e3 * loop.mean(axis=0)
            raise InputError(
                f"{name}: it has several outlines, another one about ({x:.4g}, {y:.4g}) mm; put each ply on a layer of "
                "its own, and name it with layer"
            )
    for line in opened:
        if not _inside(line, outline, slack=1e-3 * size).all():
            x, y = 1e3 * line[0]
            raise InputError(f"{name}: an open line at ({x:.4g}, {y:.4g}) mm leads out of the outline")
    return Loops(outline, tuple(holes), tuple(opened), tuple(notes))


def _each_once(pieces: Sequence[np.ndarray], tolerance: float) -> tuple[list[np.ndarray], int]:
    """Pieces (k, 2) without those that are drawn again, in either sense, and how many these are."""
    found: dict[bytes, np.ndarray] = {}
    for piece in pieces:
        ways = (np.round(way / (10.0 * tolerance)).astype(np.int64).tobytes() for way in (piece, piece[::-1]))
        found.setdefault(min(ways), piece)
    return list(found.values()), len(pieces) - len(found)


def _same(loop: np.ndarray, other: np.ndarray, tolerance: float) -> bool:
    """Whether two closed lines (k, 2) have the same corners, wherever they begin."""
    if abs(abs(_area(loop)) - abs(_area(other))) > tolerance * float(np.ptp(loop, axis=0).sum()):
        return False
    apart = np.linalg.norm(loop[:, None] - other[None], axis=2) if len(loop) * len(other) < 1e7 else None
    if apart is None:
        return bool(np.allclose(loop.mean(axis=0), other.mean(axis=0), atol=tolerance))
    return bool(apart.min(axis=0).max() <= tolerance and apart.min(axis=1).max() <= tolerance)


def _without_straight(loop: np.ndarray) -> np.ndarray:
    """Corners at which a closed line turns, each once."""
    step = np.linalg.norm(np.roll(loop, -1, axis=0) - loop, axis=1)
    loop = loop[step > 1e-9 * float(np.ptp(loop, axis=0).max())]
    if len(loop) < 4:
        return loop
    a, b = loop - np.roll(loop, 1, axis=0), np.roll(loop, -1, axis=0) - loop
    turn = np.arctan2(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], (a * b).sum(axis=1))
    return loop[np.abs(turn) > STRAIGHT]


def _area(loop: np.ndarray) -> float:
    x, y = loop.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


def _inside(points: np.ndarray, loop: np.ndarray, slack: float = 0.0) -> np.ndarray:
    """Whether points (n, 2) lie inside a closed line, or within ``slack`` of it, (n,) bool."""
    return Outline(loop).nearest(points)[0] >= -slack
