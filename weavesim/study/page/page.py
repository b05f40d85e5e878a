"""``study.html``: one file with all that a study found, which needs no network."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ...errors import InputError
from ...output.files import write_text
from ...output.report.page import rendered, shown
from ...version import __version__
from ..analysis.results import Point, StudyResults

FILE_NAME = "study.html"
# Of the charts.
CONFIGURATION = {"displaylogo": False, "responsive": True}
# Rows of the table in the page; runs.csv has all.
LARGEST_TABLE = 2000


def check_page() -> None:
    """Check that the page can be drawn, before anything is computed.

    Raises:
        InputError: plotly is not installed.
    """
    from importlib.util import find_spec

    if find_spec("plotly") is None:
        raise InputError("weavesim study: it draws with plotly, which is not installed: pip install 'weavesim[study]'")


def write_page(path: Path, results: StudyResults, *, best: str = "") -> None:
    """Write the page.

    Args:
        path: of the file.
        results: of the study.
        best: link to the page of the best run, relative to the page; "" for none.
    """
    from plotly.io import to_html
    from plotly.offline import get_plotlyjs

    from .charts import charts

    drawn = [
        (
            name, caption,
            to_html(figure, full_html=False, include_plotlyjs=False, div_id=name, config=CONFIGURATION),
        )
        for name, caption, figure in charts(results)
    ]  # fmt: skip
    write_text(
        path,
        rendered(
            str(__package__), title=results.table.name, subtitle=_subtitle(results), tiles=list(_tiles(results)),
            remarks=list(results.remarks()), charts=drawn, script=get_plotlyjs(), best=best,
            headings=_headings(results), rows=[_row(results, point) for point in results.points[:LARGEST_TABLE]],
            left_out=max(len(results.points) - LARGEST_TABLE, 0), measures=list(_measures(results)),
            best_lines=_best_lines(results), decided=_decided(results), version=__version__,
        ),
    )  # fmt: skip


def _subtitle(results: StudyResults) -> str:
    words = {
        "factorial": "all combinations", "latin-hypercube": "a Latin hypercube", "sobol": "Sobol's design",
        "optimise": "a robust optimisation" if results.table.scatter else "an optimisation",
    }  # fmt: skip
    names = ", ".join(factor.name for factor in results.factors)
    return f"{results.table.job}: {words[results.table.method]} over {names}"


def _tiles(results: StudyResults) -> Iterator[tuple[str, str]]:
    finished = sum(answer.status == "finished" for answer in results.answers)
    yield "points", shown(len(results.points))
    yield "runs", shown(results.run_count)
    yield "finished", f"{finished} of {len(results.answers)}"
    if results.best is not None:
        for measure in results.goals:
            noise = results.noise(measure)
            value = shown(results.best.measure(results.key(measure)))
            yield f"best {results.label(measure)}", f"{value} ± {shown(noise.deviation)}" if noise else value


def _best_lines(results: StudyResults) -> list[tuple[str, str]]:
    if results.best is None:
        return []
    return [
        (factor.name, factor.shown(value))
        for factor, value in zip(results.controlled, results.best.values, strict=True)
    ]


def _decided(results: StudyResults) -> str:
    """What made one point of several on the front the best."""
    if len(results.goals) < 2 or len(results.front) < 2:
        return ""
    first = results.goals[0]
    return (
        f"Of {len(results.front)} points on the Pareto front the one with the {first.goal} {first.name}, the study's "
        "first goal."
    )


def _measures(results: StudyResults) -> Iterator[tuple[str, str, str, str]]:
    """Name, range over the study, noise, and whether differences say anything."""
    for measure in results.measures:
        _, values = results.measured(measure)
        noise, chance = results.noise(measure), results.chance(measure)
        extent = f"{shown(min(values))} to {shown(max(values))}" if values else "–"
        if noise is None or chance is None:
            yield results.label(measure), extent, "not estimated", "unknown"
            continue
        says = "more than noise" if chance <= 0.05 else "no more than noise"
        yield (
            results.label(measure), extent, f"± {shown(noise.deviation)} ({shown(noise.low)} to {shown(noise.high)})",
            f"{says} (p = {chance:.2g})",
        )  # fmt: skip


def _headings(results: StudyResults) -> list[str]:
    own = [factor.label for factor in results.controlled]
    measures = [results.label(measure) for measure in results.measures]
    spreads = [f"scatter of {label}" for label in measures] if results.table.scatter else []
    return ["point", *own, *measures, *spreads, "verdict"]


def _row(results: StudyResults, point: Point) -> dict[str, Any]:
    cells = [str(point.number)]
    cells += [
        shown(value) if factor.is_numeric else factor.shown(value)
        for factor, value in zip(results.controlled, point.values, strict=True)
    ]
    cells += [shown(point.measure(results.key(measure))) for measure in results.measures]
    if results.table.scatter:
        cells += [shown(point.spread(results.key(measure))) for measure in results.measures]
    is_best = results.best is not None and results.best.number == point.number
    return {"cells": [*cells, point.verdict or "–"], "best": is_best, "bad": point.worth.violation > 0.0}
