"""Sheets that lie on each other."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...measures.findings import FormedSheet
from ..colours import DISTINCT_COLOURS
from .sheet import add_angle_bar, angle_colours, draw_view, yarn_lines
from .style import new_axes, new_figure, words

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_DIRECTION = (-58.0, 30.0)
# Between the sheets of the exploded view, over the height and the width of the part.
_GAP_TO_HEIGHT, _GAP_TO_WIDTH = 0.7, 0.25


def stack_picture(sheets: Sequence[tuple[str, FormedSheet]]) -> Figure:
    """Sheets moved apart, coloured by their shear angles, and as they lie, each in a colour of its own.

    Args:
        sheets: name and formed sheet of each, from the bottom to the top.
    """
    from matplotlib.colors import to_rgb
    from matplotlib.patches import Patch

    corners = [sheet.symmetry.mirrored(sheet.position[sheet.blank.quads]) for _, sheet in sheets]
    every = np.concatenate(corners).reshape(-1, 3)
    size = np.ptp(every, axis=0)
    gap = max(_GAP_TO_HEIGHT * size[2], _GAP_TO_WIDTH * size[:2].max())
    apart = [own + (0.0, 0.0, gap * level) for level, own in enumerate(corners)]
    lines = [
        sheet.symmetry.mirrored(yarn_lines(sheet.blank, sheet.symmetry)[1].of(sheet.position).reshape(-1, 2, 3))
        + (0.0, 0.0, gap * level)
        for level, (_, sheet) in enumerate(sheets)
    ]
    angles = [np.tile(sheet.shear_angle_deg, len(sheet.symmetry.mirror_factors)) for _, sheet in sheets]
    colours = [DISTINCT_COLOURS[level % len(DISTINCT_COLOURS)] for level in range(len(sheets))]

    figure = new_figure(13.0, min(5.0 + 0.9 * (len(sheets) - 1), 12.0))
    grid = figure.add_gridspec(1, 2, width_ratios=(1.2, 1.0))
    left = new_axes(figure, grid[0, 0], title=f"Moved apart by {1.0e3 * gap:.0f} mm")
    draw_view(left, _DIRECTION, np.concatenate(apart), np.concatenate(lines), angle_colours(np.concatenate(angles)))
    right = new_axes(figure, grid[0, 1], title="As they lie")
    own = [np.tile(to_rgb(colour), (len(part), 1)) for colour, part in zip(colours, corners, strict=True)]
    levels = np.repeat(np.arange(len(sheets)), [len(part) for part in corners])
    draw_view(right, _DIRECTION, np.concatenate(corners), np.zeros((0, 2, 3)), np.concatenate(own), levels)
    add_angle_bar(figure, [left], float(np.concatenate(angles).max()))
    patches = [Patch(color=colour) for colour in reversed(colours)]
    names = [words(name) for name, _ in reversed(sheets)]
    right.legend(patches, names, frameon=False, fontsize=9, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure
