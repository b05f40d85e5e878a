"""Charts of forces, energies and a scene's own numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..history import History, computed_part, energy_copies, tool_copies
from .style import FAINT, INK, LINE_COLOURS, MEASURED, add_legend, new_axes, new_figure, words

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ...run.frame import RunInfo
    from ..curves import Chart

# Measured points beyond this number are not marked one by one.
MANY_POINTS = 80
MARKERS = ("o", "s", "^", "D", "v")


def tool_forces(history: History, info: RunInfo) -> Figure:
    """Force between the whole part and each tool along the tool's axis, against the stroke.

    Dashed is the force that was wanted of a tool that a force moves.
    """
    figure = new_figure(9.0, 4.4)
    chart = new_axes(figure, 1, 1, 1, title="Force on each tool, whole part")
    chart.set(xlabel="stroke [mm]", ylabel="force along the tool's axis [N]")
    for k, (tool, copies) in enumerate(zip(info.tools, tool_copies(info), strict=True)):
        force = copies * np.abs(history.tool_reaction[:, k] @ np.asarray(tool.axis, dtype=float))
        colour = LINE_COLOURS[k % len(LINE_COLOURS)]
        chart.plot(*_against(history, force), color=colour, label=words(history.tool_names[k]))
        wanted = copies * np.abs(history.tool_wanted[:, k])
        if np.isfinite(wanted).any():
            label = f"{words(history.tool_names[k])}, wanted"
            chart.plot(*_against(history, wanted), color=colour, linestyle=(0, (4, 3)), linewidth=1.2, label=label)
    _name_progress(chart, history)
    chart.set_ylim(bottom=0.0)
    chart.margins(x=0.0)
    add_legend(chart, loc="upper left")
    return figure


def chart_of(chart: Chart, columns: Mapping[str, np.ndarray]) -> Figure:
    """Computed columns as lines, expected ones dashed on top, measured ones as points."""
    figure = new_figure(9.0, 4.4)
    axes = new_axes(figure, 1, 1, 1, title=chart.title, xlabel=chart.x[1], ylabel=chart.y_label)
    x = columns[chart.x[0]]
    for k, (name, label) in enumerate(chart.computed.items()):
        axes.plot(x, columns[name], color=LINE_COLOURS[k % len(LINE_COLOURS)], label=label)
    for k, (name, label) in enumerate(chart.expected.items()):
        colour = LINE_COLOURS[k % len(LINE_COLOURS)] if len(chart.expected) > 1 else INK
        axes.plot(x, columns[name], color=colour, linestyle=(0, (4, 3)), linewidth=1.4, label=label)
    for k, curve in enumerate(chart.measured):
        # few points as points, many as a dotted line
        style: dict[str, Any] = (
            {"marker": MARKERS[k % len(MARKERS)], "markersize": 4.0} if len(curve.x) <= MANY_POINTS else {}
        )
        colour = MEASURED if len(chart.measured) == 1 else LINE_COLOURS[(k + 3) % len(LINE_COLOURS)]
        axes.plot(curve.x, curve.y, linestyle=":", linewidth=1.2, color=colour, label=curve.label, **style)
    if chart.equal_scales:
        axes.set_aspect("equal")
    if chart.downwards:
        axes.invert_yaxis()
    axes.margins(x=0.0)
    add_legend(axes, loc="best")
    return figure


def drive_forces(history: History, info: RunInfo) -> Figure:
    """Force of the supports on the computed part along each of their drives, against its displacement."""
    figure = new_figure(9.0, 4.4)
    chart = new_axes(figure, 1, 1, 1, title=f"Forces of the supports, {computed_part(info)}")
    chart.set(xlabel="displacement of the drive [mm]", ylabel="force along the drive [N]")
    for k, name in enumerate(history.drive_names):
        travel, force = 1.0e3 * history.drive_displacement[:, k], history.drive_force[:, k]
        chart.plot(travel, force, color=LINE_COLOURS[k % len(LINE_COLOURS)], label=words(name))
    chart.axhline(0.0, color=FAINT, linewidth=1.0)
    add_legend(chart, loc="best")
    return figure


def energies(history: History, info: RunInfo) -> Figure:
    """Where the supplied work goes, every energy on a logarithmic scale, and the ratios for judging a run.

    Energies are those of the whole part; of sheets that are different shares of theirs, of what was computed.
    """
    from ...run.ledger import SUMS, SUPPLIED

    figure = new_figure(15.5, 4.8)
    copies = energy_copies(info)
    part = "computed parts" if copies is None else "whole part"
    book = {name: (copies or 1.0) * values for name, values in history.energies.items()}
    size = {name: float(np.abs(values).max(initial=0.0)) for name, values in book.items()}
    largest = max(size.values(), default=0.0) or 1.0
    parts = [name for name in book if name not in (*SUPPLIED, *SUMS)]
    parts.sort(key=lambda name: -size[name])
    shown = [name for name in parts if size[name] > 0.004 * largest]
    colour = {name: LINE_COLOURS[i % len(LINE_COLOURS)] for i, name in enumerate(parts)}

    charts = (
        _stack_of_energies(figure, history, book, shown, colour, f"Where the work goes, {part}"),
        _every_energy(figure, history, book, [name for name in parts if size[name] > 1.0e-6 * largest], colour, part),
        _ratios(figure, history),
    )
    for chart in charts:
        _name_progress(chart, history)
        chart.margins(x=0.0)
    return figure


def _stack_of_energies(
    figure: Figure,
    history: History,
    book: Mapping[str, np.ndarray],
    shown: Sequence[str],
    colour: Mapping[str, str],
    title: str,
) -> Axes:
    stack = new_axes(figure, 1, 3, 1, title=title, ylabel="energy [J]")
    below = np.zeros(history.frame_count)
    for name in shown:
        place, above = _against(history, below + np.maximum(book[name], 0.0))
        stack.fill_between(place, below, above, facecolor=colour[name], alpha=0.8, linewidth=0.0, label=words(name))
        below = above
    if "supplied" in book:
        stack.plot(*_against(history, book["supplied"]), color=INK, linestyle=(0, (4, 2)), label="supplied work")
    stack.set_ylim(bottom=0.0)
    if shown:
        handles, labels = stack.get_legend_handles_labels()
        stack.legend(handles[::-1], labels[::-1], loc="upper left", frameon=False, fontsize=9)
    return stack


def _every_energy(
    figure: Figure,
    history: History,
    book: Mapping[str, np.ndarray],
    names: Sequence[str],
    colour: Mapping[str, str],
    part: str,
) -> Axes:
    largest = max((float(np.abs(values).max(initial=0.0)) for values in book.values()), default=0.0) or 1.0
    every = new_axes(figure, 1, 3, 2, title=f"Every energy, {part}", ylabel="energy [J]", yscale="log")
    for i, name in enumerate(names):  # the largest first, so that no energy is hidden
        values = np.where(book[name] > 0.0, book[name], np.nan)
        style = ("-", "--")[i // len(LINE_COLOURS) % 2]
        every.plot(*_against(history, values), style, color=colour[name], linewidth=1.5, label=words(name))
    every.set_ylim(1.0e-6 * largest, 2.0 * largest)
    every.minorticks_off()  # of many decades they say nothing, and take as long to lay out as all the rest
    add_legend(every, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return every


def _ratios(figure: Figure, history: History) -> Axes:
    ratios = new_axes(figure, 1, 3, 3, title="Ratios that judge the run", ylabel="ratio [%]", yscale="log")
    for label, values in history.energy_ratios.items():
        ratios.plot(*_against(history, values), color=LINE_COLOURS[len(ratios.lines)], label=label)
    ratios.minorticks_off()
    drawn = np.concatenate([np.asarray(line.get_ydata(), dtype=float) for line in ratios.lines] or [np.ones(1)])
    drawn = drawn[np.isfinite(drawn)]
    lowest, highest = (float(drawn.min()), float(drawn.max())) if len(drawn) else (0.1, 10.0)
    ratios.set_ylim(max(0.5 * lowest, 1.0e-4), 2.0 * max(highest, 1.0e-3))
    add_legend(ratios, loc="upper left", bbox_to_anchor=(0.0, -0.12))
    return ratios


def _against(history: History, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values over the stroke [mm], or over time [ms] if there is no stroke."""
    if np.ptp(history.stroke) > 0.0:
        return 1.0e3 * history.stroke, values
    return 1.0e3 * history.time, values


def _name_progress(chart: Axes, history: History) -> None:
    chart.set_xlabel("stroke [mm]" if np.ptp(history.stroke) > 0.0 else "time [ms]")
