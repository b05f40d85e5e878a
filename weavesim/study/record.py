"""What a study leaves in its folder besides the table and the page: ``runs.csv``, ``study.json``, ``fields.h5``."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Sequence
from pathlib import Path

from ..output.files import plain, write_text
from .analysis.results import StudyResults
from .material_points import FILE_NAME as FIELDS_NAME
from .material_points import SheetPoints, write_fields
from .table import RunTable

TABLE_NAME, SUMMARY_NAME = "runs.csv", "study.json"


def write_runs(path: Path, results: StudyResults) -> None:
    """One line for each run of the study in order: its inputs and measures with all digits, verdict, key, error."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    names = [factor.label for factor in results.factors]
    measures = [results.key(measure) for measure in results.measures]
    writer.writerow(["point", "role", "repeat", *names, *measures, "status", "verdict", "run", "error"])
    for answer in results.answers:
        trial = answer.trial
        numbers = [answer.numbers.get(name) for name in measures]
        cells = ["" if value is None else repr(value) for value in numbers]
        values = [value if isinstance(value, str) else json.dumps(value) for value in trial.values]
        end = (answer.status, answer.verdict, answer.key[:16], answer.error)
        writer.writerow([trial.point, trial.role, trial.repeat, *values, *cells, *end])
    write_text(path, stream.getvalue())


def write_study(folder: Path, results: StudyResults) -> None:
    """``runs.csv`` and ``study.json``."""
    write_runs(folder / TABLE_NAME, results)
    write_text(folder / SUMMARY_NAME, json.dumps(plain(results.as_dict()), indent=2, ensure_ascii=False) + "\n")


def write_all_fields(folder: Path, results: StudyResults, table: RunTable, points: Sequence[SheetPoints]) -> Path:
    """``fields.h5`` of all runs that finished; returns its path."""
    answers = [answer for answer in results.answers if answer.status == "finished"]
    inputs = {factor.name: [answer.trial.values[k] for answer in answers] for k, factor in enumerate(results.factors)}
    measures = {
        results.key(measure): [answer.number(results.key(measure)) for answer in answers]
        for measure in results.measures
    }
    units = {factor.name: factor.shown_unit for factor in results.factors}
    path = folder / FIELDS_NAME
    write_fields(
        path, points, inputs, units, measures, [table.fields(answer.key) for answer in answers],
        [answer.key for answer in answers],
    )  # fmt: skip
    return path
