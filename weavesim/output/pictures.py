"""Pictures of a run, as matplotlib figures (drawn without a display)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..measures import (
    MaterialLine,
    border_draw_in,
    draw_in,
    mirror_signs,
    outline,
    shear_angle_at,
    symmetry_line,
    whole_outline,
)
from ..recording import Frame
from .colours import LARGEST_SHOWN_ANGLE, colour_table, encoded
from .files import replacing
from .tables import History

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..blank import Blank
    from ..tool import Tool
    from .curves import Chart

_INK, _GREY, _FAINT, _ACCENT, _MEASURED = "#23262d", "#6b7280", "#9aa1ad", "#5b3fb5", "#d1495b"
_LINE_COLOURS = ("#5b3fb5", "#e07a1f", "#1f8a70", "#d1495b", "#3b82c4", "#a05d1a", "#7a7f8a", "#b5479b", "#5a8f29")
_STYLE: Any = {
    "font.size": 9.5,
    "axes.edgecolor": _FAINT,
    "axes.labelcolor": _INK,
    "axes.titlesize": 11,
    "axes.titleweight": "bold",
    "axes.titlecolor": _INK,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e6e8ec",
    "grid.linewidth": 0.8,
    "text.color": _INK,
    "xtick.color": _INK,
    "ytick.color": _INK,
    "legend.frameon": False,
    "legend.fontsize": 9,
    "lines.linewidth": 1.8,
    "lines.solid_capstyle": "round",
}
_PART_NAMES = {0: "the part", 1: "the computed half", 2: "the computed quarter"}
_RESOLUTION = 150
# At most this many yarn lines across the longer side of the part.
_LARGEST_YARN_COUNT = 50


def write_picture(figure: Figure, path: str | Path) -> None:
    """Write the figure, as the ending of ``path`` says, with 150 dots per inch."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    # laid out here: savefig would draw all of it once more only to have that done
    FigureCanvasAgg(figure)
    figure.set_dpi(_RESOLUTION)
    if (engine := figure.get_layout_engine()) is not None:
        engine.execute(figure)
        figure.set_layout_engine(None)
    with replacing(Path(path)) as temporary:
        figure.savefig(temporary, dpi=_RESOLUTION, facecolor="white")


def _figure(width: float, height: float) -> Figure:
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    with rc_context(_STYLE):
        return Figure(figsize=(width, height), layout="constrained")


def _axes(figure: Figure, *place: Any, **settings: Any) -> Axes:
    from matplotlib import rc_context

    with rc_context(_STYLE):
        return figure.add_subplot(*place, **settings)


def _legend(axes: Axes, **settings: Any) -> None:
    if axes.get_legend_handles_labels()[1]:
        axes.legend(frameon=False, fontsize=9, **settings)


# --------------------------------------------------------------------------------------------------- formed sheet


