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

COLOURS = {
    "wrinkle": "#d1495b",
    "bridging": "#edae49",
    "locking": "#5b3fb5",
    "gap": "#2b8a9c",
    "self-contact": "#1d1d2b",
}


def verdict_picture(names: Sequence[str], judged: Sequence[Judgement]) -> Figure:
    """Sheets, grey, with their regions in the colours of their kinds; of several, those that have regions.

    Args:
        names: of the sheets.
        judged: the same sheets.
    """
    from matplotlib.colors import to_rgba
    from matplotlib.patches import Patch

    beyond = [pair for pair in zip(names, judged, strict=True) if pair[1].regions]
    shown = beyond or list(zip(names, judged, strict=True))[:1]
    figure = new_figure(13.0, 5.0 * len(shown))
    if fine := [name for name in names if name not in [other for other, _ in shown]]:
        figure.suptitle(f"Within all limits: {', '.join(fine)}", x=0.01, ha="left", fontsize=10, color=INK)
    for row, (name, judgement) in enumerate(shown):
        colours = np.tile(np.array(GREY), (judgement.sheet.blank.element_count, 1))
        for region in reversed(judgement.regions):
            colours[region.elements] = to_rgba(COLOURS[region.kind])
        count = len(judgement.regions)
        text = "within all limits" if not count else f"{count} region{'s' * (count > 1)} beyond a limit"
        for column, (direction, title) in enumerate(((OBLIQUE, f"{name}: {text}"), (PLAN, "From above"))):
            axes = new_axes(figure, len(shown), 2, 2 * row + column + 1, title=title)
            draw_elements(axes, judgement.sheet, colours, direction)
    kinds = [kind for kind in COLOURS if any(region.kind == kind for sheet in judged for region in sheet.regions)]
    if kinds:
        handles = [Patch(color=COLOURS[kind], label=kind) for kind in kinds]
        figure.legend(handles=handles, loc="outside lower center", ncols=len(kinds), frameon=False, labelcolor=INK)
    return figure
