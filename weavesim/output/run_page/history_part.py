"""Forces and energies of the whole part over the stroke, for the charts of the page."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...run.frame import RunInfo
from ..history import History, energy_copies, tool_copies
from .packing import rounded

# An energy is drawn if it ever exceeds this share of the largest.
_SHOWN_SHARE = 0.004


def share_text(info: RunInfo) -> str:
    """Of what the forces and energies of the page are, behind the share that is computed; "" if that is all."""
    shares = {sheet.symmetry.share for sheet in info.sheets}
    if shares == {1.0}:
        return ""
    if len(shares) == 1:
        return " (forces and energies here are those of the whole part)"
    return " (forces of tools here are those of the whole part, all else that of what is computed)"


def charts_of(
    info: RunInfo, history: History, places: list[int], largest_angle: list[list[float]]
) -> list[dict[str, Any]]:
    """Charts over the stroke, or over time without one.

    Args:
        info: about the run.
        history: of its frames.
        places: the frames of ``largest_angle``.
        largest_angle: largest and 99th percentile of the shear angle [degrees] in each of them.
    """
    by_stroke = bool(history.frame_count) and float(np.ptp(history.stroke)) > 0.0
    x = 1.0e3 * (history.stroke if by_stroke else history.time)
    label = "stroke [mm]" if by_stroke else "time [ms]"
    charts = [*_forces(info, history), *_drives(info, history), *_energies(info, history)]
    found = [{"xLabel": label, "x": rounded(x), **chart} for chart in charts if chart["lines"]]
    if largest_angle:
        found.append({"xLabel": label, "x": rounded(x[places]), **_angles(largest_angle)})
    return found


def _line(label: str, values: np.ndarray, *, dashed: bool = False) -> dict[str, Any]:
    return {"label": label, "y": rounded(values), "dashed": dashed}


def _forces(info: RunInfo, history: History) -> list[dict[str, Any]]:
    lines = []
    for k, (tool, copies) in enumerate(zip(info.tools, tool_copies(info), strict=True)):
        name = history.tool_names[k].replace("_", " ")
        force = np.abs(history.tool_reaction[:, k] @ np.asarray(tool.axis, dtype=float))
        lines.append(_line(name, copies * force))
        wanted = np.abs(history.tool_wanted[:, k])
        if np.isfinite(wanted).any():
            lines.append(_line(f"{name}, wanted", copies * wanted, dashed=True))
    return [
        {
            "name": "forces", "title": "Force on each tool", "yLabel": "force along the tool's axis [N]",
            "lines": lines,
        }
    ]  # fmt: skip


def _drives(info: RunInfo, history: History) -> list[dict[str, Any]]:
    known = energy_copies(info)
    copies = known or 1.0
    lines = [
        _line(name.replace("_", " "), copies * history.drive_force[:, k]) for k, name in enumerate(history.drive_names)
    ]
    lines += [
        _line(f"gripper {name.replace('_', ' ')}", copies * history.gripper_force[:, k])
        for k, name in enumerate(history.gripper_names)
    ]
    mirrored = ", computed parts" if known is None else ", each with its mirror images" if copies > 1.0 else ""
    return [
        {"name": "drives", "title": f"Forces of supports and grippers{mirrored}", "yLabel": "force [N]", "lines": lines}
    ]


def _energies(info: RunInfo, history: History) -> list[dict[str, Any]]:
    # it loads Warp, which the options of a run do not need
    from ...run.ledger import SUMS, SUPPLIED

    book, copies = history.energies, energy_copies(info) or 1.0
    size = {name: float(np.abs(values).max(initial=0.0)) for name, values in book.items()}
    largest = max(size.values(), default=0.0) or 1.0
    names = [name for name in book if name not in (*SUPPLIED, *SUMS) and size[name] > _SHOWN_SHARE * largest]
    names.sort(key=lambda name: -size[name])
    lines = [_line(name.replace("_", " "), copies * book[name]) for name in names]
    if "supplied" in book:
        lines.insert(0, _line("supplied work", copies * book["supplied"], dashed=True))
    ratios = [_line(label, values) for label, values in history.energy_ratios.items()]
    return [
        {"name": "energies", "title": "Stored and lost energies", "yLabel": "energy [J]", "lines": lines},
        {"name": "ratios", "title": "Ratios of energies that judge the run", "yLabel": "ratio [%]", "lines": ratios,
         "logarithmic": True},
    ]  # fmt: skip


def _angles(largest_angle: list[list[float]]) -> dict[str, Any]:
    values = np.array(largest_angle, dtype=float)
    lines = [_line("largest", values[:, 0]), _line("99th percentile", values[:, 1])]
    return {"name": "angles", "title": "Shear angle", "yLabel": "shear angle [°]", "lines": lines}
