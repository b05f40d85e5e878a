"""Generate docs/gallery.md and the tables of docs/fabrics.md, gpu.md, job.md, results.md, studies.md, from the code.

python scripts/doc_tables.py            # writes the tables
python scripts/doc_tables.py --check    # exits with code 1 where a page differs
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from scripts.benchmarks.cuda import tables as cuda_tables  # noqa: E402
from scripts.documentation import gallery  # noqa: E402
from scripts.shared import fabric_tables, job_tables, result_tables, study_tables  # noqa: E402

BEGIN, END = "<!-- begin of scripts/doc_tables.py -->\n", "<!-- end of scripts/doc_tables.py -->\n"
PAGES: dict[str, Callable[[], str]] = {
    "fabrics.md": fabric_tables.tables,
    "gallery.md": gallery.exhibits_text,
    "gpu.md": cuda_tables.tables,
    "job.md": job_tables.tables,
    "results.md": result_tables.tables,
    "studies.md": study_tables.tables,
}


def text_of(page: str) -> str:
    """Current text of a page."""
    return (ROOT / "docs" / page).read_text(encoding="utf-8")


def text_with_tables(page: str) -> str:
    """Text of a page with its tables regenerated.

    Raises:
        ValueError: a page without the two marks.
    """
    before, rest = text_of(page).split(BEGIN)
    return before + BEGIN + "\n" + PAGES[page]() + "\n" + END + rest.split(END)[1]


def main() -> int:
    new = {page: text_with_tables(page) for page in PAGES}
    different = [page for page, text in new.items() if text_of(page) != text]
    if "--check" in sys.argv[1:]:
        for page in different:
            print(f"docs/{page} differs from the code: run python scripts/doc_tables.py", file=sys.stderr)
        return int(bool(different))
    for page in different:
        (ROOT / "docs" / page).write_text(new[page], encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
