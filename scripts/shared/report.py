"""How scripts report: Markdown tables, a line about the machine, files of numbers."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any


def table(head: Sequence[str], rows: Sequence[Sequence[object]], *, right: bool = False) -> str:
    """A Markdown table; short rows are padded with empty cells.

    Args:
        head: names of the columns.
        rows: their cells.
        right: whether all columns but the first are aligned to the right.
    """
    lines = ["| " + " | ".join(head) + " |", "|---|" + ("---:|" if right else "---|") * (len(head) - 1)]
    for row in rows:
        cells = [*map(str, row), *[""] * (len(head) - len(row))]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def line_about(machine: Mapping[str, Any]) -> str:
    """One line about the machine on which the numbers were measured."""
    return ", ".join(f"{name} {value}" for name, value in machine.items())


def write_json(path: Path, result: Mapping[str, Any]) -> None:
    """Write a file atomically."""
    partial = path.with_suffix(".partial")
    partial.write_text(json.dumps(result, indent=1))
    partial.replace(path)
