"""Flat patterns as DXF drawings, in millimetres, a ply on layers of its own."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...errors import InputError
from ..files import replacing
from .trimming import FlatPattern

if TYPE_CHECKING:
    from ezdxf.document import Drawing

# Length of a yarn's arrow over the smaller side of the pattern, of its head over the arrow, and of letters over it.
ARROW, HEAD, LETTER = 0.2, 0.15, 0.12
# Height of a letter of a line that spans some of the pattern, over its width and per letter.
TEXT_WIDTH = 0.8
# AutoCAD's colours of blank, trim line, yarns and text.
BLANK, TRIM, YARNS, TEXT = 7, 1, 5, 8


def flat_drawing(patterns: Sequence[FlatPattern]) -> Drawing:
    """Each blank on the layer of its name; its trim line, yarns and text on further ones."""
    document = _new()
    for pattern in patterns:
        layer = layer_name(pattern.name)
        _add(document, layer, BLANK, pattern.blank, pattern.slits)
        if pattern.trim is not None:
            _add(document, f"{layer}_trim", TRIM, pattern.trim)
        _mark(document, pattern, layer)
    return document


def trimmed_drawing(patterns: Sequence[FlatPattern]) -> Drawing:
    """What becomes the part, each ply on the layer of its name: an `outline` of a job."""
    document = _new()
    for pattern in patterns:
        layer = layer_name(pattern.name)
        _add(document, layer, TRIM, pattern.cut, pattern.cut_slits)
        _mark(document, pattern, layer)
    return document


def write_drawing(path: Path, document: Drawing) -> None:
    """Write a drawing whole or not at all."""
    with replacing(path) as temporary:
        document.saveas(temporary)


def layer_name(name: str) -> str:
    """A name that DXF takes for a layer."""
    return re.sub(r"""[<>/\\":;?*|='`,\x00-\x1f]+""", "_", name).strip() or "ply"


def _new() -> Drawing:
    try:
        import ezdxf
    except ImportError:
        raise InputError("drawing: DXF needs the package ezdxf; install it with pip install 'weavesim[dxf]'") from None
    return ezdxf.new("R2010", units=4)


def _add(
    document: Drawing, layer: str, colour: int, closed: Iterable[np.ndarray], opened: Iterable[np.ndarray] = ()
) -> None:
    _layer(document, layer, colour)
    space: Any = document.modelspace()
    for lines, close in ((closed, True), (opened, False)):
        for line in lines:
            space.add_lwpolyline(_millimetres(line), close=close, dxfattribs={"layer": layer})


def _layer(document: Drawing, layer: str, colour: int) -> None:
    if layer not in document.layers:
        document.layers.add(layer, color=colour)


def _mark(document: Drawing, pattern: FlatPattern, layer: str) -> None:
    """Arrows along warp and weft, and what the pattern is, in its middle."""
    space: Any = document.modelspace()
    outline = pattern.cut[0]
    middle, length = outline.mean(axis=0), ARROW * float(np.ptp(outline, axis=0).min())
    for name, along in (("warp", pattern.warp), ("weft", pattern.weft)):
        on = {"layer": f"{layer}_yarns"}
        _layer(document, on["layer"], YARNS)
        across, end = np.array([-along[1], along[0]]), middle + length * along
        back = end - HEAD * length * along
        space.add_line(*_millimetres(np.array([middle, end])), dxfattribs=on)
        for side in (1.0, -1.0):
            space.add_line(*_millimetres(np.array([end, back + side * 0.5 * HEAD * length * across])), dxfattribs=on)
        _write(space, name, end, LETTER * length, on["layer"])
    on_text = f"{layer}_text"
    _layer(document, on_text, TEXT)
    text = f"{pattern.name}: {1e4 * pattern.blank_area:.1f} cm2 of fabric"
    if pattern.part_area is not None:
        text = f"{pattern.name}: {1e4 * pattern.part_area:.1f} of {1e4 * pattern.blank_area:.1f} cm2 become the part"
    height = min(LETTER * length, TEXT_WIDTH * float(np.ptp(outline[:, 0])) / len(text))
    _write(space, text, middle - np.array([0.0, 0.5 * length]), height, on_text, centred=True)


def _write(space: Any, text: str, place: np.ndarray, height: float, layer: str, *, centred: bool = False) -> None:
    from ezdxf.enums import TextEntityAlignment

    entity = space.add_text(text, height=1e3 * height, dxfattribs={"layer": layer})
    align = TextEntityAlignment.MIDDLE_CENTER if centred else TextEntityAlignment.LEFT
    entity.set_placement(tuple((1e3 * place).tolist()), align=align)


def _millimetres(line: np.ndarray) -> list[tuple[float, ...]]:
    return [tuple(round(1e3 * value, 6) for value in point) for point in line.tolist()]
