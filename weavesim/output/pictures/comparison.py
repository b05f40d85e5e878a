"""Differences of a formed sheet to another one, to a scan, or to measured points."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..comparison.fields import titled
from .net import add_bar
from .style import ACCENT, FAINT, INK, colour_map, new_axes, new_figure
from .surface import GREY, OBLIQUE, PLAN, draw_elements, scaled_colours, signed_colours, view

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..comparison.points import PointComparison
    from ..comparison.runs import Comparison

# Fields that are drawn; all are in the table.
LARGEST_COUNT = 4


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


def points_picture(comparison: PointComparison) -> Figure:
    """Above, each difference at its place, seen from above; below, measured against computed."""
    drawn = list(comparison.differences())[:LARGEST_COUNT]
    if not drawn:
        drawn = [("", np.full(len(comparison.flat), np.nan))]
    rows = 2 if comparison.values else 1
    figure = new_figure(6.6 * len(drawn), 5.0 * rows)
    for column, (name, difference) in enumerate(drawn, start=1):
        signed = name in comparison.values
        axes = new_axes(figure, rows, len(drawn), column, title=_title(name, signed))
        sheet = comparison.sheet
        colours = np.tile(np.array(GREY), (sheet.blank.element_count, 1))
        draw_elements(axes, sheet.formed, colours, PLAN)
        _, screen = view(PLAN)
        known = np.isfinite(difference)
        largest = float(np.abs(difference[known]).max(initial=1.0e-12))
        x, y = (comparison.position[known] @ screen).T
        low, palette = (-largest, "coolwarm") if signed else (0.0, colour_map())
        axes.scatter(
            x, y, c=difference[known], cmap=palette, vmin=low, vmax=largest, s=26, zorder=3, edgecolors=INK,
            linewidths=0.4,
        )  # fmt: skip
        add_bar(figure, [axes], _title(name, signed), palette, low, largest)
        if signed:
            _against(figure, comparison, name, (rows, len(drawn), len(drawn) + column))
    return figure


def _title(name: str, signed: bool) -> str:
    text, _, unit = titled(name).partition(" [")
    return f"{text.capitalize()}{', computed less measured' if signed else ''}{f' [{unit}' if unit else ''}"


def _against(figure: Figure, comparison: PointComparison, name: str, place: tuple[int, int, int]) -> None:
    own, measured = comparison.values[name]
    known = np.isfinite(own) & np.isfinite(measured)
    axes = new_axes(figure, *place, title=f"{_title(name, False)}: {int(known.sum())} points")
    axes.scatter(measured[known], own[known], s=22, color=ACCENT)
    both = np.concatenate([measured[known], own[known]])
    if len(both):
        axes.plot([both.min(), both.max()], [both.min(), both.max()], color=FAINT, linewidth=1.0)
    axes.set(xlabel="measured", ylabel="computed")
    axes.set_aspect("equal", adjustable="datalim")
