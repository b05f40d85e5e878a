"""The tables of docs/gpu.md, from the record: registers of all kernels, and steps that are to be measured."""

from __future__ import annotations

from collections.abc import Iterable

from ...shared.report import table
from .prediction import H100, H200, MEASURED, SIZES, Predicted, predicted
from .record import ARCHITECTURES, Entry, Record

PRECISIONS = ("float32", "float64")
# Kernels that need no more than this, and no stack, share a line.
SMALL = 40


def asker(entry: Entry) -> str:
    """What asks for a kernel: "scenes", or what no scene has; several batches share a line."""
    further = [user for user in entry.users if ":" in user or user == "self-contact"]
    if len(further) < len(entry.users):
        return "scenes"
    return "batch" if further[0].startswith("batch") else ", ".join(further).replace(", cell: ", ", ")


def most(entries: Iterable[Entry]) -> str:
    """The largest registers, stack and instructions of several kernels on any architecture, in words."""
    needs = [one for entry in entries for one in entry.needs.values()]
    if not needs:
        return ""
    registers, stack = max(one.registers for one in needs), max(one.stack for one in needs)
    instructions = max(one.instructions for one in needs)
    return f"{registers}{f', {stack}' if stack else ''}; {instructions:,}"


def register_table(record: Record) -> str:
    """Registers, bytes of stack if any, and instructions: the largest of all architectures and of all who ask."""
    lines: dict[tuple[str, str], list[Entry]] = {}
    for entry in record.entries:
        lines.setdefault((asker(entry), entry.kernel), []).append(entry)
    rows, small = [], []
    for (who, kernel), entries in sorted(lines.items(), key=lambda line: (line[0][0] != "scenes", line[0])):
        if all(one.registers <= SMALL and not one.stack for entry in entries for one in entry.needs.values()):
            small += entries
            continue
        cells = (most(entry for entry in entries if entry.precision == precision) for precision in PRECISIONS)
        rows.append([f"`{kernel}`", who, *cells])
    cells = (most(entry for entry in small if entry.precision == precision) for precision in PRECISIONS)
    rows.append(["all others", "", *cells])
    return table(["kernel", "asked for by", *PRECISIONS], rows)


def microseconds(time: float) -> str:
    """Three digits of a time [s], in microseconds."""
    found = 1e6 * time
    return f"{found:.1f}" if found < 100.0 else f"{found:,.0f}"


def _row(one: Predicted) -> list[str]:
    return [one.case, f"{one.count:,}", one.precision, microseconds(one.step), one.bound]


def prediction_table(record: Record) -> str:
    """Steps on an H100, in microseconds, with what bounds them."""
    rows = [
        [*_row(one), f"{one.count / one.step / 1e6:,.0f}"]
        for precision in PRECISIONS
        for count in SIZES
        for one in [predicted(record, H100, "free patch", count, precision)]
    ]
    head = ["case", "elements", "precision", "step [us]", "bound by", "M element-steps/s"]
    return table(head, rows, right=True)


def comparison_table(record: Record) -> str:
    """The same formula beside what was measured on an H200."""
    rows = []
    for (case, count, precision), measured in MEASURED.items():
        one = predicted(record, H200, case, count, precision)
        errors = ", ".join(f"{100 * (1e6 * one.step / value - 1):+.0f} %" for value in measured)
        rows.append([*_row(one), " and ".join(map(str, measured)), errors])
    head = ["case", "elements", "precision", "predicted [us]", "bound by", "measured [us]", "error"]
    return table(head, rows, right=True)


def tables() -> str:
    """All of docs/gpu.md that is computed, as Markdown."""
    record = Record.read()
    counts = (f"{sum(entry.precision == one for entry in record.entries)} in {one}" for one in PRECISIONS)
    versions = " and ".join(f"{architecture / 10:.1f}" for architecture in ARCHITECTURES)
    lines = [
        "## Registers of all kernels",
        "",
        f"Kernels: {' and '.join(counts)}, built by Warp {record.warp} for compute capability {versions}.",
        "Registers, bytes of stack where there are any; instructions. Of all variants the most.",
        "",
        register_table(record),
        "",
        "## A step on an H100, predicted",
        "",
        prediction_table(record),
        "",
        "The same formula for the H200, beside what was measured there on 26 November 2026 (commit 0e2b230; second",
        "numbers b4d5f99):",
        "",
        comparison_table(record),
    ]
    return "\n".join(lines) + "\n"
