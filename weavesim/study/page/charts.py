"""Charts of a study, by plotly: the values stay readable under the mouse, and the page needs no network."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from ..analysis.results import Point, StudyResults
from ..schema import MeasureTable

if TYPE_CHECKING:
    import plotly.graph_objects as go

    from ..factors import Factor

INK, GREY, LINE, ACCENT, WARM = "#1d2129", "#5d6572", "#d9dde3", "#3a5a8c", "#c2571a"
SERIES = (ACCENT, WARM, "#1d7a6b", "#8a6d1d", "#2f6fb0", "#a03b6b", "#5f6b2e", "#444444")
# Decades of a log axis with more than one tick in each.
MOST_DECADES = 4
# More responses than this are left to the reader of the table.
LARGEST_PANEL_COUNT = 24
# Points of a panel that a browser still draws quickly one by one.
MOST_IN_SVG = 500
REPEATS = "repeats"
# Lines that can still be told apart, and drawn without a graphics card.
MOST_LINES = 1000


def charts(results: StudyResults) -> Iterator[tuple[str, str, go.Figure]]:
    """Identifier, caption and figure of every chart that the study has something for."""
    if len(results.points) > 1:
        yield "parallel", (
            "Parallel coordinates: each line is a point of the study. Drag along an axis to keep only the lines that "
            "pass there." + (f" Of {len(results.points)} points about {MOST_LINES} are shown." if
                             len(results.points) > MOST_LINES else "")
        ), parallel_coordinates(results)  # fmt: skip
    for index, measure in enumerate(results.measures):
        noise = results.noise(measure)
        bars = (
            f"Error bars: numerical noise, one standard deviation of a single run ({noise.deviation:.3g}, 95 % "
            f"interval {noise.low:.3g} to {noise.high:.3g}, from {noise.points} points); differences below "
            f"{noise.least_difference:.3g} may be chance. Small crosses: the repeats."
            if noise is not None
            else "No error bars: the noise was not estimated; [noise] does it."
        )
        if results.table.scatter:
            bars = "Error bars: standard deviation over the scenarios."
        yield f"response-{index}", f"Response: {results.label(measure)}. {bars}", response(results, measure)
    if len(results.goals) > 1:
        yield "pareto", "Pareto front: no other point is better in one goal and not worse in another.", pareto(results)
    if results.table.method == "optimise":
        yield "history", "The optimisation: each point as it was tried, and the best so far.", history(results)
    if any(results.effects(measure) for measure in results.measures):
        yield "sensitivity", _sensitivity_caption(results), sensitivity(results)


def _layout(figure: go.Figure, height: int = 420) -> go.Figure:
    figure.update_layout(
        template="simple_white", height=height, margin={"l": 70, "r": 30, "t": 30, "b": 60},
        font={"family": 'system-ui, "Segoe UI", Helvetica, Arial, sans-serif', "size": 13, "color": INK},
        legend={"orientation": "h", "y": -0.22}, colorway=list(SERIES),
    )  # fmt: skip
    return figure


def _axis_value(factor: Factor, value: Any) -> Any:
    return value if factor.is_numeric else factor.shown(value)


def parallel_coordinates(results: StudyResults) -> go.Figure:
    """One line for each point that has all measures."""
    import plotly.graph_objects as go

    points = [p for p in results.points if all(p.measure(results.key(m)) is not None for m in results.measures)]
    points = points[:: -(-len(points) // MOST_LINES) or 1]
    dimensions: list[dict[str, Any]] = []
    for k, factor in enumerate(results.controlled):
        if factor.is_numeric:
            dimensions.append({"label": factor.label, "values": [point.values[k] for point in points]})
            continue
        texts = [factor.shown(choice) for choice in factor.choices]
        places = [texts.index(factor.shown(point.values[k])) for point in points]
        dimensions.append(
            {"label": factor.label, "values": places, "tickvals": list(range(len(texts))), "ticktext": texts}
        )
    for measure in results.measures:
        values = [point.measure(results.key(measure)) for point in points]
        dimensions.append({"label": results.label(measure), "values": values})
    first = (results.goals or results.measures)[0]
    colour = [point.measure(results.key(first)) for point in points]
    figure = go.Figure(
        go.Parcoords(
            dimensions=dimensions, labelangle=-12, labelside="top",
            line={"color": colour, "colorscale": "Viridis", "showscale": True, "colorbar": {"title": first.name}},
        )
    )  # fmt: skip
    return _layout(figure).update_layout(margin={"l": 80, "r": 40, "t": 90, "b": 30})


def response(results: StudyResults, measure: MeasureTable) -> go.Figure:
    """A panel for each factor: the measure against it, with error bars."""
    from plotly.subplots import make_subplots

    factors = results.controlled[:LARGEST_PANEL_COUNT]
    columns = min(len(factors), 3)
    rows = -(-len(factors) // columns)
    figure = make_subplots(rows=rows, cols=columns, shared_yaxes=True, horizontal_spacing=0.05)
    for k, factor in enumerate(factors):
        place = {"row": k // columns + 1, "col": k % columns + 1}
        for trace in _response_traces(results, measure, k):
            # repeats are in every panel, series are each panel's own
            trace.showlegend = bool(trace.name) and (k == 0 or trace.name != REPEATS)
            figure.add_trace(trace, **place)
        figure.update_xaxes(
            title={"text": factor.label}, **(log_axis(factor) if factor.scale == "log" else {}), **place
        )
        if k % columns == 0:
            figure.update_yaxes(title={"text": results.label(measure)}, **place)
    return _layout(figure, 130 + 300 * rows)


def log_axis(factor: Factor) -> dict[str, Any]:
    """A log axis whose ticks are 1, 2 and 5 times powers of ten, or these alone over many decades, written in full."""
    decades = range(math.floor(math.log10(factor.low)), math.ceil(math.log10(factor.high)) + 1)
    steps = (1, 2, 5) if len(decades) <= MOST_DECADES else (1,)
    ticks = [step * 10.0**decade for decade in decades for step in steps]
    shown = [tick for tick in ticks if 0.999 * factor.low <= tick <= 1.001 * factor.high]
    if len(shown) < 2:
        shown = [factor.low, math.sqrt(factor.low * factor.high), factor.high]
    return {"type": "log", "tickvals": shown, "ticktext": [f"{tick:.3g}" for tick in shown]}


def _response_traces(results: StudyResults, measure: MeasureTable, k: int) -> Iterator[Any]:
    import plotly.graph_objects as go

    factor, key = results.controlled[k], results.key(measure)
    points, values = results.measured(measure)
    noise = results.noise(measure)
    for name, group in _series(results, points, k).items():
        chosen = [(point, value) for point, value in zip(points, values, strict=True) if point in group]
        if factor.is_numeric:
            chosen.sort(key=lambda item: item[0].values[k])  # type: ignore[arg-type, return-value]
        spread = [point.spread(key) for point, _ in chosen]
        bars = spread if results.table.scatter else [noise.deviation if noise else None] * len(chosen)
        scatter = go.Scattergl if len(points) > MOST_IN_SVG else go.Scatter
        connected = results.table.method == "factorial" and len(results.controlled) <= 2
        yield scatter(
            x=[_axis_value(factor, point.values[k]) for point, _ in chosen], y=[value for _, value in chosen],
            mode="lines+markers" if connected else "markers", name=name,
            error_y={"type": "data", "array": bars, "visible": any(bar is not None for bar in bars), "thickness": 1.2},
            marker=_marker(results, [point for point, _ in chosen], coloured=not name), line={"width": 1.5},
            text=[_told(results, point) for point, _ in chosen], hoverinfo="text+y",
        )  # fmt: skip
    repeats = [(point, answer.number(key)) for point in results.points for answer in point.repeats]
    if repeats:
        yield go.Scatter(
            x=[_axis_value(factor, point.values[k]) for point, _ in repeats], y=[value for _, value in repeats],
            mode="markers", name=REPEATS, marker={"symbol": "x-thin", "size": 7, "line": {"width": 1, "color": GREY}},
            hoverinfo="y",
        )  # fmt: skip


def _series(results: StudyResults, points: Sequence[Point], k: int) -> dict[str, list[Point]]:
    """Points by the value of the other factor, where a factorial study has two; else all of them without a name."""
    if results.table.method != "factorial" or len(results.controlled) != 2:
        return {"": list(points)}
    other = results.controlled[1 - k]
    groups: dict[str, list[Point]] = {}
    for point in points:
        groups.setdefault(f"{other.name} {other.shown(point.values[1 - k])}", []).append(point)
    return groups


def _marker(results: StudyResults, points: Sequence[Point], *, coloured: bool) -> dict[str, Any]:
    """The best point as a star, and those that are not good as rings."""
    symbols = [_symbol(results, point) for point in points]
    colour = {"color": ACCENT} if coloured else {}
    size = 8 if len(points) <= MOST_IN_SVG else 4
    return {"symbol": symbols, "size": [15 if symbol == "star" else size for symbol in symbols], **colour}


def _symbol(results: StudyResults, point: Point) -> str:
    if results.best is not None and point.number == results.best.number:
        return "star"
    return "circle" if point.worth.violation <= 0.0 else "circle-open"


def _told(results: StudyResults, point: Point) -> str:
    pairs = zip(results.controlled, point.values, strict=True)
    return "<br>".join([f"point {point.number}", *(f"{factor.name} {factor.shown(v)}" for factor, v in pairs)])


def pareto(results: StudyResults) -> go.Figure:
    """The first two goals against each other."""
    import plotly.graph_objects as go

    first, second = results.goals[:2]
    keys = results.key(first), results.key(second)
    figure = go.Figure()
    for name, group, colour in (("points", results.good, GREY), ("front", results.front, ACCENT)):
        ordered = sorted(group, key=lambda point: point.measure(keys[0]) or 0.0)
        noise = [results.noise(measure) for measure in (first, second)] if name == "front" else [None, None]
        bars = [{"type": "constant", "value": each.deviation} if each else None for each in noise]
        figure.add_trace(
            go.Scatter(
                x=[point.measure(keys[0]) for point in ordered], y=[point.measure(keys[1]) for point in ordered],
                error_x=bars[0], error_y=bars[1],
                # the front is a staircase only between two goals
                mode="lines+markers" if name == "front" and len(results.goals) == 2 else "markers", name=name,
                line={"shape": "hv", "color": colour}, marker={"color": colour, "size": 9 if name == "front" else 6},
                text=[_told(results, point) for point in ordered],
            )
        )  # fmt: skip
    figure.update_xaxes(title=f"{results.label(first)}, {first.goal}")
    figure.update_yaxes(title=f"{results.label(second)}, {second.goal}")
    return _layout(figure)


def history(results: StudyResults) -> go.Figure:
    """The first goal of each point in order."""
    import plotly.graph_objects as go

    measure = results.goals[0]
    points, values = results.measured(measure)
    best, so_far = [], None
    for point, value in zip(points, values, strict=True):
        if point.worth.violation <= 0.0 and point.worth.goals:
            better = so_far is None or point.worth.goals[0] < so_far[0]
            so_far = (point.worth.goals[0], value) if better else so_far
        best.append(so_far[1] if so_far else None)
    numbers = [point.number for point in points]
    figure = go.Figure(
        [
            go.Scatter(
                x=numbers, y=values, mode="markers", name="tried", text=[_told(results, point) for point in points],
                marker=_marker(results, points, coloured=True),
            ),
            go.Scatter(x=numbers, y=best, mode="lines", name="best so far", line={"shape": "hv"}),
        ]
    )  # fmt: skip
    figure.update_xaxes(title="point")
    figure.update_yaxes(title=results.label(measure))
    return _layout(figure)


def _sensitivity_caption(results: StudyResults) -> str:
    return {
        "sobol": "Sobol's indices with 95 % intervals: the share of the variance that a parameter causes alone "
        "(first), and together with all others (total).",
        "factorial": "Share of the variance of each measure between the values of a parameter; what is left is joint "
        "effects and noise.",
        "optimise": "Rank correlation with each parameter, over the points that the optimiser happened to try: a hint, "
        "no more.",
    }.get(results.table.method, "Rank correlation of each measure with each parameter, from -1 to 1.")  # fmt: skip


def sensitivity(results: StudyResults) -> go.Figure:
    """Bars for each measure and factor."""
    import plotly.graph_objects as go

    figure = go.Figure()
    for k, measure in enumerate(results.measures):
        effects = results.effects(measure)
        if not effects:
            continue
        names = [effect.factor for effect in effects]
        first = [effect.value for effect in effects]
        figure.add_trace(
            go.Bar(
                x=names, y=first, name=measure.name + (" first" if effects[0].kind == "sobol" else ""),
                marker={"color": SERIES[k % len(SERIES)]},
                error_y=_asymmetric(first, [e.low for e in effects], [e.high for e in effects]),
            )
        )  # fmt: skip
        if effects[0].kind == "sobol":
            total = [effect.total or 0.0 for effect in effects]
            figure.add_trace(
                go.Bar(
                    x=names, y=total, name=f"{measure.name} total", opacity=0.45,
                    marker={"color": SERIES[k % len(SERIES)]},
                    error_y=_asymmetric(total, [e.total_low for e in effects], [e.total_high for e in effects]),
                )
            )  # fmt: skip
    title = "index" if results.table.method == "sobol" else "share" if results.table.method == "factorial" else ""
    figure.update_yaxes(title=title or "rank correlation", zeroline=True)
    return _layout(figure)


def _asymmetric(values: list[float], low: list[float | None], high: list[float | None]) -> dict[str, Any] | None:
    if any(end is None for end in (*low, *high)):
        return None
    up = [max((top or 0.0) - value, 0.0) for value, top in zip(values, high, strict=True)]
    down = [max(value - (bottom or 0.0), 0.0) for value, bottom in zip(values, low, strict=True)]
    return {"type": "data", "symmetric": False, "array": up, "arrayminus": down}