def formed_sheet(blank: Blank, frame: Frame, symmetry: Sequence[str] = ()) -> Figure:
    """The whole part, oblique and in plan, coloured by the angle of each element, with lines along the yarns."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    angle = np.abs(np.rad2deg(frame.fields["shear_angle"]))
    spacing, lines = _yarn_lines(blank, symmetry)
    corners = _mirrored(frame.position[blank.quads], symmetry)
    segments = _mirrored(lines.of(frame.position).reshape(-1, 2, 3), symmetry)
    angles = np.tile(angle, len(mirror_signs(symmetry)))

    border = frame.position[outline(blank, symmetry).node, 2]
    turned = float(border.mean()) > float(frame.position[:, 2].mean())  # a bowl is clearer seen as a dome
    turn = np.array([1.0, -1.0, -1.0] if turned else [1.0, 1.0, 1.0])
    figure = _figure(13.0, 5.0)
    grid = figure.add_gridspec(1, 2, width_ratios=(1.12, 1.0))
    views = (
        (grid[0, 0], "Formed sheet" + (", turned over" if turned else ""), (-58.0, 36.0), turn),
        (grid[0, 1], "From above", (-90.0, 90.0), np.ones(3)),
    )
    axes = [
        _draw_view(_axes(figure, place, title=title), direction, corners * flip, segments * flip, angles)
        for place, title, direction, flip in views
    ]
    bar = figure.colorbar(
        ScalarMappable(Normalize(0.0, LARGEST_SHOWN_ANGLE), _colour_map()),
        ax=axes,
        location="bottom",
        shrink=0.5,
        aspect=45,
        pad=0.02,
        extend="max" if angle.max() > LARGEST_SHOWN_ANGLE else "neither",
    )
    bar.outline.set_visible(False)
    lines_text = f"lines follow the yarns, one each {1.0e3 * spacing:g} mm" if spacing else "strokes follow the yarns"
    text = f"Shear angle of each element [degrees], largest {angle.max():.1f}°   ·   {lines_text}"
    bar.set_label(text, color=_INK, fontsize=9.5)
    bar.ax.axvline(min(angle.max(), LARGEST_SHOWN_ANGLE), color="white", linewidth=2.5)
    bar.ax.axvline(min(angle.max(), LARGEST_SHOWN_ANGLE), color=_INK, linewidth=1.2)
    return figure


def _colour_map() -> Any:
    from matplotlib.colors import ListedColormap

    return ListedColormap(encoded(colour_table()), name="shear angle")


def _mirrored(points: np.ndarray, symmetry: Sequence[str]) -> np.ndarray:
    return np.concatenate([points * np.array([*sign, 1.0]) for sign in mirror_signs(symmetry)])


def _yarn_lines(blank: Blank, symmetry: Sequence[str]) -> tuple[float, MaterialLine]:
    """Distance of the lines [m], and their pieces: each two following points are one segment.

    With one yarn direction all over the flat blank the lines run on from element to element; else (distance 0) every
    element has one stroke per family through its centre.
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


