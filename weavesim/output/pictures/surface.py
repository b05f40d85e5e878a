"""Elements of a part, each in its own colour, seen obliquely and in plan."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ...measures.findings import FormedSheet
from .sheet import OBLIQUE, PLAN, projection
from .style import colour_map

__all__ = ["GREY", "OBLIQUE", "PLAN", "draw_elements", "scaled_colours", "signed_colours", "view"]

if TYPE_CHECKING:
    from matplotlib.axes import Axes

GREY = (0.86, 0.87, 0.9, 1.0)


def draw_elements(axes: Axes, sheet: FormedSheet, colours: np.ndarray, direction: tuple[float, float]) -> None:
    """Draw the whole part.

    Args:
        axes: to draw on.
        sheet: formed.
        colours: of its elements, (element_count, 4).
        direction: azimuth and elevation of the viewer [degrees].
    """
    from matplotlib.collections import PolyCollection

    corners = sheet.symmetry.mirrored(sheet.position[sheet.blank.quads])
    colours = np.tile(colours, (len(sheet.symmetry.mirror_factors), 1)).copy()
    to_eye, right, screen = projection(direction)
    normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1.0e-300)
    colours[:, :3] *= (0.78 + 0.22 * np.abs(normal @ (to_eye + 0.5 * right) / 1.12).clip(0.0, 1.0))[:, None]
    order = np.argsort(corners.mean(axis=1) @ to_eye, kind="stable")
    polygons: Any = (corners @ screen)[order]
    axes.add_collection(PolyCollection(polygons, facecolors=colours[order], edgecolors=colours[order], linewidths=0.3))
    axes.autoscale_view()
    axes.set_aspect("equal")
    if direction == PLAN:
        axes.set(xlabel="x [mm]", ylabel="y [mm]")
    else:
        axes.set_axis_off()


def scaled_colours(values: np.ndarray, largest: float) -> np.ndarray:
    """Colours of values from 0 to ``largest``; grey where there is none, (element_count, 4)."""
    colours = np.tile(np.array(GREY), (len(values), 1))
    known = np.isfinite(values)
    colours[known] = colour_map()(np.clip(values[known] / max(largest, 1.0e-300), 0.0, 1.0))
    return colours


def signed_colours(values: np.ndarray, largest: float) -> np.ndarray:
    """Blue to red from -``largest`` to ``largest``; grey where there is none, (element_count, 4)."""
    from matplotlib import colormaps

    colours = np.tile(np.array(GREY), (len(values), 1))
    known = np.isfinite(values)
    share = 0.5 + 0.5 * np.clip(values[known] / max(largest, 1.0e-300), -1.0, 1.0)
    colours[known] = colormaps["coolwarm"](share)
    return colours


def view(direction: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Unit vector to the eye, and the projection to the screen, (3, 2) [mm/m]."""
    to_eye, _, screen = projection(direction)
    return to_eye, screen
