"""Outlines of plies from files: DXF drawings, and the border of triangle meshes."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...errors import InputError
from ...input_files import MEBIBYTE, check_bounded, shown
from ...meshes.mesh_file import MeshFile
from ...sheet.outline import Outline

LARGEST_DRAWING = 64 * MEBIBYTE
# Curves are drawn by lines this near to them [m].
FLATNESS = 2.0e-5
# Ends of lines this near to each other are joined, over the size of the drawing.
JOINED = 1.0e-5
# Corners that turn by less are left out [rad].
STRAIGHT = 1.0e-7
# Codes of the unit in a drawing's header, and metres per unit.
DXF_UNITS = {1: 0.0254, 2: 0.3048, 4: 1e-3, 5: 1e-2, 6: 1.0, 13: 1e-6, 14: 0.1}


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
    try:
        import ezdxf
        from ezdxf.disassemble import recursive_decompose
        from ezdxf.path import make_path
    except ImportError:
        raise InputError(
            f"drawing {shown(path)}: DXF needs the package ezdxf; install it with pip install 'weavesim[dxf]'"
        ) from None
    name = f"drawing {shown(path)}"
    check_bounded(path, "drawing", LARGEST_DRAWING)
    try:
        drawing = ezdxf.readfile(path)
    except (OSError, ValueError, KeyError, IndexError, UnicodeError, ezdxf.DXFError) as error:
        raise InputError(f"{name}: no DXF drawing that can be read ({shown(type(error).__name__)})") from None
    scale = _unit(name, int(drawing.header.get("$INSUNITS", 0)), metres_per_unit)
    entities = list(recursive_decompose(drawing.modelspace()))
    layers = sorted({str(entity.dxf.layer) for entity in entities})
    if layer is not None and layer not in layers:
        raise InputError(f"layer = {layer!r}: {name} has no such layer; it has {', '.join(map(shown, layers))}")
    pieces: list[np.ndarray] = []
    left_out: dict[str, int] = {}
    for entity in entities:
        if layer is not None and entity.dxf.layer != layer:
            continue
        try:
            points = np.array([(p.x, p.y, p.z) for p in make_path(entity).flattening(FLATNESS / scale)])
        except (TypeError, ValueError, ezdxf.DXFError):
            left_out[entity.dxftype()] = left_out.get(entity.dxftype(), 0) + 1
            continue
        if len(points) < 2:
            continue
        if not np.isfinite(points).all():
            raise InputError(f"{name}: {entity.dxftype()} has coordinates that are not finite")
        if np.ptp(points[:, 2]) > 1e-6 * max(float(np.ptp(points, axis=0).max()), 1e-300):
            raise InputError(f"{name}: {entity.dxftype()} does not lie in a plane z; a flat outline is needed")
        pieces.append(scale * points[:, :2])
    notes = [f"{path.name}: {count} {kind} left out: no lines" for kind, count in sorted(left_out.items())]
    return _loops(name, pieces, notes)


def _unit(name: str, code: int, given: float | None) -> float:
    said = DXF_UNITS.get(code)
    if given is None:
        if said is None:
            raise InputError(f"unit: is required, since {name} does not say its unit: mm, inch, ...")
        return said
    if said is not None and not math.isclose(said, given):
        raise InputError(f"unit: {name} says that its unit is {said:g} m, but {given:g} m is given; leave unit out")
    return given


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
    for line in _joined(pieces, JOINED * size):
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


def _joined(pieces: Sequence[np.ndarray], tolerance: float) -> Iterator[np.ndarray]:
    """Lines made of pieces whose ends coincide, where no third piece ends."""
    from scipy.spatial import cKDTree

    closed = [piece for piece in pieces if np.linalg.norm(piece[0] - piece[-1]) <= tolerance and len(piece) > 2]
    yield from closed
    rest = [piece for piece in pieces if np.linalg.norm(piece[0] - piece[-1]) > tolerance]
    if not rest:
        return
    ends = np.concatenate([[piece[0], piece[-1]] for piece in rest])
    near = cKDTree(ends).query_ball_point(ends, tolerance)
    partner = {k: next(j for j in found if j != k) for k, found in enumerate(near) if len(found) == 2}
    done: set[int] = set()
    # those that begin at a free end first
    for start in sorted(range(len(ends)), key=lambda k: k in partner):
        if start // 2 in done:
            continue
        line, end = [], start
        while end // 2 not in done:
            piece = rest[end // 2]
            done.add(end // 2)
            line.append(piece if end % 2 == 0 else piece[::-1])
            other = end ^ 1
            if other not in partner:
                break
            end = partner[other]
        yield np.concatenate([line[0], *(part[1:] for part in line[1:])])


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