def _draw_view(
    axes: Axes,
    direction: tuple[float, float],
    corners: np.ndarray,
    segments: np.ndarray,
    angles: np.ndarray,
) -> Axes:
    """Painter's algorithm: elements and yarn segments in one collection, far ones first."""
    from matplotlib.collections import PolyCollection
    from matplotlib.colors import to_rgba

    azimuth, elevation = np.deg2rad(direction)
    to_eye = np.array([np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation), np.sin(elevation)])
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    screen = np.stack([right, np.cross(to_eye, right)], axis=1) * 1.0e3
    light = to_eye + 0.55 * right + np.array([0.0, 0.0, 0.35])
    light /= np.linalg.norm(light)

    normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1.0e-300)
    facing = np.sign(normal @ to_eye)[:, None] * normal
    shade = 0.74 + 0.26 * np.clip(facing @ light, 0.0, 1.0)
    faces = np.ones((len(corners), 4))
    faces[:, :3] = _colour_map()(np.clip(angles / LARGEST_SHOWN_ANGLE, 0.0, 1.0))[:, :3] * shade[:, None]

    size = float(np.sqrt(np.median(np.linalg.norm(np.cross(
        corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]), axis=1)) / 2.0))  # fmt: skip
    strokes = segments[:, [0, 1, 1, 0]]
    depth = np.concatenate([corners.mean(axis=1) @ to_eye, strokes.mean(axis=1) @ to_eye + size])
    polygons = np.concatenate([corners, strokes]) @ screen
    edges = np.concatenate([faces, np.tile(to_rgba("white", 0.55), (len(strokes), 1))])
    colours = np.concatenate([faces, np.zeros((len(strokes), 4))])
    widths = np.concatenate([np.full(len(corners), 0.35), np.full(len(strokes), 0.7)])
    order = np.argsort(depth, kind="stable")
    axes.add_collection(
        PolyCollection(
            polygons[order],
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
    if elevation > 1.5:
        axes.set(xlabel="x [mm]", ylabel="y [mm]")
    else:
        axes.set_axis_off()
    return axes


# ------------------------------------------------------------------------------------------------------- draw-in


def draw_in_picture(
    blank: Blank, frame: Frame, symmetry: Sequence[str] = (), measured_outline: np.ndarray | None = None
) -> Figure:
    """Flat and formed outline in plan, and the draw-in along the outline; a measured outline (k, 2) [m] on top."""
    figure = _figure(12.0, 4.9)
    grid = figure.add_gridspec(1, 2, width_ratios=(1.55, 1.0))
    plan = _axes(figure, grid[0, 0], aspect="equal", title="Outline in plan", xlabel="x [mm]", ylabel="y [mm]")
    flat = 1.0e3 * whole_outline(blank, blank.material_coordinates, symmetry)
    formed = 1.0e3 * whole_outline(blank, frame.position, symmetry)
    plan.fill(*flat.T, facecolor="none", edgecolor=_FAINT, linestyle=(0, (4, 3)), linewidth=1.4, label="flat")
    plan.fill(*formed[:, :2].T, facecolor="#e9e4f8", edgecolor=_ACCENT, linewidth=1.8, label="formed")
    if measured_outline is not None:
        plan.plot(*(1.0e3 * measured_outline.T), "o", color=_MEASURED, markersize=3.5, label="measured")
    for along, axis in (("x", 0), ("y", 1)):
        value = 1.0e3 * draw_in(blank, frame.position, along)
        line = symmetry_line(blank, along)
        end = 1.0e3 * np.array([line.of(blank.material_coordinates)[-1], line.of(frame.position[:, :2])[-1]])
        plan.annotate("", end[1], end[0], arrowprops={"arrowstyle": "-|>", "color": _INK, "linewidth": 1.2})
        inward = end[1] - 0.025 * np.ptp(flat[:, 0]) * np.eye(2)[axis]
        place: Any = {"ha": "right", "va": "center"} if axis == 0 else {"ha": "center", "va": "top"}
        plan.text(inward[0], inward[1], f"{value:.1f} mm", weight="bold", **place)
    _legend(plan, loc="center")

    border = outline(blank, symmetry)
    start = blank.material_coordinates[border.node]
    length = 1.0e3 * np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(start, axis=0), axis=1))])
    chart = _axes(figure, grid[0, 1], title="Draw-in along the outline")
    chart.set(xlabel="length of the flat outline [mm]", ylabel="draw-in, normal to the flat outline [mm]")
    # At a corner the normal jumps: the curve is broken there, and the corner marked.
    values = 1.0e3 * border_draw_in(blank, frame.position, border)
    jumps = np.flatnonzero(np.einsum("ki,ki->k", border.normal[:-1], border.normal[1:]) < 0.9)
    corners = [int(i) + 1 for i in jumps if i + 1 in jumps]
    values[corners] = np.nan
    chart.plot(length, values, color=_ACCENT)
    chart.axhline(0.0, color=_FAINT, linewidth=1.0)
    for corner in corners:
        chart.axvline(length[corner], color=_FAINT, linewidth=1.0, linestyle=(0, (4, 3)))
        chart.text(
            length[corner], 0.08, "corner ", transform=chart.get_xaxis_transform(), ha="right", va="bottom", color=_GREY
        )
    chart.margins(x=0.0)
    return figure


# --------------------------------------------------------------------------------------------------- point angles


