"""The tables of docs/results.md, made from the lists of writers, findings and fields.

python scripts/result_tables.py          # writes them
python scripts/result_tables.py --check  # exits with code 1 where the page differs
"""

from __future__ import annotations

import sys
from pathlib import Path

from weavesim.measures.findings import SHEET_FINDINGS
from weavesim.output import known_writers
from weavesim.run.fields import FIELDS

PAGE = Path(__file__).parents[1] / "docs" / "results.md"
BEGIN, END = "<!-- begin of scripts/result_tables.py -->\n", "<!-- end of scripts/result_tables.py -->\n"


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


def page_with_tables(page: str) -> str:
    """The page with its tables made again.

    Raises:
        ValueError: a page without the two marks.
    """
    before, rest = page.split(BEGIN)
    return before + BEGIN + "\n" + tables() + "\n" + END + rest.split(END)[1]


def main() -> int:
    old = PAGE.read_text(encoding="utf-8")
    new = page_with_tables(old)
    if "--check" not in sys.argv[1:]:
        PAGE.write_text(new, encoding="utf-8")
        return 0
    if new != old:
        print("docs/results.md differs from the code: run python scripts/result_tables.py", file=sys.stderr)
    return int(new != old)


if __name__ == "__main__":
    sys.exit(main())
