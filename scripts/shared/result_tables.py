"""The tables of docs/results.md, made from the lists of writers, findings and fields."""

from __future__ import annotations

from weavesim.measures.findings import SHEET_FINDINGS
from weavesim.output import known_writers
from weavesim.run.fields import FIELDS


def tables() -> str:
    """All tables, as Markdown."""
    lines = ["## Writers", "", "| name | leaves |", "|---|---|"]
    for name, writer in known_writers().items():
        if writer.__module__.startswith("weavesim."):
            text = " ".join((writer.__doc__ or "").split("\n\n")[0].split()).replace("``", "`")
            lines.append(f"| `{name}` | {text} |")
    lines += ["", "## Numbers of a sheet", "", "| entry | unit | what it is |", "|---|---|---|"]
    lines += [f"| `{item.key}` | {item.unit.symbol or '1'} | {item.description} |" for item in SHEET_FINDINGS]
    lines += ["", "## Fields per element", "", "| name in files | unit | what it is |", "|---|---|---|"]
    lines += [f"| `{field.file_name}` | {field.file_unit} | {field.description} |" for field in FIELDS]
    return "\n".join(lines) + "\n"
