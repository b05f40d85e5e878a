"""What a calibration leaves in its folder: the fabric, a report, all numbers, and the curves."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ..checks import as_typed
from ..errors import InputError
from ..input_files import shown
from ..output.files import check_writable, plain, write_summary, write_text
from ..output.pictures.style import write_picture
from ..output.report.page import Report, write_report
from ..output.report.page import shown as shown_value
from ..output.tables import write_table
from ..version import __version__
from .pictures import fits, pictures
from .result import Calibration, Estimate

FABRIC_NAME, RECORD_NAME, CURVES_NAME, REPORT_NAME = "fabric.toml", "calibration.json", "curves.csv", "report.html"


def write_calibration(calibration: Calibration, folder: str | Path, *, overwrite: bool = False) -> Path:
    """Write fabric.toml, calibration.json, curves.csv, pictures and report.html; returns the fabric file.

    Raises:
        InputError: a folder that cannot be written to, or that has a calibration already (``overwrite`` replaces it).
    """
    folder = Path(folder)
    check_folder(folder, overwrite)
    drawn = []
    (folder / "pictures").mkdir(exist_ok=True)
    for name, figure, caption in pictures(calibration):
        path = folder / "pictures" / f"{name}.png"
        write_picture(figure, path)
        drawn.append((path, caption))
    write_table(folder / CURVES_NAME, CURVE_COLUMNS, curve_rows(calibration))
    write_summary(folder / RECORD_NAME, record_of(calibration))
    write_report(folder / REPORT_NAME, report_of(calibration, drawn))
    path = folder / FABRIC_NAME
    write_text(path, fabric_text(calibration))
    return path


def check_folder(folder: Path, overwrite: bool) -> None:
    """Raise InputError for a folder that cannot be written to, or has a calibration or a run already."""
    check_writable(folder)
    taken = [name for name in (RECORD_NAME, FABRIC_NAME, "run.json") if (folder / name).exists()]
    if taken and (not overwrite or "run.json" in taken):
        advice = "give another folder" if "run.json" in taken else f"give another folder, or {as_typed('overwrite')}"
        raise InputError(f"output folder {shown(folder)}: it has {taken[0]} already; {advice}")


# ---------------------------------------------------------------------------------------------------------- fabric file


def fabric_text(calibration: Calibration) -> str:
    """The fabric file: comments on the calibration, and every number with its provenance."""
    lines = [
        f"Calibrated by weavesim {__version__} on {calibration.date}.",
        f"Given: {calibration.options.fabric}.",
        *(f"{f.test.replace('_', ' ')}: {shown(f.path)}, {f.byte_count} bytes, SHA-256 {f.sha256}"
          for f in calibration.files),
        f"Options: {_options_text(calibration)}.",
        "",
        "Values with 95 % intervals:",
        *(f"  {part}: {e.name} = {_value_text(e)}" for part, entries in calibration.estimates.items() for e in entries),
    ]  # fmt: skip
    if calibration.assumed:
        lines += ["", f"No test gave: {'; '.join(calibration.assumed)}."]
    lines += ["", *(f"Warning: {warning}" for warning in calibration.warnings)] if calibration.warnings else []
    comment = "\n".join(f"# {part}".rstrip() for line in lines for part in line.splitlines() or [""])
    return f"{comment}\n\n{calibration.fabric.to_toml()}"


def _value_text(e: Estimate) -> str:
    unit = f" {e.unit}" if e.unit else ""
    if e.has_interval:
        return f"{e.value:.5g}{unit} ({e.low:.4g} to {e.high:.4g})"
    return f"{e.value:.5g}{unit}, {e.state if e.state != 'fitted' else 'no interval'}"


def given_options(calibration: Calibration) -> dict[str, Any]:
    """Options that differ from their defaults."""
    options = calibration.options
    fields = type(options).model_fields
    values = options.model_dump(mode="json")
    return {
        name: values[name]
        for name, field in fields.items()
        if field.is_required() or getattr(options, name) != field.get_default(call_default_factory=True)
    }


def _options_text(calibration: Calibration) -> str:
    return ", ".join(f"{name} = {shown(value)}" for name, value in given_options(calibration).items())


# --------------------------------------------------------------------------------------------------------------- record


def record_of(calibration: Calibration) -> dict[str, Any]:
    """All numbers, for programs."""
    result: dict[str, Any] = {
        "version": __version__,
        "date": calibration.date,
        "options": given_options(calibration),
        "files": [
            {"test": f.test, "path": f.path, "bytes": f.byte_count, "sha256": f.sha256, "notes": f.notes}
            for f in calibration.files
        ],
        "estimates": {
            part: {
                e.name: {
                    "value": e.value, "low": e.low, "high": e.high, "unit": e.unit, "state": e.state, "given": e.given,
                    "meaning": e.meaning,
                }
                for e in entries
            }
            for part, entries in calibration.estimates.items()
        },
        "residuals": {
            r.test: {
                "unit": r.unit, "root_mean_square": r.root_mean_square, "systematic": r.systematic,
                "scatter": r.scatter, "systematic_over_scatter": r.ratio, "largest_measured": r.largest,
                "scatter_from": r.source,
            }
            for r in calibration.residuals
        },
        "fits": {name: _fit_record(calibration, name, fit) for name, fit in fits(calibration)},
        "warnings": calibration.warnings, "notes": calibration.notes, "assumed": calibration.assumed,
        "fabric": calibration.fabric.model_dump(mode="json"),
    }  # fmt: skip
    if calibration.check:
        result["check_with_scene"] = calibration.check
    return plain(result)


def _fit_record(calibration: Calibration, name: str, fit: Any) -> dict[str, Any]:
    part = calibration.cell if name == "unit cell" else calibration.shear
    assert part is not None
    whole = part.reduced.whole
    return {
        "fitted": [fit.problem.unknowns[int(k)].name for k in fit.chosen],
        "correlations": fit.correlation if len(fit.chosen) else [],
        "condition_number": fit.condition,
        "condition_number_of_all": whole.condition,
        "not_told_apart": [
            {"combination": dict(d.entries), "standard_deviation_of_logarithm": d.deviation} for d in part.reduced.weak
        ],
        "held_by_the_data": part.reduced.held,
        "all_fitted_freely": dict(zip([u.name for u in whole.problem.unknowns], whole.values.tolist(), strict=True)),
        "half_sums_of_squares_of_starts": fit.costs,
        "starts_at_the_minimum": fit.same_minimum,
    }


CURVE_COLUMNS = ("test", "file", "specimen", "line", "angle_deg", "warp_strain", "weft_strain", "quantity", "unit",
    "measured", "fitted", "standard_deviation")  # fmt: skip


def curve_rows(calibration: Calibration) -> Iterator[list[object]]:
    """Every point that was fitted: measured, fitted, and the standard deviation that weights it."""
    if calibration.shear:
        fit, start = calibration.shear.reduced.fit, 0
        for test, is_bias in calibration.shear.model.tests:
            rows = slice(start, start + len(test.x))
            start += len(test.x)
            what = ("bias extension", "force", "N") if is_bias else ("picture frame", "shear moment", "N/m")
            columns = (test.lines, test.x, test.y, fit.predicted[rows], fit.problem.sigma[rows])
            for line, angle, y, fitted, sigma in zip(*columns, strict=True):
                yield [what[0], test.file, test.label, int(line), math.degrees(angle), "", "", *what[1:], float(y),
                       float(fitted), float(sigma)]  # fmt: skip
    if calibration.cell:
        fit, start = calibration.cell.reduced.fit, 0
        fitted, sigma = (values.reshape(-1, 2) for values in (fit.predicted, fit.problem.sigma))
        for biaxial in calibration.cell.tests:
            for k, line in enumerate(biaxial.lines):
                for f, yarn in enumerate(("warp", "weft")):
                    yield ["biaxial", biaxial.file, biaxial.label, int(line), "", *map(float, biaxial.strain[k]),
                           f"{yarn} force", "N/m", float(biaxial.force[k, f]), float(fitted[start + k, f]),
                           float(sigma[start + k, f])]  # fmt: skip
            start += len(biaxial.lines)


# --------------------------------------------------------------------------------------------------------------- report


def report_of(calibration: Calibration, drawn: list[tuple[Path, str]]) -> Report:
    """Contents of the page."""
    headline = []
    for part, entries in calibration.estimates.items():
        fitted = [e for e in entries if e.state == "fitted"]
        if part == "shear" and fitted:
            last = [e for e in fitted if e.name.startswith("moment")]
            fitted = last[-1:] + [e for e in fitted if e.name.startswith("friction_limit")][:1]
        headline += [(_words(e.name), f"{e.value:.4g} {e.unit}") for e in fitted[:3]]
    headline += [(f"{r.test}: residual over scatter", f"{r.ratio:.2g}") for r in calibration.residuals]
    tables: dict[str, dict[str, Any]] = {
        f"Values of the {part}": {_words(e.name): _report_value(e) for e in entries}
        for part, entries in calibration.estimates.items()
    }
    tables["Residuals"] = {
        r.test: f"{r.root_mean_square:.3g} {r.unit} in all, {r.systematic:.3g} systematic, "
        f"{r.systematic / r.largest:.2%} of the largest value; {r.source}: {r.scatter:.3g} {r.unit}"
        for r in calibration.residuals
    }
    for name, fit in fits(calibration):
        record = _fit_record(calibration, name, fit)
        tables[f"Fit of the {name}"] = {
            "fitted": record["fitted"],
            "condition number": fit.condition,
            "condition number of all parameters": record["condition_number_of_all"],
            "held because the data cannot tell them": ", ".join(record["held_by_the_data"]) or "none",
            "not told apart": "; ".join(
                " ".join(f"{share:+.2f} {n}" for n, share in d["combination"].items()) for d in record["not_told_apart"]
            )
            or "none",
            "starts that found this minimum": f"{fit.same_minimum} of {len(fit.costs)}",
        }
    tables["Files"] = {
        f"{f.test.replace('_', ' ')} {k + 1}": f"{shown(f.path)}, {f.byte_count} bytes, SHA-256 {f.sha256}"
        for k, f in enumerate(calibration.files)
    }
    tables["Options"] = given_options(calibration)
    if calibration.check:
        tables["Check with the scene"] = {
            name: value for name, value in calibration.check.items() if not isinstance(value, list | np.ndarray)
        }
    tables["Done to the data"] = {f"{k + 1}": note for k, note in enumerate(calibration.notes)}
    tables["Fabric"] = {
        name: value for name, value in calibration.fabric.model_dump().items() if name not in ("provenance",)
    }
    subtitle = f"{calibration.fabric.name} · calibrated on {calibration.date[:10]} by weavesim {__version__}"
    tables = {heading: rows for heading, rows in tables.items() if rows}
    return Report("Calibration", subtitle, headline, calibration.warnings, drawn, tables)


def _words(name: str) -> str:
    """A name for readers; one that ends in a unit would give it to the value."""
    return name.replace("_deg", " degrees").replace("_", " ")


def _report_value(e: Estimate) -> str:
    given = f"; given {shown_value(e.given)}" if e.given == e.given else ""
    return f"{_value_text(e)}{given} – {e.meaning}"
