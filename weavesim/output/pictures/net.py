"""A kinematic drape: its net, and the difference to the formed sheet."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..colours import LARGEST_SHOWN_ANGLE
from .style import FAINT, INK, colour_map, fitting_height, new_axes, new_figure, ratio_of
from .surface import OBLIQUE, draw_elements, scaled_colours, signed_colours, view

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..comparison.kinematic import KinematicDrape

_SHOWN_DIFFERENCE = 15.0


def net_picture(drape: KinematicDrape) -> Figure:
    """The net; beside a run also the formed sheet and the difference of their angles."""
    if drape.sheet is None:
        figure = new_figure(7.0, 5.4)
        _draw_net(new_axes(figure, 1, 1, 1, title=f"Kinematic drape on {drape.tool}"), drape)
        add_bar(figure, figure.axes, "Shear angle [degrees]", colour_map(), 0.0, LARGEST_SHOWN_ANGLE)
        return figure
    _, screen = view(OBLIQUE)
    whole = drape.sheet.symmetry.mirrored(drape.sheet.position) @ screen
    net_points = drape.net.position[np.isfinite(drape.net.position).all(axis=-1)] @ screen
    ratios = [ratio_of(points) for points in (whole, net_points, whole)]
    figure = new_figure(16.0, fitting_height(16.0, ratios, 1.2))
    grid = figure.add_gridspec(1, 3, width_ratios=[1.0 / ratio for ratio in ratios])
    formed, net, difference = (
        new_axes(figure, grid[0, k], title=title)
        for k, title in enumerate(("Formed sheet", f"Kinematic drape on {drape.tool}", "Formed less kinematic"))
    )
    draw_elements(formed, drape.sheet, scaled_colours(drape.sheet.shear_angle_deg, LARGEST_SHOWN_ANGLE), OBLIQUE)
    _draw_net(net, drape)
    values = drape.difference_deg
    assert values is not None
    draw_elements(difference, drape.sheet, signed_colours(values, _SHOWN_DIFFERENCE), OBLIQUE)
    add_bar(figure, [formed, net], "Shear angle [degrees]", colour_map(), 0.0, LARGEST_SHOWN_ANGLE)
    text = "Difference [degrees]; grey where the net does not reach"
    add_bar(figure, [difference], text, "coolwarm", -_SHOWN_DIFFERENCE, _SHOWN_DIFFERENCE)
    return figure


def _draw_net(axes: Axes, drape: KinematicDrape) -> None:
    from matplotlib.collections import PolyCollection

    p = drape.net.position
    corners = np.stack([p[:-1, :-1], p[1:, :-1], p[1:, 1:], p[:-1, 1:]], axis=2).reshape(-1, 4, 3)
    whole = np.isfinite(corners).all(axis=(1, 2))
    corners, angle = corners[whole], np.abs(np.rad2deg(drape.net.shear_angle.ravel()[whole]))
    colours = scaled_colours(angle, LARGEST_SHOWN_ANGLE)
    to_eye, screen = view(OBLIQUE)
    order = np.argsort(corners.mean(axis=1) @ to_eye, kind="stable")
    polygons: Any = (corners @ screen)[order]
    axes.add_collection(PolyCollection(polygons, facecolors=colours[order], edgecolors=FAINT, linewidths=0.3))
    axes.autoscale_view()
    axes.set_aspect("equal")
    axes.set_axis_off()


def add_bar(figure: Figure, axes: list[Axes], text: str, colours: Any, low: float, high: float) -> None:
    """Add a bar of colours from ``low`` to ``high`` below some axes."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    mappable = ScalarMappable(Normalize(low, high), colours)
    bar = figure.colorbar(mappable, ax=axes, location="bottom", shrink=0.6, aspect=40, pad=0.02)
    bar.outline.set_visible(False)
    bar.set_label(text, color=INK, fontsize=9.5)
