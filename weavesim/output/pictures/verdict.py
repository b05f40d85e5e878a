"""Where a part is beyond its limits."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...measures.defects.judgement import Judgement
from .style import INK, new_axes, new_figure
from .surface import GREY, OBLIQUE, PLAN, draw_elements

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLOURS = {"wrinkle": "#d1495b", "bridging": "#edae49", "locking": "#5b3fb5", "gap": "#2b8a9c"}


def verdict_picture(names: Sequence[str], judged: Sequence[Judgement]) -> Figure:
    """Every sheet, grey, with its regions in the colours of their kinds."""
    from matplotlib.colors import to_rgba
    from matplotlib.patches import Patch

    figure = new_figure(13.0, 5.0 * len(judged))
    for row, (name, judgement) in enumerate(zip(names, judged, strict=True)):
        colours = np.tile(np.array(GREY), (judgement.sheet.blank.element_count, 1))
        for region in reversed(judgement.regions):
            colours[region.elements] = to_rgba(COLOURS[region.kind])
        count = len(judgement.regions)
        text = "within all limits" if not count else f"{count} region{'s' * (count > 1)} beyond a limit"
        for column, (direction, title) in enumerate(((OBLIQUE, f"{name}: {text}"), (PLAN, "From above"))):
            axes = new_axes(figure, len(judged), 2, 2 * row + column + 1, title=title)
            draw_elements(axes, judgement.sheet, colours, direction)
    kinds = [kind for kind in COLOURS if any(region.kind == kind for sheet in judged for region in sheet.regions)]
    if kinds:
        handles = [Patch(color=COLOURS[kind], label=kind) for kind in kinds]
        figure.legend(handles=handles, loc="outside lower center", ncols=len(kinds), frameon=False, labelcolor=INK)
    return figure
