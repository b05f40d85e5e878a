"""Sizes and motions of tools that hardly fit the blank: the likely slip is a unit."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Sequence

import numpy as np

from ..input_files import unit_wish
from ..process.motions.paths import PathMotion
from ..sheet.sheet import Sheet
from ..sheet.symmetry import Symmetry
from .shapes import Plane, Shape
from .tool import Tool

logger = logging.getLogger(__name__)

# Largest size of a tool over that of the blank: its usual range. An inch read as a metre makes it 39 times as large,
# an inch read as a millimetre 25 times as small.
USUAL_SIZE_RATIO = (0.06, 10.5)
# A tool of such a size may well be far larger or smaller than the blank, as a patch on a mould or a pin under a sheet
# are: it is a warning, not a question [m].
USUAL_SIZE = (0.02, 4.0)
# Longest travel of a tool over the size of the blank.
USUAL_TRAVEL = 4.0


def disproportionate_tools(sheet: Sheet, tools: Sequence[Tool], symmetry: Symmetry) -> Iterator[str]:
    """Sentences on tools whose size or travel hardly fits a sheet, of which ``symmetry`` may cut off a part."""
    blank = float(np.ptp(symmetry.mirrored(sheet.blank.node_position), axis=0).max())
    for tool in tools:
        size = tool_size(tool.shape)
        if size is not None:
            ratio = size / blank
            low, high = USUAL_SIZE_RATIO
            if not low <= ratio <= high:
                times = f"{ratio:.3g} times as large" if ratio > 1.0 else f"{1.0 / ratio:.3g} times as small"
                sentence = (
                    f"tool {tool.name} is {size:.4g} m across, {times} as the blank of sheet {sheet.name}, "
                    f"{blank:.4g} m; usual are {low:g} to {high:g} times: check both units "
                    f"(mm, inch; {unit_wish(1.0e-3)} for millimetres)"
                )
                if USUAL_SIZE[0] <= size <= USUAL_SIZE[1]:
                    logger.warning("%s", sentence)
                else:
                    yield sentence
        travel = 0.0 if tool.motion.by_force else float(np.ptp(np.append(tool.motion.curve()[1], 0.0)))
        if isinstance(tool.motion, PathMotion) and tool.motion.points:
            travel += float(np.linalg.norm(tool.motion.points, axis=1).max())
        if travel > USUAL_TRAVEL * blank:
            yield (
                f"tool {tool.name} travels {travel:.4g} m, {travel / blank:.3g} times the size of the blank of sheet "
                f"{sheet.name}, {blank:.4g} m; usual are up to {USUAL_TRAVEL:g} times: check the units (mm)"
            )


def tool_size(shape: Shape) -> float | None:
    """Longest side of the box around a shape [m]; None if it has no size, as a plane."""
    parts = shape.parts()
    if any(isinstance(part, Plane) for part in parts):
        return None
    corners = np.concatenate([part.display_triangles()[0] for part in parts])
    return float(np.ptp(corners, axis=0).max())
