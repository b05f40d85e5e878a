"""Outline before and after, and the draw-in along the border."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ...measures.border import Outline, symmetry_line, whole_outline
from ...measures.findings import FormedSheet
from .style import ACCENT, FAINT, INK, MEASURED, add_legend, new_axes, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw_in_picture(sheet: FormedSheet, measured_outline: np.ndarray | None = None) -> Figure:
    """Flat and formed outline in plan, and the draw-in along the outline; a measured outline (k, 2) [m] on top."""
    blank, position, symmetry, border = sheet.blank, sheet.position, sheet.symmetry, sheet.border
    figure = new_figure(12.0, 4.9)
    width, height = np.ptp(whole_outline(blank, blank.material_coordinates, symmetry), axis=0)
    grid = figure.add_gridspec(1, 2, width_ratios=(1.55 if width > 0.5 * height else 0.6, 1.0))
    slender = min(width, height) < 0.3 * max(width, height)  # no room inside for texts
    plan = new_axes(figure, grid[0, 0], aspect="equal", title="Outline in plan", xlabel="x [mm]", ylabel="y [mm]")
    flat = 1.0e3 * whole_outline(blank, blank.material_coordinates, symmetry)
    formed = 1.0e3 * whole_outline(blank, position, symmetry)
    plan.fill(*flat.T, facecolor="none", edgecolor=FAINT, linestyle=(0, (4, 3)), linewidth=1.4, label="flat")
    plan.fill(*formed[:, :2].T, facecolor="#e9e4f8", edgecolor=ACCENT, linewidth=1.8, label="formed")
    if measured_outline is not None:
        plan.plot(*(1.0e3 * measured_outline.T), "o", color=MEASURED, markersize=3.5, label="measured")
    for along, axis in (("x", 0), ("y", 1)):
        line = symmetry_line(blank, along)
        end = 1.0e3 * np.array([line.of(blank.material_coordinates)[-1], line.of(position[:, :2])[-1]])
        plan.annotate("", end[1], end[0], arrowprops={"arrowstyle": "-|>", "color": INK, "linewidth": 1.2})
        sign = 1.0 if slender else -1.0  # outside or inside
        beside = end[0 if slender else 1] + sign * 0.025 * np.ptp(flat, axis=0).max() * np.eye(2)[axis]
        horizontal, vertical = ("left", "bottom") if slender else ("right", "top")
        place: Any = {"ha": horizontal, "va": "center"} if axis == 0 else {"ha": "center", "va": vertical}
        plan.text(beside[0], beside[1], f"{sheet.draw_in_mm[along]:.1f} mm", weight="bold", **place)
    if not slender:
        add_legend(plan, loc="center")
    elif width > height:
        add_legend(plan, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3)
    else:
        add_legend(plan, loc="upper left", bbox_to_anchor=(1.0, 1.0))

    # A closed outline ends where it starts.
    shown = np.append(np.arange(len(border.node)), 0) if border.closed else np.arange(len(border.node))
    start = blank.material_coordinates[border.node[shown]]
    length = 1.0e3 * np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(start, axis=0), axis=1))])
    chart = new_axes(figure, grid[0, 1], title="Draw-in along the outline")
    chart.set(xlabel="length of the flat outline [mm]", ylabel="draw-in, normal to the flat outline [mm]")
    # At a corner the normal jumps: the curve is interrupted there, and the corner marked.
    corners = np.flatnonzero(_corners(border)[shown])
    values = sheet.border_draw_in_mm[shown]
    values[corners] = np.nan
    chart.plot(length, values, color=ACCENT)
    chart.axhline(0.0, color=FAINT, linewidth=1.0)
    for k, corner in enumerate(corners):
        label = "corner of the flat outline" if k == 0 else None
        chart.axvline(length[corner], color=FAINT, linewidth=1.0, linestyle=(0, (4, 3)), label=label)
    add_legend(chart, loc="upper center", bbox_to_anchor=(0.5, -0.12))  # nowhere inside is surely free
    chart.margins(x=0.0)
    return figure


def _corners(border: Outline) -> np.ndarray:
    """Whether the flat outline turns sharply at each of its nodes, (k,) bool."""
    turns = np.einsum("ki,ki->k", border.normal, np.roll(border.normal, -1, axis=0)) < 0.9
    if not border.closed:
        turns[-1] = False
    return turns & np.roll(turns, 1)
