"""Lines of DXF drawings, in metres, joined where their ends meet."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..errors import InputError
from ..input_files import MEBIBYTE, check_bounded, shown

LARGEST_DRAWING = 64 * MEBIBYTE
# Curves are drawn by lines this near to them [m].
FLATNESS = 2.0e-5
# Ends of lines this near to each other are joined, over the size of the drawing.
JOINED = 1.0e-5
# Codes of the unit in a drawing's header, and metres per unit.
DXF_UNITS = {1: 0.0254, 2: 0.3048, 4: 1e-3, 5: 1e-2, 6: 1.0, 13: 1e-6, 14: 0.1}


class Drawing(NamedTuple):
    """The lines of a drawing.

    Attributes:
        name: of the file, for messages.
        lines: points of each line, (k, 3) [m]; curves as straight pieces.
        notes: what was left out.
    """

    name: str
    lines: tuple[np.ndarray, ...]
    notes: tuple[str, ...]


def read_lines(path: Path, *, layer: str | None = None, metres_per_unit: float | None = None) -> Drawing:
    """Every line of a DXF drawing, also in blocks.

    Args:
        path: of the drawing.
        layer: whose lines are taken; None takes all.
        metres_per_unit: of the drawing; None takes what its header says.

    Raises:
        InputError: a drawing that cannot be read, has no such layer, or no unit.
    """
    name = f"drawing {shown(path)}"
    try:
        import ezdxf
        from ezdxf.disassemble import recursive_decompose
        from ezdxf.path import make_path
    except ImportError:
        raise InputError(f"{name}: DXF needs the package ezdxf; install it with pip install 'weavesim[dxf]'") from None
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
    lines: list[np.ndarray] = []
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
        lines.append(scale * points)
    notes = (f"{Path(path).name}: {count} {kind} left out: no lines" for kind, count in sorted(left_out.items()))
    return Drawing(name, tuple(lines), tuple(notes))


def _unit(name: str, code: int, given: float | None) -> float:
    said = DXF_UNITS.get(code)
    if given is None:
        if said is None:
            raise InputError(f"unit: is required, since {name} does not say its unit: mm, inch, ...")
        return said
    if said is not None and not math.isclose(said, given):
        raise InputError(f"unit: {name} says that its unit is {said:g} m, but {given:g} m is given; leave unit out")
    return given


def joined(pieces: Sequence[np.ndarray], tolerance: float) -> Iterator[np.ndarray]:
    """Lines made of pieces (k, 2 or 3) whose ends coincide, where no third piece ends."""
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
