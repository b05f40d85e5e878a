"""Shear angles at material points."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ...measures.findings import FormedSheet
from .sheet import add_angle_bar, angle_colours
from .style import ACCENT, INK, MEASURED, add_legend, new_axes, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def point_angles(sheet: FormedSheet, measured_angles: tuple[np.ndarray, np.ndarray] | None = None) -> Figure:
    """Shear angle at the material points of the sheet, at least one, and their positions on the flat blank."""
    figure = new_figure(12.0, 5.0)
    grid = figure.add_gridspec(1, 2, width_ratios=(1.3, 1.0))
    _draw_bars(figure, grid[0, 0], sheet.point_angles_deg, measured_angles)
    _draw_points(figure, grid[0, 1], sheet)
    return figure


def _draw_bars(
    figure: Figure, place: Any, angles: np.ndarray, measured_angles: tuple[np.ndarray, np.ndarray] | None
) -> None:
    """Computed angles as bars, measured ones next to them."""
    number = np.arange(1, len(angles) + 1)
    chart = new_axes(figure, place, title=f"Shear angle at the {len(angles)} points", xlabel="point")
    chart.set(ylabel="shear angle [degrees]", xticks=number)
    chart.bar(number, angles, width=0.62, color="#d9d0f3", edgecolor=ACCENT, linewidth=1.2, label="computed")
    highest = float(angles.max(initial=1.0))
    if measured_angles is not None:
        chart.plot(*measured_angles, "D", color=MEASURED, markersize=6, label="measured")
        highest = max(highest, float(measured_angles[1].max()))
        add_legend(chart, loc="upper left")
    measured = dict(zip(*measured_angles, strict=True)) if measured_angles is not None else {}
    for n, angle in zip(number.tolist(), angles, strict=True):
        beside = measured.get(n, -1.0)
        top = max(angle, beside + 0.015 * highest) if abs(beside - angle) < 0.05 * highest else angle
        chart.text(n, top + 0.012 * highest, f"{angle:.1f}", ha="center", va="bottom", fontsize=8.5)
    chart.set_ylim(0.0, 1.14 * highest)
    chart.grid(axis="x", visible=False)


def _draw_points(figure: Figure, cell: Any, sheet: FormedSheet) -> None:
    """The points on the flat blank, in the colours of the elements."""
    from matplotlib.collections import PolyCollection
    from matplotlib.patheffects import Normal, Stroke

    blank = sheet.blank
    plan = new_axes(figure, cell, aspect="equal", title="Where they lie on the flat blank")
    plan.set(xlabel="material x [mm]", ylabel="material y [mm]")
    colours = angle_colours(sheet.shear_angle_deg)
    flat = 1.0e3 * blank.material_coordinates
    elements = PolyCollection(flat[blank.quads], facecolors=colours, edgecolors=colours, linewidths=0.3)
    plan.add_collection(elements, autolim=False)
    place = 1.0e3 * np.asarray(sheet.points)
    marker: Any = {"markerfacecolor": INK, "markeredgecolor": "white", "markersize": 6}
    plan.plot(*place.T, "o-", color="white", linewidth=1.0, clip_on=False, **marker)
    for n, (x, y) in enumerate(place, start=1):
        plan.annotate(
            str(n), (x, y), (6, 5), textcoords="offset points", weight="bold", fontsize=9, color="white",
            path_effects=[Stroke(linewidth=2.2, foreground=INK), Normal()],
        )  # fmt: skip
    margin = 0.04 * np.ptp(flat, axis=0).max()
    plan.set(xlim=(flat[:, 0].min() - margin, flat[:, 0].max() + margin))
    plan.set(ylim=(flat[:, 1].min() - margin, flat[:, 1].max() + margin))
    plan.grid(visible=False)
    add_angle_bar(figure, [plan], float(sheet.shear_angle_deg.max()))
