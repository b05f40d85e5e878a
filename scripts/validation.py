"""Run the scenes with variations of their defaults, and write the validation pages.

    python scripts/validation.py               all pages, about twenty minutes on two cores
    python scripts/validation.py hemisphere    one of them: double-dome, hemisphere, measured or two-plies

Every number in docs/validation.md, docs/validation_hemisphere.md, docs/validation_measured.md and
docs/validation_two_plies.md is from this script.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from scripts.validation_pages.double_dome import double_dome_page  # noqa: E402
from scripts.validation_pages.hemisphere import hemisphere_page  # noqa: E402
from scripts.validation_pages.measured import measured_page  # noqa: E402
from scripts.validation_pages.two_plies import two_plies_page  # noqa: E402
from weavesim.output.files import replacing  # noqa: E402

DOCUMENTS = ROOT / "docs"
PAGES = {
    "double-dome": ("validation.md", double_dome_page),
    "hemisphere": ("validation_hemisphere.md", hemisphere_page),
    "measured": ("validation_measured.md", measured_page),
    "two-plies": ("validation_two_plies.md", two_plies_page),
}


def main(wanted: list[str]) -> None:
    """Write the wanted pages, or all; exits with 1 if a requirement is not met."""
    if unknown := [name for name in wanted if name not in PAGES]:
        sys.exit(f"{unknown[0]!r} is no page: choose of {', '.join(PAGES)}")
    failed = {}
    for scene in wanted or PAGES:
        name, write_page = PAGES[scene]
        text, failed[scene] = write_page()
        with replacing(DOCUMENTS / name) as temporary:
            temporary.write_text(text, encoding="utf-8")
    print(json.dumps({"failed": failed}, indent=2))
    raise SystemExit(1 if any(failed.values()) else 0)


if __name__ == "__main__":
    main(sys.argv[1:])
