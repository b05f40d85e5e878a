"""Tables of docs/results.md, generated from the lists of writers, findings and fields."""

from __future__ import annotations

from weavesim.measures.findings import SHEET_FINDINGS
from weavesim.measures.stresses import STRESS_FIELDS
from weavesim.output import known_writers
from weavesim.run.fields import FIELDS
from weavesim.run.guards import known_guards
from weavesim.run.verdict import RUN_FINDINGS


def tables() -> str:
    """All tables, as Markdown."""
    lines = ["## Writers", "", "| name | leaves |", "|---|---|"]
    for name, writer in known_writers().items():
        if writer.__module__.startswith("weavesim."):
            text = " ".join((writer.__doc__ or "").split("\n\n")[0].split()).replace("``", "`")
            lines.append(f"| `{name}` | {text} |")
    for heading, findings in (("Numbers of a sheet", SHEET_FINDINGS), ("Numbers of a run", RUN_FINDINGS)):
        lines += ["", f"## {heading}", "", "| entry | unit | what it is |", "|---|---|---|"]
        lines += [f"| `{item.key}` | {item.unit.symbol} | {item.description} |" for item in findings]
    lines += ["", "## Guards", "", "| name | watches | ends a run |", "|---|---|---|"]
    own = {name: guard for name, guard in known_guards().items() if guard.__module__.startswith("weavesim.")}
    ends = {name: "always" if name == "not_finite" else "if wanted" for name, guard in own.items() if guard.lasting}
    lines += [f"| `{name}` | {guard.watches} | {ends.get(name, '')} |" for name, guard in own.items()]
    lines += ["", "## Fields per element", "", "| name in files | unit | what it is |", "|---|---|---|"]
    lines += [f"| `{field.file_name}` | {field.file_unit} | {field.description} |" for field in FIELDS]
    lines += ["", "## Stresses per element", ""]
    lines += [
        "Of the final state: components in the frame with axis 1 along the warp, 2 across it, 3 along the normal."
    ]
    lines += ["", "| name in files | unit | what it is |", "|---|---|---|"]
    lines += [f"| `{name}` | {unit} | {text} |" for name, (unit, text) in STRESS_FIELDS.items()]
    return "\n".join(lines) + "\n"
