"""Fabrics on the page: their curves, every number with its source, and what is assumed."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from ...errors import logged_from
from ...measures.fabric_curves import CurveSet, bending_curves, shear_curves, tension_curves, thickness_curves
from ...measures.fabric_table import rows_of, summary_of
from .packing import rounded

if TYPE_CHECKING:
    from ...fabric.fabric import Fabric
    from ...run.frame import RunInfo


def fabrics_of(info: RunInfo) -> list[dict[str, Any]]:
    """Each fabric of a run once: name, what is known of its numbers, rows, sources and charts."""
    found: list[tuple[Fabric, list[str]]] = []
    for sheet in info.sheets:
        for fabric, sheets in found:
            if fabric is sheet.fabric or fabric == sheet.fabric:
                sheets.append(sheet.name)
                break
        else:
            found.append((sheet.fabric, [sheet.name]))
    return [_fabric(fabric, sheets, len(info.sheets) > 1) for fabric, sheets in found]


def _fabric(fabric: Fabric, sheets: Sequence[str], several: bool) -> dict[str, Any]:
    rows, sources = rows_of(fabric)
    curves = _curves(fabric)
    return {
        "name": fabric.name,
        "sheets": ", ".join(sheets) if several else "",
        "summary": summary_of(fabric),
        "source": fabric.source,
        "assumed": list(fabric.assumed),
        "rows": [
            {"table": row.table.replace("_", " "), "name": row.cells[0].replace("_", " "), "value": row.cells[1],
             "unit": row.cells[2], "trusted": row.cells[3], "assumed": row.cells[4], "source": row.cells[5],
             "meaning": row.meaning}
            for row in rows
        ],
        "sources": sources,
        "charts": [_chart(one) for one in curves],
        "has_tension": any(one.name == "tension" for one in curves),
    }  # fmt: skip


def _curves(fabric: Fabric) -> list[CurveSet]:
    """Those of the tension need the kernel of the unit cell, which is not compiled for a page."""
    from ...fabric.response import responds_at_once

    # which ends of ranges a band leaves out is no news of the run
    with logged_from(logging.WARNING, "weavesim.measures.fabric_curves"):
        tension = [tension_curves(fabric)] if responds_at_once(fabric.unit_cell) else []
        return [shear_curves(fabric), *tension, bending_curves(fabric), *thickness_curves(fabric)]


def _chart(curves: CurveSet) -> dict[str, Any]:
    level = float(curves.lines[0].y[0])
    lines = [{"label": line.label, "x": rounded(line.x), "y": rounded(line.y)} for line in curves.lines]
    return {
        "title": curves.title,
        "xLabel": curves.x_label,
        "yLabel": curves.y_label,
        "lines": lines,
        "band": [rounded(part) for part in curves.band] if curves.band is not None else None,
        "trusted": list(curves.trusted) if curves.trusted is not None else None,
        "measuredTo": curves.measured_to,
        "note": curves.note,
        "yRange": list(curves.shown_ordinates() or (level - 1.0, level + 1.0)),
    }
