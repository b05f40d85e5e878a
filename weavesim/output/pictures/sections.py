"""Sections through sheet and tools."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...measures.border import symmetry_line, whole_outline
from ...measures.findings import FormedSheet
from ...process.motions.paths import Place, Pose
from ...sheet.symmetry import AXES
from ..colours import DISTINCT_COLOURS
from .style import FAINT, GREY, INK, LINE_COLOURS, add_legend, new_axes, new_figure, words

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ...tools.tool import Tool


# Tools beside sheets that have colours of their own.
GREYS = (GREY, INK, FAINT)


def sections(
    sheet: FormedSheet | Sequence[tuple[str, FormedSheet]], tools: Sequence[tuple[str, Tool, Place]]
) -> Figure:
    """Formed sheets, with their thickness, and the tools, cut along both symmetry lines.

    Args:
        sheet: the only one, or name and formed sheet of several; they must cross both lines.
        tools: name, tool and place of each.
    """
    from matplotlib.collections import LineCollection

    sheets = [("sheet", sheet)] if isinstance(sheet, FormedSheet) else list(sheet)
    colours = [INK] if len(sheets) == 1 else [DISTINCT_COLOURS[k % len(DISTINCT_COLOURS)] for k in range(len(sheets))]
    figure = new_figure(12.0, 5.6)
    for row, along in enumerate("xy"):
        title = f"Section along {along} ({'y' if along == 'x' else 'x'} = 0)"
        chart = new_axes(figure, 2, 1, row + 1, aspect="equal", title=title, xlabel=f"{along} [mm]", ylabel="z [mm]")
        for k, (name, tool, place) in enumerate(tools):
            vertices, faces = tool.display_triangles()
            turned = isinstance(place, Pose)
            cut = plane_cut(tool.moved(vertices, place) if turned else vertices, faces, 1 - row)
            if len(cut):
                shift = np.zeros(3) if turned else place * np.asarray(tool.axis, dtype=float)
                colour = GREYS[k % len(GREYS)] if len(sheets) > 1 else LINE_COLOURS[k % len(LINE_COLOURS)]
                pieces = 1.0e3 * (cut + shift)[:, :, [row, 2]]
                label = words(name)
                chart.add_collection(LineCollection(list(pieces), colors=colour, linewidths=1.3, label=label))
        planes = []
        for (name, formed), colour in zip(sheets, colours, strict=True):
            plane, across = _strip(formed, along)
            planes.append(plane)
            for factor in (1.0, -1.0) if along in formed.symmetry.planes else (1.0,):
                side = np.concatenate([plane + across, (plane - across)[::-1]]) * (factor, 1.0)
                own = words(name) if factor > 0.0 else None
                chart.fill(*side.T, facecolor=colour, edgecolor=colour, linewidth=0.4, label=own, zorder=3)
        height = np.concatenate(planes)[:, 1]
        reach = max(_reach(formed, row) for _, formed in sheets)
        depth = np.ptp(height)
        chart.set(xlim=(-1.04 * reach, 1.04 * reach))
        chart.set(ylim=(height.min() - 0.12 * depth - 6.0, height.max() + 0.12 * depth + 12.0))
        if row == 0:
            add_legend(chart, loc="center left", bbox_to_anchor=(1.01, 0.5))
    return figure


def _strip(sheet: FormedSheet, along: str) -> tuple[np.ndarray, np.ndarray]:
    """Points of the cut sheet, (k, 2) [mm], and from each half the thickness across it."""
    plane = 1.0e3 * symmetry_line(sheet.blank, along).of(sheet.position)[:, [AXES[along], 2]]
    tangent = np.gradient(plane, axis=0)
    across = 0.5e3 * sheet.thickness * np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)
    return plane, across / np.linalg.norm(tangent, axis=1, keepdims=True)


def _reach(sheet: FormedSheet, axis: int) -> float:
    """Furthest point of the outline along an axis, flat or formed: a pulled sheet outgrows its blank [mm]."""
    shapes = (sheet.blank.material_coordinates, sheet.position[:, :2])
    outlines = [whole_outline(sheet.blank, shape, sheet.symmetry)[:, axis] for shape in shapes]
    return float(1.0e3 * np.abs(np.concatenate(outlines)).max())


def plane_cut(vertices: np.ndarray, faces: np.ndarray, axis: int) -> np.ndarray:
    """Intersections of triangles with the plane through the origin normal to ``axis``, (k, 2, 3) [m]."""
    corner = vertices[faces]
    place = corner[:, :, axis] - 1.0e-7  # shifted off vertices that lie on the plane
    crossed = (place > 0.0) != np.roll(place > 0.0, -1, axis=1)
    triangle = np.flatnonzero(crossed.any(axis=1))
    side = np.argsort(~crossed[triangle], axis=1, kind="stable")[:, :2]
    start, end = (triangle[:, None], side), (triangle[:, None], (side + 1) % 3)
    share = place[start] / (place[start] - place[end])
    return corner[start] + share[:, :, None] * (corner[end] - corner[start])
