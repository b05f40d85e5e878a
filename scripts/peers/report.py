"""The tables of a comparison."""

from __future__ import annotations

from typing import Any

from ..shared.report import table


def _named(row: dict[str, Any]) -> list[str]:
    return [row["contestant"], row["fabric"]]


def _cost(row: dict[str, Any]) -> list[str]:
    return _named(row) + [
        f"{row['membrane']:.2g}", f"{row['shear']:.2g}", f"{row['bending']:.2g}", f"{row['step_us']:.3g}",
        str(row["iterations"] or ""), f"{row['elements']} {row['element']}", f"{1e-6 * row['rate']:.3g}",
        f"{row['seconds_per_simulated']:.3g}",
    ]  # fmt: skip


def _accuracy(row: dict[str, Any]) -> list[str]:
    if not row["finite"]:
        return [*_named(row), f"{row['simulated_s']:.3g}", "not finite"]
    percents = [row[name] for name in ("largest_yarn_stretch", "largest_edge_stretch", "mean_edge_stretch")]
    thousandths = [row[name] for name in ("penetration", "corner_drop", "kinetic_energy")]
    values = [*(100.0 * value for value in percents), *(1e3 * value for value in thousandths)]
    return [*_named(row), f"{row['simulated_s']:.3g}", *(f"{value:.2g}" for value in values)]


def report(rows: list[dict[str, Any]]) -> str:
    """Two Markdown tables, settings and cost of each contestant, and its accuracy; then the errors."""
    done = [row for row in rows if "error" not in row]
    cost = ["contestant", "fabric", "along the yarns [N/m]", "shear [N/m]", "bending [N m]", "step [us]", "iterations"]
    cost += ["elements", "M element-steps/s", "s per simulated s"]
    accuracy = ["contestant", "fabric", "simulated [s]", "largest stretch of a yarn [%]", "of an edge [%]", "mean [%]"]
    accuracy += ["penetration [mm]", "corners fell [mm]", "kinetic energy [mJ]"]
    lines = [table(cost, [_cost(row) for row in done]), "", table(accuracy, [_accuracy(row) for row in done])]
    lines += [f"\n{row['contestant']}, {row['fabric']}: {row['error']}" for row in rows if "error" in row]
    return "\n".join(lines)
