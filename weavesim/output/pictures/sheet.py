"""Views of the formed sheet."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ...measures.border import MaterialLine, whole_outline
from ...measures.findings import FormedSheet
from ...sheet.symmetry import Symmetry
from ..colours import LARGEST_SHOWN_ANGLE
from .style import INK, colour_map, new_axes, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ...sheet.blank import Blank

# At most this many yarn lines across the longer side of the part.
_LARGEST_YARN_COUNT = 50

# --------------------------------------------------------------------------------------------------- formed sheet


def formed_sheet(sheet: FormedSheet) -> Figure:
    """The whole part, oblique and in plan, coloured by the angle of each element, with lines along the yarns."""
    blank, position, symmetry, angle = sheet.blank, sheet.position, sheet.symmetry, sheet.shear_angle_deg
    spacing, lines = yarn_lines(blank, symmetry)
    corners = symmetry.mirrored(position[blank.quads])
    segments = symmetry.mirrored(lines.of(position).reshape(-1, 2, 3))
    angles = np.tile(angle, len(symmetry.mirror_factors))

    border = position[sheet.border.node, 2]
    turned = float(border.mean()) > float(position[:, 2].mean())  # a bowl is easier to see as a dome
    turn = np.array([1.0, -1.0, -1.0] if turned else [1.0, 1.0, 1.0])
    figure = new_figure(13.0, 5.0)
    grid = figure.add_gridspec(1, 2, width_ratios=(1.12, 1.0))
    views = (
        (grid[0, 0], "Formed sheet" + (", turned over" if turned else ""), (-58.0, 36.0), turn),
        (grid[0, 1], "From above", (-90.0, 90.0), np.ones(3)),
    )
    axes = [
        draw_view(
            new_axes(figure, place, title=title), direction, corners * flip, segments * flip, angle_colours(angles)
        )
        for place, title, direction, flip in views
    ]
    lines_text = f"lines follow the yarns, one each {1.0e3 * spacing:g} mm" if spacing else "strokes follow the yarns"
    add_angle_bar(figure, axes, float(angle.max()), lines_text)
    return figure


def add_angle_bar(figure: Figure, axes: list[Axes], largest: float, further: str = "") -> None:
    """The scale of shear angles below ``axes``, with the ``largest`` [degrees] marked, and ``further`` text."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    bar = figure.colorbar(
        ScalarMappable(Normalize(0.0, LARGEST_SHOWN_ANGLE), colour_map()),
        ax=axes,
        location="bottom",
        shrink=0.5,
        aspect=45,
        pad=0.02,
        extend="max" if largest > LARGEST_SHOWN_ANGLE else "neither",
    )
    bar.outline.set_visible(False)
    text = f"Shear angle of each element [degrees], largest {largest:.1f}°"
    bar.set_label("   ·   ".join(filter(None, (text, further))), color=INK, fontsize=9.5)
    bar.ax.axvline(min(largest, LARGEST_SHOWN_ANGLE), color="white", linewidth=2.5)
    bar.ax.axvline(min(largest, LARGEST_SHOWN_ANGLE), color=INK, linewidth=1.2)


def yarn_lines(blank: Blank, symmetry: Symmetry) -> tuple[float, MaterialLine]:
    """Spacing of the lines [m], and their segments: pairs of consecutive points.

    With a uniform yarn direction on the flat blank the lines are continuous across elements; otherwise (spacing 0)
    every element has one stroke per family through its centre.
    """
    directions = (blank.warp_direction[:, :2], blank.weft_direction[:, :2])
    corner = blank.material_coordinates[blank.quads]
    if max(float(np.ptp(direction, axis=0).max()) for direction in directions) > 1.0e-9:
        families: list[tuple[np.ndarray, np.ndarray]] = [
            (
                np.einsum("eci,ei->ec", corner - corner.mean(axis=1, keepdims=True), direction[:, ::-1] * (-1, 1)),
                np.zeros(1),
            )
            for direction in directions
        ]
        spacing = 0.0
    else:
        whole = whole_outline(blank, blank.material_coordinates, symmetry)
        rough = float(np.ptp(whole, axis=0).max()) / _LARGEST_YARN_COUNT
        power = 10.0 ** np.floor(np.log10(rough))
        spacing = float(next(step * power for step in (1.0, 2.0, 5.0, 10.0) if step * power >= rough))
        families = []
        for direction in directions:
            place = corner @ np.array([-direction[0, 1], direction[0, 0]])
            first, last = np.floor(place.min() / spacing) - 1, np.ceil(place.max() / spacing)
            families.append((place, (np.arange(first, last + 1) + 0.5) * spacing))
    start, end, share = [], [], []
    for place, levels in families:
        for level in levels:
            above = place >= level
            crossed = above != np.roll(above, -1, axis=1)
            element = np.flatnonzero(crossed.sum(axis=1) == 2)
            side = np.argsort(~crossed[element], axis=1, kind="stable")[:, :2]
            a, b = place[element[:, None], side], place[element[:, None], (side + 1) % 4]
            start.append(blank.quads[element[:, None], side].ravel())
            end.append(blank.quads[element[:, None], (side + 1) % 4].ravel())
            share.append(((level - a) / (b - a)).ravel())
    return spacing, MaterialLine(np.concatenate(start), np.concatenate(end), np.concatenate(share))