def point_angles(
    blank: Blank,
    frame: Frame,
    points: np.ndarray,
    symmetry: Sequence[str] = (),
    measured_angles: tuple[np.ndarray, np.ndarray] | None = None,
) -> Figure:
    """Shear angle at material points (k, 2) [m], and where they lie on the flat blank."""
    from matplotlib.collections import PolyCollection
    from matplotlib.patheffects import Normal, Stroke

    angles = shear_angle_at(blank, frame.fields["shear_angle"], points, symmetry)
    number = np.arange(1, len(angles) + 1)
    figure = _figure(12.0, 4.6)
    grid = figure.add_gridspec(1, 2, width_ratios=(1.3, 1.0))
    chart = _axes(figure, grid[0, 0], title=f"Shear angle at the {len(angles)} points", xlabel="point")
    chart.set(ylabel="shear angle [degrees]", xticks=number)
    chart.bar(number, angles, width=0.62, color="#d9d0f3", edgecolor=_ACCENT, linewidth=1.2, label="computed")
    highest = float(angles.max(initial=1.0))
    if measured_angles is not None:
        chart.plot(*measured_angles, "D", color=_MEASURED, markersize=6, label="measured")
        highest = max(highest, float(measured_angles[1].max()))
        _legend(chart, loc="upper left")
    measured = dict(zip(*measured_angles, strict=True)) if measured_angles is not None else {}
    for n, angle in zip(number.tolist(), angles, strict=True):
        beside = measured.get(n, -1.0)
        top = max(angle, beside + 0.015 * highest) if abs(beside - angle) < 0.05 * highest else angle
        chart.text(n, top + 0.012 * highest, f"{angle:.1f}", ha="center", va="bottom", fontsize=8.5)
    chart.set_ylim(0.0, 1.14 * highest)
    chart.grid(axis="x", visible=False)

    plan = _axes(figure, grid[0, 1], aspect="equal", title="Where they lie on the flat blank")
    plan.set(xlabel="material x [mm]", ylabel="material y [mm]")
    element_angles = np.abs(np.rad2deg(frame.fields["shear_angle"]))
    colours = _colour_map()(np.clip(element_angles / LARGEST_SHOWN_ANGLE, 0.0, 1.0))
    flat = 1.0e3 * blank.material_coordinates
    plan.add_collection(PolyCollection(flat[blank.quads], facecolors=colours, edgecolors=colours, linewidths=0.3))
    place = 1.0e3 * np.asarray(points)
    marker: Any = {"markerfacecolor": _INK, "markeredgecolor": "white", "markersize": 6}
    plan.plot(*place.T, "o-", color="white", linewidth=1.0, clip_on=False, **marker)
    for n, (x, y) in zip(number.tolist(), place, strict=True):
        plan.annotate(
            str(n), (x, y), (6, 5), textcoords="offset points", weight="bold", fontsize=9, color="white",
            path_effects=[Stroke(linewidth=2.2, foreground=_INK), Normal()],
        )  # fmt: skip
    margin = 0.04 * np.ptp(flat, axis=0).max()
    plan.set(xlim=(flat[:, 0].min() - margin, flat[:, 0].max() + margin))
    plan.set(ylim=(flat[:, 1].min() - margin, flat[:, 1].max() + margin))
    plan.grid(visible=False)
    return figure


# --------------------------------------------------------------------------------------------------------- curves


def tool_forces(history: History, tools: Sequence[Tool], symmetry: Sequence[str] = ()) -> Figure:
    """Force between the sheet and each tool along the tool's axis, against the stroke."""
    figure = _figure(9.0, 4.4)
    chart = _axes(figure, 1, 1, 1, title=f"Tool forces on {_PART_NAMES[len(symmetry)]}")
    chart.set(xlabel="stroke [mm]", ylabel="force along the tool's axis [N]")
    for k, tool in enumerate(tools):
        force = np.abs(history.tool_reaction[:, k] @ np.asarray(tool.axis, dtype=float))
        colour = _LINE_COLOURS[k % len(_LINE_COLOURS)]
        chart.plot(*_against(history, force), color=colour, label=_words(tool.name))
    _name_progress(chart, history)
    chart.set_ylim(bottom=0.0)
    chart.margins(x=0.0)
    _legend(chart, loc="upper left")
    return figure


