"""Lines of DXF drawings, in metres, joined where their ends meet."""

from __future__ import annotations

import logging
import math
from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..errors import InputError
from ..input_files import MEBIBYTE, check_bounded, shown

# It quotes damaged files in warnings, which would end on the terminal unless somebody asks for them.
logging.getLogger("ezdxf").addHandler(logging.NullHandler())

LARGEST_DRAWING = 64 * MEBIBYTE
# Curves are drawn by lines this near to them [m].
FLATNESS = 2.0e-5
# No blank has more entities and points than these, nor an entity that is larger [m]: a curve of it would never end.
MOST_ENTITIES, MOST_POINTS = 100_000, 5_000_000
LARGEST_SIZE = 1.0e3
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
        layer: whose lines are taken; None takes those of all layers that are neither off nor frozen.
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
        entities = list(islice(recursive_decompose(drawing.modelspace()), MOST_ENTITIES + 1))
        layers = sorted({str(entity.dxf.layer) for entity in entities})
        code = int(drawing.header.get("$INSUNITS", 0))
        hidden = {str(each.dxf.name) for each in drawing.layers if each.is_off() or each.is_frozen()}
    except Exception as error:  # whatever a damaged file makes of it
        reason = "it needs too much memory" if isinstance(error, MemoryError) else shown(type(error).__name__)
        raise InputError(
            f"{name}: no DXF drawing that can be read ({reason}); export it again, as DXF of the release 2010 or later"
        ) from None
    if len(entities) > MOST_ENTITIES:
        raise InputError(f"{name}: it has more than {MOST_ENTITIES:,} entities; export the outlines of the blanks only")
    scale = _unit(name, code, metres_per_unit)
    if layer is not None and layer not in layers:
        raise InputError(f"layer = {layer!r}: {name} has no such layer; it has {', '.join(map(shown, layers))}")
    lines: list[np.ndarray] = []
    left_out: dict[str, int] = {}
    unseen: dict[str, int] = {}
    point_count = 0
    for entity in entities:
        if layer is not None and entity.dxf.layer != layer:
            continue
        if layer is None and str(entity.dxf.layer) in hidden:
            unseen[str(entity.dxf.layer)] = unseen.get(str(entity.dxf.layer), 0) + 1
            continue
        try:
            points = _points(name, make_path(entity), scale)
        except InputError:
            raise
        except Exception:  # no path, or damaged values
            left_out[entity.dxftype()] = left_out.get(entity.dxftype(), 0) + 1
            continue
        point_count += len(points)
        if point_count > MOST_POINTS:
            raise InputError(f"{name}: its curves have more than {MOST_POINTS:,} points; export the outlines only")
        if len(points) > 1:
            lines.append(points)
    notes = (f"{Path(path).name}: {count} {kind} left out: no lines" for kind, count in sorted(left_out.items()))
    off = (
        f"{Path(path).name}: {count} on layer {shown(each)} left out: it is off or frozen; name it with "
        "layer to take it"
        for each, count in sorted(unseen.items())
    )
    return Drawing(name, tuple(lines), (*notes, *off))


def _points(name: str, path: Any, scale: float) -> np.ndarray:
    """Points of a path of ezdxf, (k, 3) [m].

    Raises:
        InputError: coordinates that are not finite, or farther apart than any blank's.
    """
    control = scale * np.array([(p.x, p.y, p.z) for p in path.control_vertices()], dtype=float).reshape(-1, 3)
    if not np.isfinite(control).all():
        raise InputError(f"{name}: a line has coordinates that are not finite; export it again")
    if len(control) and np.abs(control).max() > LARGEST_SIZE:
        raise InputError(
            f"{name}: a line lies {np.abs(control).max():.3g} m from the origin, more than {LARGEST_SIZE:g} m; check "
            "its unit, or move the drawing to the origin"
        )
    points = np.array([(p.x, p.y, p.z) for p in islice(path.flattening(FLATNESS / scale), MOST_POINTS + 1)])
    if not np.isfinite(points).all():
        raise InputError(f"{name}: a line has coordinates that are not finite; export it again")
    return scale * points


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