def angle_colours(angles: np.ndarray) -> np.ndarray:
    """Colours of shear angles [degrees], (k, 3)."""
    return np.asarray(colour_map()(np.clip(angles / LARGEST_SHOWN_ANGLE, 0.0, 1.0))[:, :3])


def draw_view(
    axes: Axes,
    direction: tuple[float, float],
    corners: np.ndarray,
    segments: np.ndarray,
    colours_of_faces: np.ndarray,
    in_front: np.ndarray | float = 0.0,
) -> Axes:
    """Painter's algorithm: elements and yarn segments in one collection, far ones first.

    Args:
        axes: to draw in.
        direction: azimuth and elevation of the eye [degrees].
        corners: of the elements, (k, 4, 3) [m].
        segments: of yarns, (n, 2, 3) [m].
        colours_of_faces: of the elements, encoded sRGB, (k, 3).
        in_front: how much nearer to the eye elements are than they seem, in their own size, (k,): sheets that lie on
            each other are nearer than the elements are wide, and would hide each other in part.
    """
    from matplotlib.collections import PolyCollection
    from matplotlib.colors import to_rgba

    to_eye, right, screen = projection(direction)
    faces = _shaded(corners, colours_of_faces, to_eye, right)
    size = float(np.sqrt(np.median(np.linalg.norm(np.cross(
        corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]), axis=1)) / 2.0))  # fmt: skip
    strokes = segments[:, [0, 1, 1, 0]]
    depth = np.concatenate([corners.mean(axis=1) @ to_eye + size * in_front, strokes.mean(axis=1) @ to_eye + size])
    polygons = np.concatenate([corners, strokes]) @ screen
    edges = np.concatenate([faces, np.tile(to_rgba("white", 0.55), (len(strokes), 1))])
    colours = np.concatenate([faces, np.zeros((len(strokes), 4))])
    widths = np.concatenate([np.full(len(corners), 0.35), np.full(len(strokes), 0.7)])
    order = np.argsort(depth, kind="stable")
    sorted_polygons: Any = polygons[order]  # Matplotlib's type hints allow only lists
    axes.add_collection(
        PolyCollection(
            sorted_polygons,
            facecolors=colours[order],
            edgecolors=edges[order],
            linewidths=widths[order],
            joinstyle="round",
        )
    )
    flat = corners.reshape(-1, 3) @ screen
    margin = 0.02 * np.ptp(flat, axis=0).max()
    axes.set(xlim=(flat[:, 0].min() - margin, flat[:, 0].max() + margin))
    axes.set(ylim=(flat[:, 1].min() - margin, flat[:, 1].max() + margin), aspect="equal")
    if direction[1] > 80.0:
        axes.set(xlabel="x [mm]", ylabel="y [mm]")
    else:
        axes.set_axis_off()
    return axes


def projection(direction: tuple[float, float]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Unit vectors to the eye and to the right, and the projection to the screen, (3, 2) [mm/m]."""
    azimuth, elevation = np.deg2rad(direction)
    to_eye = np.array([np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation), np.sin(elevation)])
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    return to_eye, right, np.stack([right, np.cross(to_eye, right)], axis=1) * 1.0e3


def _shaded(corners: np.ndarray, colours: np.ndarray, to_eye: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Elements of ``colours`` (element_count, 3) lit from beside the viewer, (element_count, 4)."""
    light = to_eye + 0.55 * right + np.array([0.0, 0.0, 0.35])
    light /= np.linalg.norm(light)

    normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1.0e-300)
    facing = np.sign(normal @ to_eye)[:, None] * normal
    shade = 0.74 + 0.26 * np.clip(facing @ light, 0.0, 1.0)
    faces = np.ones((len(corners), 4))
    faces[:, :3] = colours * shade[:, None]
    return faces
