"""The report, one HTML page with everything in it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...measures.findings import SHEET_FINDINGS
from ...measures.units import split_unit
from ...process.friction import in_words
from ...run.frame import Outcome, SheetInfo
from ...run.verdict import RUN_FINDINGS
from ..report.page import Report, shown, write_report
from ..results import Results
from ..writer import Writer

# The few numbers to see first, those of them that a run has.
HEADLINE = (
    "max_shear_angle_deg", "draw_in_long_axis_mm", "draw_in_short_axis_mm", "min_stretch", "max_stretch", "wall_time_s",
)  # fmt: skip
DESCRIPTIONS = {finding.key: finding.description for finding in (*SHEET_FINDINGS, *RUN_FINDINGS)}
# What a blank is of the whole, by its share.
SHARES = {1.0: "whole blank", 0.5: "half of the blank", 0.25: "quarter of the blank"}


class ReportWriter(Writer):
    """``report.html``: one page with all numbers, and the pictures and warnings of the writers before it."""

    name = "report"
    title = "report.html"
    rank = 8

    def write(self, results: Results) -> None:
        """Write the page."""
        write_report(self.folder / "report.html", report_of(results))


def report_of(results: Results) -> Report:
    """Contents of the page."""
    summary = results.whole_summary
    warnings = list(summary["warnings"])
    if (outcome := summary.get("outcome")) != Outcome.FINISHED.value:
        warnings.insert(0, f"The run did not reach its end ({outcome}): the results are those of its last good frame.")
    title = results.info.name.replace("_", " ")
    title = title[:1].upper() + title[1:]
    tables = {heading: rows for heading, rows in _tables(results, summary).items() if rows}
    subtitle, headline = _subtitle(results, outcome), _headline(summary)
    return Report(title, subtitle, headline, warnings, results.pictures, tables, results.info.run_id)


def _subtitle(results: Results, outcome: Any) -> str:
    info = results.info
    fabrics = ", ".join(dict.fromkeys(sheet.fabric.name for sheet in info.sheets))
    shares = ", ".join(dict.fromkeys(SHARES[sheet.symmetry.share] for sheet in info.sheets))
    return f"{fabrics} · {shares} · {info.element_count} elements · {info.precision} on {info.device} · run {outcome}"


def _headline(summary: Mapping[str, Any]) -> list[tuple[str, str]]:
    found = []
    for key in HEADLINE:
        if isinstance(summary.get(key), int | float):
            name, unit = split_unit(key)
            found.append((DESCRIPTIONS.get(key, name.replace("_", " ")), unit.after(shown(float(summary[key])))))
    return found


def _tables(results: Results, summary: Mapping[str, Any]) -> dict[str, Mapping[str, Any]]:
    info = results.info
    left_out = {"warnings", "missing", "doubts", "energies_j", "sheets"}
    left_out |= {name for name in ("notes",) if not summary.get(name)}
    tables: dict[str, Mapping[str, Any]] = {
        "Summary": {name: value for name, value in summary.items() if name not in left_out}
    }
    tables |= {f"Sheet {sheet['name']}": sheet for sheet in summary.get("sheets", ())}
    if results.setup:
        tables["Set-up"] = dict(results.setup)
    for sheet in info.sheets:
        tables["Fabric" if len(info.sheets) == 1 else f"Fabric of {sheet.name}"] = _fabric(sheet)
    tables["Tools"] = {
        name: ", ".join(map(str, (tool.shape, tool.motion, in_words(tool.friction))))
        for name, tool in zip(info.tool_names, info.tools, strict=True)
    }
    tables["Supports"] = {
        support.name: f"{len(support.nodes)} nodes with {len(support.drives)} drives, holds displacements "
        f"{support.displacements or 'none'} and rotations {support.rotations or 'none'}"
        for support in info.supports
    }
    if isinstance(summary.get("energies_j"), Mapping):
        tables["Energies at the end"] = {f"{name}_j": value for name, value in summary["energies_j"].items()}
    return tables


def _fabric(sheet: SheetInfo) -> dict[str, Any]:
    values = sheet.fabric.model_dump()
    values |= {"areal density [kg/m²]": sheet.fabric.areal_density}
    values |= {"thickness [mm]": 1.0e3 * sheet.fabric.thickness}
    return {name: value for name, value in values.items() if name not in ("areal_density", "thickness")}
