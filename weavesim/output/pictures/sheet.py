"""Views of the formed sheet."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ...measures.border import MaterialLine, whole_outline
from ...measures.findings import FormedSheet
from ...sheet.symmetry import Symmetry
from ..colours import LARGEST_SHOWN_ANGLE
from .style import INK, colour_map, fitting_height, new_axes, new_figure, ratio_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ...sheet.blank import Blank

# Azimuth and elevation of the viewer [degrees].
OBLIQUE, PLAN = (-58.0, 36.0), (-90.0, 90.0)
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
    views = (("Formed sheet" + (", turned over" if turned else ""), OBLIQUE, turn), ("From above", PLAN, np.ones(3)))
    ratios = [ratio_of((corners * flip) @ projection(direction)[2]) for _, direction, flip in views]
    figure = new_figure(13.0, fitting_height(13.0, ratios, 1.5))
    grid = figure.add_gridspec(1, 2, width_ratios=[1.0 / ratio for ratio in ratios])
    axes = []
    for place, (title, direction, flip) in enumerate(views):
        axes.append(new_axes(figure, grid[0, place], title=title))
        draw_view(axes[-1], direction, corners * flip, segments * flip, angle_colours(angles))
        _mark_largest(axes[-1], sheet, direction, flip)
    lines_text = f"lines follow the yarns, one each {1.0e3 * spacing:g} mm" if spacing else "strokes follow the yarns"
    x, y = 1.0e3 * blank.material_coordinates[blank.quads[int(angle.argmax())]].mean(axis=0)
    add_angle_bar(
        figure, axes, float(angle.max()), f"at ({x:.0f}, {y:.0f}) mm of the flat blank", lines_text,
        usual=sheet.usual_shear_angle_deg,
    )  # fmt: skip
    return figure


def _mark_largest(axes: Axes, sheet: FormedSheet, direction: tuple[float, float], flip: np.ndarray) -> None:
    """Ring and number where the shear angle is largest, on the copy that the viewer sees best."""
    from matplotlib.patheffects import Normal, Stroke

    to_eye, _, screen = projection(direction)
    element = int(sheet.shear_angle_deg.argmax())
    corner = np.stack([quad * flip for quad in sheet.symmetry.mirrored(sheet.position[sheet.blank.quads[[element]]])])
    normal = np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1])
    facing = np.abs(normal @ to_eye) / np.maximum(np.linalg.norm(normal, axis=1), 1.0e-300)
    middle = corner.mean(axis=1)
    # in plan where it was computed, whose place the text tells
    seen = 0 if direction == PLAN else int(np.argmax(facing + middle @ to_eye / max(np.abs(middle).max(), 1.0e-300)))
    x, y = middle[seen] @ screen
    axes.plot(x, y, "o", markersize=11, markerfacecolor="none", markeredgecolor="white", markeredgewidth=2.6, zorder=5)
    axes.plot(x, y, "o", markersize=11, markerfacecolor="none", markeredgecolor=INK, markeredgewidth=1.2, zorder=6)
    axes.annotate(
        f"{sheet.shear_angle_deg[element]:.1f}°", (x, y), (9, 7), textcoords="offset points", weight="bold", zorder=6,
        color=INK, path_effects=[Stroke(linewidth=2.6, foreground="white"), Normal()],
    )  # fmt: skip


def add_angle_bar(
    figure: Figure, axes: list[Axes], largest: float, place: str = "", further: str = "", usual: float | None = None
) -> None:
    """The scale of shear angles below ``axes``.

    Args:
        figure: of the axes.
        axes: that it belongs to.
        largest: angle, which is marked [degrees].
        place: of the largest, in words.
        further: text.
        usual: angle that 99 % of the area do not exceed, marked too [degrees].
    """
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
    text = f"Shear angle of each element [degrees], largest {largest:.1f}°" + (f" {place}" if place else "")
    if usual is not None:
        text += f", 99 % of the area below {usual:.1f}°"
        bar.ax.axvline(min(usual, LARGEST_SHOWN_ANGLE), color="white", linewidth=1.6, linestyle=(0, (2, 1.5)))
    bar.set_label("\n".join(filter(None, (text, further))), color=INK, fontsize=9.5)
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
        ),
        autolim=False,  # limits follow; finding them from twenty thousand polygons is slow
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