def chart_of(chart: Chart, columns: Mapping[str, np.ndarray]) -> Figure:
    """Computed columns as lines, expected ones dashed on top."""
    figure = _figure(9.0, 4.4)
    axes = _axes(figure, 1, 1, 1, title=chart.title, xlabel=chart.x[1], ylabel=chart.y_label)
    x = columns[chart.x[0]]
    for k, (name, label) in enumerate(chart.computed.items()):
        axes.plot(x, columns[name], color=_LINE_COLOURS[k % len(_LINE_COLOURS)], label=label)
    for k, (name, label) in enumerate(chart.expected.items()):
        colour = _LINE_COLOURS[k % len(_LINE_COLOURS)] if len(chart.expected) > 1 else _INK
        axes.plot(x, columns[name], color=colour, linestyle=(0, (4, 3)), linewidth=1.4, label=label)
    axes.margins(x=0.0)
    _legend(axes, loc="best")
    return figure


def drive_forces(history: History) -> Figure:
    """Force of the supports on the sheet along each of their drives, against its displacement."""
    figure = _figure(9.0, 4.4)
    chart = _axes(figure, 1, 1, 1, title="Forces of the supports")
    chart.set(xlabel="displacement of the drive [mm]", ylabel="force along the drive [N]")
    for k, name in enumerate(history.drive_names):
        way, force = 1.0e3 * history.drive_displacement[:, k], history.drive_force[:, k]
        chart.plot(way, force, color=_LINE_COLOURS[k % len(_LINE_COLOURS)], label=_words(name))
    chart.axhline(0.0, color=_FAINT, linewidth=1.0)
    _legend(chart, loc="best")
    return figure


