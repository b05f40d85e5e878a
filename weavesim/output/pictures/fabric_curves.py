"""The curves of a fabric in one picture, with how far they are trusted."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING

from .style import ACCENT, FAINT, GREY, LINE_COLOURS, add_legend, new_axes, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ...measures.fabric_curves import CurveSet

CAPTION = (
    "Grey: where the measured points are trusted. Dotted: the end of the data, beyond which a curve is extrapolated.\n"
    "Light band: the first curve with each of its numbers at either end of its range, one at a time."
)


def fabric_curves(name: str, sets: Sequence[CurveSet]) -> Figure:
    """One chart for each set of curves; shear has a second one of its beginning."""
    figure = new_figure(15.0, 8.4)
    figure.suptitle("\n".join(textwrap.wrap(name, 100)), x=0.01, ha="left", fontsize=13, fontweight="bold")
    charts = [(one, False) for one in sets]
    charts.insert(1, (sets[0], True))
    for k, (one, is_start) in enumerate(charts):
        axes = new_axes(
            figure, 2, (len(charts) + 1) // 2, k + 1, ylabel=one.y_label,
            title=f"{one.title}, its beginning" if is_start else one.title,
            xlabel="\n".join(filter(None, [one.x_label, "" if is_start else one.note])),
        )  # fmt: skip
        _chart(axes, one, is_start)
    figure.supxlabel(CAPTION, fontsize=9, color=GREY, x=0.01, ha="left")
    return figure


def _chart(axes: Axes, curves: CurveSet, is_start: bool) -> None:
    first, end = curves.lines[0], curves.measured_to
    if curves.trusted is not None:
        low, high = max(curves.trusted[0], first.x[0]), min(curves.trusted[1], first.x[-1])
        label = f"trusted, {low:.3g} to {high:.3g}"
        axes.axvspan(low, high, facecolor="#e9ebef", edgecolor=FAINT, zorder=0, linewidth=0.6, label=label)
    if curves.band is not None:
        x, low_values, high_values = curves.band
        axes.fill_between(x, low_values, high_values, color=ACCENT, alpha=0.13, linewidth=0.0)
    for k, line in enumerate(curves.lines):
        style = "-" if k % 2 == 0 else (0, (5, 2))
        axes.plot(line.x, line.y, linestyle=style, color=LINE_COLOURS[k % len(LINE_COLOURS)], label=line.label)
    if end is not None and not is_start:
        axes.axvline(end, color=FAINT, linestyle=":", linewidth=1.4, label=f"end of the data, {end:.3g}")
    axes.axhline(0.0, color=FAINT, linewidth=0.8)
    axes.set_xlim(0.0, _start(curves) if is_start else first.x[-1])
    if shown := curves.shown_ordinates(_start(curves) if is_start else None):
        axes.set_ylim(*shown)
    if not is_start and (len(curves.lines) > 1 or curves.trusted is not None):
        add_legend(axes, loc="best")


def _start(curves: CurveSet) -> float:
    """The first quarter, at most 12 degrees."""
    return min(0.25 * float(curves.lines[0].x[-1]), 12.0)
