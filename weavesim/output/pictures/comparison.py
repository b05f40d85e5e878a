"""Differences of a formed sheet to another one, or to a scan."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .net import add_bar
from .style import colour_map, new_axes, new_figure
from .surface import OBLIQUE, draw_elements, scaled_colours, signed_colours

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..comparison.runs import Comparison


def comparison_picture(comparison: Comparison) -> Figure:
    """Distances, and beside another run the differences of the shear angle."""
    sheet, pair = comparison.sheet, comparison.values.get("shear_angle_deg")
    columns = 1 if pair is None else 2
    figure = new_figure(7.0 * columns, 5.4)
    distance = 1.0e3 * comparison.distance[sheet.blank.quads].mean(axis=1)
    largest = float(np.nanmax(distance, initial=1.0e-3))
    axes = new_axes(figure, 1, columns, 1, title=f"Distance to {comparison.other}")
    draw_elements(axes, sheet.formed, scaled_colours(distance, largest), OBLIQUE)
    add_bar(figure, [axes], "Distance [mm]; grey where there is nothing to compare", colour_map(), 0.0, largest)
    if pair is not None:
        difference = pair[0] - pair[1]
        largest = float(np.nanmax(np.abs(difference), initial=1.0e-3))
        axes = new_axes(figure, 1, columns, 2, title="Shear angle less that of the other")
        draw_elements(axes, sheet.formed, signed_colours(difference, largest), OBLIQUE)
        add_bar(figure, [axes], "Difference [degrees]", "coolwarm", -largest, largest)
    return figure