def energies(history: History) -> Figure:
    """Where the supplied work goes, every energy on a logarithmic scale, and the ratios that judge a run."""
    from ..ledger import SUMS, SUPPLIED

    figure = _figure(15.5, 4.8)
    book = history.energies
    size = {name: float(np.abs(values).max(initial=0.0)) for name, values in book.items()}
    largest = max(size.values(), default=0.0) or 1.0
    parts = [name for name in book if name not in (*SUPPLIED, *SUMS)]
    parts.sort(key=lambda name: -size[name])
    shown = [name for name in parts if size[name] > 0.004 * largest]
    colour = {name: _LINE_COLOURS[i % len(_LINE_COLOURS)] for i, name in enumerate(parts)}

    stack = _axes(figure, 1, 3, 1, title="Where the work goes", ylabel="energy [J]")
    below = np.zeros(history.frame_count)
    for name in shown:
        place, above = _against(history, below + np.maximum(book[name], 0.0))
        stack.fill_between(place, below, above, facecolor=colour[name], alpha=0.8, linewidth=0.0, label=_words(name))
        below = above
    if "supplied" in book:
        stack.plot(*_against(history, book["supplied"]), color=_INK, linestyle=(0, (4, 2)), label="supplied work")
    stack.set_ylim(bottom=0.0)
    if shown:
        handles, labels = stack.get_legend_handles_labels()
        stack.legend(handles[::-1], labels[::-1], loc="upper left", frameon=False, fontsize=9)

    every = _axes(figure, 1, 3, 2, title="Every stored and lost energy", ylabel="energy [J]", yscale="log")
    for i, name in enumerate(parts):
        if size[name] > 1.0e-6 * largest:
            values = np.where(book[name] > 0.0, book[name], np.nan)
            style = ("-", "--")[i // len(_LINE_COLOURS) % 2]
            every.plot(*_against(history, values), style, color=colour[name], linewidth=1.5, label=_words(name))
    every.set_ylim(1.0e-6 * largest, 2.0 * largest)
    _legend(every, loc="center left", bbox_to_anchor=(1.0, 0.5))

    ratios = _axes(figure, 1, 3, 3, title="Ratios that judge the run", ylabel="[%]", yscale="log")
    for name, over, label in (
        ("kinetic", "internal", "kinetic over internal energy"),
        ("hourglass", "internal", "hourglass over internal energy"),
        ("damping_loss", "supplied", "damping loss over supplied work"),
        ("balance_error", "supplied", "balance error over supplied work"),
    ):
        if name in book and over in book:
            base = np.where(np.abs(book[over]) > 1.0e-3 * size[over], np.abs(book[over]), np.nan)
            values = 100.0 * np.abs(book[name]) / base
            chosen = _LINE_COLOURS[len(ratios.lines)]
            ratios.plot(*_against(history, np.where(values > 0.0, values, np.nan)), color=chosen, label=label)
    ratios.set_ylim(1.0e-4, 1.0e5)  # the upper decades hold the legend
    _legend(ratios, loc="upper right", bbox_to_anchor=(1.0, 1.0))
    for chart in (stack, every, ratios):
        _name_progress(chart, history)
        chart.margins(x=0.0)
    return figure


def _words(name: str) -> str:
    return name.replace("_", " ")


def _against(history: History, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values over the stroke [mm], or over time [ms] where nothing is pressed."""
    if np.ptp(history.stroke) > 0.0:
        return 1.0e3 * history.stroke, values
    return 1.0e3 * history.time, values


def _name_progress(chart: Axes, history: History) -> None:
    chart.set_xlabel("stroke [mm]" if np.ptp(history.stroke) > 0.0 else "time [ms]")


def sections(
    blank: Blank, frame: Frame, tools: Sequence[Tool], thickness: float, symmetry: Sequence[str] = ()
) -> Figure:
    """The formed sheet, in its thickness, and the tools, cut along both symmetry lines."""
    from matplotlib.collections import LineCollection

    figure = _figure(12.0, 5.6)
    for row, along in enumerate("xy"):
        title = f"Section along {along} ({'y' if along == 'x' else 'x'} = 0)"
        chart = _axes(figure, 2, 1, row + 1, aspect="equal", title=title, xlabel=f"{along} [mm]", ylabel="z [mm]")
        line = symmetry_line(blank, along)
        plane = 1.0e3 * line.of(frame.position)[:, [row, 2]]
        tangent = np.gradient(plane, axis=0)
        across = 0.5e3 * thickness * np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)
        across /= np.linalg.norm(tangent, axis=1, keepdims=True)
        reach = np.abs(1.0e3 * whole_outline(blank, blank.material_coordinates, symmetry)[:, row]).max()
        for k, tool in enumerate(tools):
            cut = _cut(*tool.display_triangles(), 1 - row)
            if len(cut):
                shift = float(frame.tool_displacement[k]) * np.asarray(tool.axis, dtype=float)
                colour = _LINE_COLOURS[k % len(_LINE_COLOURS)]
                pieces = 1.0e3 * (cut + shift)[:, :, [row, 2]]
                label = _words(tool.name)
                chart.add_collection(LineCollection(list(pieces), colors=colour, linewidths=1.3, label=label))
        for factor in (1.0, -1.0) if along in symmetry else (1.0,):
            side = np.concatenate([plane + across, (plane - across)[::-1]]) * (factor, 1.0)
            name = "sheet" if factor > 0.0 else None
            chart.fill(*side.T, facecolor=_INK, edgecolor=_INK, linewidth=0.4, label=name, zorder=3)
        depth = np.ptp(plane[:, 1])
        chart.set(xlim=(-1.04 * reach, 1.04 * reach))
        chart.set(ylim=(plane[:, 1].min() - 0.12 * depth - 6.0, plane[:, 1].max() + 0.12 * depth + 12.0))
        if row == 0:
            _legend(chart, loc="center left", bbox_to_anchor=(1.01, 0.5))
    return figure


def _cut(vertices: np.ndarray, faces: np.ndarray, axis: int) -> np.ndarray:
    """Lines in which triangles meet the plane through the origin normal to ``axis``, (k, 2, 3) [m]."""
    corner = vertices[faces]
    place = corner[:, :, axis] - 1.0e-7  # beside vertices that lie on the plane
    crossed = (place > 0.0) != np.roll(place > 0.0, -1, axis=1)
    triangle = np.flatnonzero(crossed.any(axis=1))
    side = np.argsort(~crossed[triangle], axis=1, kind="stable")[:, :2]
    start, end = (triangle[:, None], side), (triangle[:, None], (side + 1) % 3)
    share = place[start] / (place[start] - place[end])
    return corner[start] + share[:, :, None] * (corner[end] - corner[start])
