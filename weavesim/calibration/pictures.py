"""Pictures of a calibration: measured beside fitted curves with their residuals, intervals, correlations."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from ..output.pictures.style import ACCENT, FAINT, GREY, INK, LINE_COLOURS, MEASURED, add_legend, new_axes, new_figure
from .fitting.fit import Fit
from .fitting.reduction import LARGEST_DEVIATION
from .result import FITTED, Calibration, Estimate
from .series import Series

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Draws of the parameters for the band of a fitted curve.
DRAW_COUNT = 80
LONGEST_NAME = 34


def pictures(calibration: Calibration) -> Iterator[tuple[str, Figure, str]]:
    """Name, figure and caption of every picture."""
    if calibration.shear:
        if calibration.shear.frames:
            yield "picture_frame", shear_figure(calibration, False), _caption(calibration, "picture frame")
        if calibration.shear.strips:
            yield "bias_extension", shear_figure(calibration, True), _caption(calibration, "bias extension")
        yield "shear_law", law_figure(calibration), (
            "The shear law: elastic curve and friction, with the 95 % intervals of what was fitted, beside the law of "
            "the given fabric."
        )  # fmt: skip
    if "curves" in calibration.check:
        yield "check_with_scene", check_figure(calibration), (
            "Bias extension simulated with the calibrated fabric, beside the closed form that was fitted and the "
            f"measurement. With {calibration.check['mesh_size_mm']:.3g} mm the mesh shears its central zone to "
            f"{calibration.check['zone_c_angle_deg']:.1f} instead of {calibration.check['kinematic_angle_deg']:.1f} "
            "degrees, so its force is lower (docs/theory.md, section 9)."
        )  # fmt: skip
    if calibration.cell:
        yield "biaxial", cell_figure(calibration), _caption(calibration, "biaxial")
    if calibration.bending:
        yield "bending", bending_figure(calibration), "Bending stiffness of every specimen, mean and 95 % interval."
    for name, fit in fits(calibration):
        if len(fit.chosen) > 1:
            yield f"correlations_{name.replace(' ', '_')}", correlation_figure(fit, name), (
                f"Correlations of the parameters of the {name}: near 1 or -1 the data hardly tell two apart."
            )  # fmt: skip
    if calibration.cell and len(calibration.cell.reduced.whole.chosen) > 1:
        yield "told_apart", told_figure(calibration.cell.reduced.whole), (
            "How well the biaxial data determine the parameters of the unit cell: each bar is an independent "
            "combination of them; beyond the line it is not determined."
        )  # fmt: skip
    yield (
        "intervals",
        interval_figure(calibration),
        ("Fitted values over those of the given fabric, with 95 % intervals; a hollow mark was held."),
    )


def fits(calibration: Calibration) -> list[tuple[str, Fit]]:
    """Name and fit of each part that was fitted."""
    parts = (("unit cell", calibration.cell), ("shear", calibration.shear))
    return [(name, part.reduced.fit) for name, part in parts if part is not None]


def _caption(calibration: Calibration, test: str) -> str:
    found = next(r for r in calibration.residuals if r.test == test)
    return (
        f"{test.capitalize()}: measured points, fitted curve with its 95 % band, and residuals (root mean square "
        f"{found.root_mean_square:.3g} {found.unit}, systematic {found.systematic:.3g}; {found.source} "
        f"{found.scatter:.3g} {found.unit}, the grey band)."
    )


def draws(fit: Fit) -> np.ndarray:
    """Values of all unknowns drawn from the covariance of the fit, (d, p)."""
    rng = np.random.default_rng(0)
    result = np.tile(fit.values, (DRAW_COUNT, 1))
    if not len(fit.chosen):
        return result
    values, vectors = np.linalg.eigh(fit.covariance)
    # as wide as the intervals, which are those of Student's t
    wider = fit.half_width[fit.chosen] / (1.96 * fit.deviation[fit.chosen])
    steps = (
        wider[:, None]
        * (vectors * np.sqrt(np.clip(values, 0.0, 1.0)))
        @ (rng.standard_normal((len(fit.chosen), DRAW_COUNT)))
    )
    for row, k in enumerate(fit.chosen):
        unknown = fit.problem.unknowns[int(k)]
        drawn = unknown.outer(unknown.inner(fit.values[k]) + steps[row])
        result[:, k] = np.clip(drawn, unknown.low, unknown.high)
    return result


def _two_charts(title: str, y_label: str, x_label: str) -> tuple[Figure, Axes, Axes]:
    figure = new_figure(9.0, 6.0)
    grid = figure.add_gridspec(2, 1, height_ratios=(3.0, 1.0))
    above = new_axes(figure, grid[0], title=title, ylabel=y_label)
    below = new_axes(figure, grid[1], xlabel=x_label, ylabel="residual")
    above.tick_params(labelbottom=False)
    return figure, above, below


def shear_figure(calibration: Calibration, is_bias: bool) -> Figure:
    """Measured and fitted moments of frames, or forces of strips, against the angle."""
    part = calibration.shear
    assert part is not None
    tests = part.strips if is_bias else part.frames
    fit, model = part.reduced.fit, part.model
    name, y_label = ("Bias extension", "force [N]") if is_bias else ("Picture frame", "shear moment [N/m]")
    x_label = "kinematic shear angle of the central zone [degrees]" if is_bias else "shear angle [degrees]"
    figure, above, below = _two_charts(name, y_label, x_label)
    end = max(float(test.x.max()) for test in tests)
    angle = np.concatenate([np.radians(np.arange(0.0, min(math.degrees(end), 3.0), 0.1)), np.linspace(0.05, end, 120)])
    angle = np.unique(angle[angle <= end])
    back = any(test.unloads for test in tests)
    path = np.degrees(np.concatenate([angle, angle[::-1]]) if back else angle)
    curves = np.array([model.band(angle, values, is_bias, back=back) for values in draws(fit)])
    low, high = np.percentile(curves, [2.5, 97.5], axis=0)
    for piece in (slice(0, len(angle)), slice(len(angle), None)):
        above.fill_between(path[piece], low[piece], high[piece], color=ACCENT, alpha=0.2, linewidth=0.0)
    above.plot(path, model.band(angle, fit.values, is_bias, back=back), color=ACCENT, label="fitted, 95 % band")
    for k, test in enumerate(tests):
        _points(above, np.degrees(test.x), test.y, k, _label(test, len(tests)))
    scatter = part.scatters["bias extension" if is_bias else "picture frame"]
    width = np.maximum(scatter.at(angle), scatter.yardstick if len(tests) == 1 else 0.0)
    below.fill_between(np.degrees(angle), -width, width, color=FAINT, alpha=0.35, linewidth=0.0)
    start = 0
    for (test, bias), k in zip(model.tests, _own_numbers(part.model.tests), strict=True):
        rows = slice(start, start + len(test.x))
        start += len(test.x)
        if bias == is_bias:
            _points(below, np.degrees(test.x), (fit.predicted - fit.problem.observed)[rows], k, "")
    below.axhline(0.0, color=GREY, linewidth=0.8)
    for chart in (above, below):
        chart.set_xlim(0.0, math.degrees(end) * 1.01)
    add_legend(above, loc="upper left")
    return figure


def _own_numbers(tests: tuple[tuple[Series, bool], ...]) -> list[int]:
    seen = {False: -1, True: -1}
    result = []
    for _, is_bias in tests:
        seen[is_bias] += 1
        result.append(seen[is_bias])
    return result


def _points(chart: Axes, x: np.ndarray, y: np.ndarray, k: int, label: str) -> None:
    colour = MEASURED if k == 0 else LINE_COLOURS[(k + 3) % len(LINE_COLOURS)]
    chart.plot(x, y, "o", markersize=3.0, markerfacecolor="none", color=colour, label=label or None)


def _label(test: Series, count: int) -> str:
    return "measured" if count == 1 else f"specimen {test.label}" if test.label else test.place[-LONGEST_NAME:]


def law_figure(calibration: Calibration) -> Figure:
    """Elastic curve and friction, with intervals, beside the given law."""
    part = calibration.shear
    assert part is not None
    figure = new_figure(9.0, 4.6)
    chart = new_axes(figure, 1, 1, 1, title="Shear law", xlabel="shear angle [degrees]", ylabel="shear moment [N/m]")
    end = float(part.model.knots[-1])
    angle = np.linspace(0.0, end, 200)
    fabric, base = calibration.fabric, calibration.base
    chart.plot(np.degrees(angle), fabric.shear.moment(angle, fabric.thickness), color=ACCENT, label="elastic")
    if fabric.shear_friction is not None:
        limit = fabric.shear_friction.limit_under(angle, np.zeros_like(angle))
        chart.plot(np.degrees(angle), limit, color=LINE_COLOURS[1], label="limit of friction")
    given = base.shear.moment(angle, base.thickness)
    chart.plot(np.degrees(angle), given, color=INK, linestyle=(0, (4, 3)), linewidth=1.2, label="elastic, given fabric")
    for e, at in zip(calibration.estimates["shear"], part.model.knots[1:], strict=False):
        if e.has_interval:
            error = [[max(e.value - e.low, 0.0)], [max(e.high - e.value, 0.0)]]
            chart.errorbar(math.degrees(at), e.value, error, color=ACCENT, capsize=3, marker="o", markersize=3.5)
    chart.set_xlim(0.0, math.degrees(end) * 1.02)
    chart.set_ylim(bottom=0.0)
    add_legend(chart, loc="upper left")
    return figure


def check_figure(calibration: Calibration) -> Figure:
    """Force of the simulated strip, of the closed form, and measured."""
    curves = calibration.check["curves"]
    figure = new_figure(9.0, 4.4)
    chart = new_axes(figure, 1, 1, 1, title="Check: bias extension simulated", ylabel="force [N]")
    chart.set_xlabel("kinematic shear angle of the central zone [degrees]")
    angle = curves["kinematic_angle_deg"]
    chart.plot(angle, curves["force_n"], color=ACCENT, label="simulated")
    chart.plot(angle, curves["closed_form_force_n"], color=INK, linestyle=(0, (4, 3)), label="closed form")
    chart.plot(angle, curves["measured_force_n"], "o", color=MEASURED, markerfacecolor="none", label="measured, mean")
    add_legend(chart, loc="upper left")
    return figure


def cell_figure(calibration: Calibration) -> Figure:
    """Measured and fitted forces of every ratio of strains, warp and weft."""
    from .cell import ratios

    part = calibration.cell
    assert part is not None
    fit, model = part.reduced.fit, part.model
    members = ratios(part.tests)
    count = max(members) + 1
    figure = new_figure(min(4.6 * count, 15.0), 5.2)
    grid = figure.add_gridspec(2, count, height_ratios=(3.0, 1.0))
    ends = np.cumsum([0, *(len(test.lines) for test in part.tests)])
    difference = (fit.predicted - fit.problem.observed).reshape(-1, 2)
    band = draws(fit)[:40]
    for ratio in range(count):
        own = [k for k, member in enumerate(members) if member == ratio]
        test = part.tests[own[0]]
        end = test.strain[int(np.argmax(np.linalg.norm(test.strain, axis=1)))]
        title = f"strains {_ratio(end)}"
        above = new_axes(figure, grid[0, ratio], title=title, ylabel="force [kN/m]" if ratio == 0 else "")
        below = new_axes(figure, grid[1, ratio], xlabel="largest strain [%]", ylabel="residual" if ratio == 0 else "")
        above.tick_params(labelbottom=False)
        share = np.linspace(0.0, 1.0, 40)
        strain = share[:, None] * end
        axis = 100.0 * share * np.abs(end).max()
        forces = 1e-3 * model.forces(np.concatenate([fit.values[None], band]), strain)
        low, high = np.nanpercentile(forces[1:], [2.5, 97.5], axis=0)
        for f, (yarn, colour) in enumerate((("warp", ACCENT), ("weft", LINE_COLOURS[1]))):
            above.fill_between(axis, low[:, f], high[:, f], color=colour, alpha=0.2, linewidth=0.0)
            above.plot(axis, forces[0, :, f], color=colour, label=f"{yarn}, fitted")
            for n, k in enumerate(own):
                place = 100.0 * np.abs(part.tests[k].strain).max(axis=1)
                label = f"{yarn}, measured" if n == 0 else None
                style: Any = {"markersize": 2.6, "markerfacecolor": "none", "color": colour, "alpha": 0.6}
                above.plot(place, 1e-3 * part.tests[k].force[:, f], "o", label=label, **style)
                below.plot(place, 1e-3 * difference[ends[k] : ends[k + 1], f], "o", **style)
        below.axhline(0.0, color=GREY, linewidth=0.8)
        width = 1e-3 * part.scatters["biaxial"].yardstick
        below.axhspan(-width, width, color=FAINT, alpha=0.35, linewidth=0.0)
        if ratio == 0:
            add_legend(above, loc="upper left")
    return figure


def _ratio(end: np.ndarray) -> str:
    size = np.abs(end).max()
    return ":".join(f"{value:.2g}" for value in (end / size if size > 0.0 else end))


def bending_figure(calibration: Calibration) -> Figure:
    """Stiffness of every specimen."""
    part = calibration.bending
    assert part is not None
    figure = new_figure(9.0, 3.6)
    chart = new_axes(figure, 1, 1, 1, title="Bending stiffness", xlabel="overhang [mm]", ylabel="D [mN m]")
    for k, estimate in enumerate(part.estimates):
        own = [strip for strip in part.strips if strip.yarn in (estimate.yarn, "both")]
        colour = LINE_COLOURS[k]
        name = "" if estimate.yarn == "both" else f"{estimate.yarn}, "
        chart.plot(
            [1e3 * strip.overhang for strip in own], [1e3 * strip.stiffness for strip in own], "o", color=colour,
            markerfacecolor="none", label=f"{name}specimens",
        )  # fmt: skip
        chart.axhline(1e3 * estimate.value, color=colour, label=f"{name}mean, 95 % interval")
        if math.isfinite(estimate.low):
            chart.axhspan(1e3 * estimate.low, 1e3 * estimate.high, color=colour, alpha=0.15, linewidth=0.0)
    chart.margins(y=0.2)
    add_legend(chart, loc="best")
    return figure


def correlation_figure(fit: Fit, name: str) -> Figure:
    """Correlations of what was fitted."""
    names = [_short(fit.problem.unknowns[int(k)].name) for k in fit.chosen]
    size = 2.8 + 0.42 * len(names)
    figure = new_figure(size + 1.2, size)
    chart = new_axes(figure, 1, 1, 1, title=f"Correlations, {name}")
    chart.grid(False)
    image = chart.imshow(fit.correlation, cmap="RdBu_r", vmin=-1.0, vmax=1.0)
    chart.set_xticks(range(len(names)), names, rotation=60, ha="right", fontsize=8)
    chart.set_yticks(range(len(names)), names, fontsize=8)
    for i, row in enumerate(fit.correlation):
        for j, value in enumerate(row):
            colour = "white" if abs(value) > 0.6 else INK
            chart.text(j, i, f"{value:.1f}", ha="center", va="center", fontsize=7, color=colour)
    figure.colorbar(image, ax=chart, shrink=0.8)
    return figure


def _short(name: str) -> str:
    return name.replace("moment_at_", "m ").replace("_deg", "°").replace("_", " ")


def told_figure(fit: Fit) -> Figure:
    """Standard deviation along every singular direction, with the parameters in it."""
    chosen = [int(k) for k in fit.chosen]
    _, values, rows = np.linalg.svd(fit.jacobian[:, chosen], full_matrices=False)
    count = max(len(fit.residual) - len(chosen), 1)
    noise = max(1.0, math.sqrt(float(fit.residual @ fit.residual) / count))
    deviation = np.minimum(noise / np.maximum(values, 1.0e-300), 1.0e4)
    figure = new_figure(9.0, 1.4 + 0.55 * len(chosen))
    title = f"What the data tell apart (condition number {fit.condition:.2g})"
    chart = new_axes(figure, 1, 1, 1, title=title, xscale="log")
    chart.set_xlabel("standard deviation of the logarithm (0.1 is 10 %)")
    labels = []
    for row in rows:
        order = np.argsort(-np.abs(row))
        names = [f"{row[k]:+.2f} {_short(fit.problem.unknowns[chosen[k]].name)}" for k in order if abs(row[k]) > 0.2]
        labels.append("  ".join(names[:3]))
    colours = [MEASURED if value > LARGEST_DEVIATION else ACCENT for value in deviation]
    chart.barh(range(len(chosen)), deviation, color=colours)
    chart.axvline(LARGEST_DEVIATION, color=INK, linestyle=(0, (4, 3)), linewidth=1.2)
    chart.set_yticks(range(len(chosen)), labels, fontsize=8)
    chart.invert_yaxis()
    return figure


def interval_figure(calibration: Calibration) -> Figure:
    """Every value over that of the given fabric."""
    entries: list[Estimate] = [
        e for part in calibration.estimates.values() for e in part if e.given == e.given and e.given > 0.0
    ]
    figure = new_figure(9.0, 1.3 + 0.3 * max(len(entries), 2))
    chart = new_axes(figure, 1, 1, 1, title="Calibrated over given values", xlabel="ratio", xscale="log")
    for row, e in enumerate(entries):
        value = max(e.value / e.given, 1.0e-3)
        if e.has_interval:
            reach = [max(e.low / e.given, 1.0e-3), min(e.high / e.given, 1.0e3)]
            chart.plot(reach, [row, row], color=ACCENT, linewidth=2.4, alpha=0.5)
        chart.plot(value, row, "o", color=ACCENT, markerfacecolor=ACCENT if e.state == FITTED else "white")
    chart.axvline(1.0, color=INK, linestyle=(0, (4, 3)), linewidth=1.0)
    chart.set_yticks(range(len(entries)), [_short(e.name) for e in entries], fontsize=8)
    chart.invert_yaxis()
    return figure
