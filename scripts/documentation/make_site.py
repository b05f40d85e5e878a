"""Build the documentation as a site, without a network: pages, formulas, reference, gallery, notebooks, search.

    python scripts/documentation/make_site.py               # build/site/html/index.html
    python scripts/documentation/make_site.py --out DIR

Every warning is an error. Afterwards the links and anchors of all pages are followed, and nothing may be loaded from a
network. Needed: the extra ``docs``.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Annotated

import typer

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from scripts.documentation.built_pages import problems  # noqa: E402
from scripts.documentation.staging import stage  # noqa: E402


def main(
    out: Annotated[Path, typer.Option(help="folder for sources and pages")] = ROOT / "build" / "site",
    jobs: Annotated[int, typer.Option(min=1, help="processes that write pages")] = 1,
) -> None:
    """Build the site and check it."""
    try:
        from sphinx.cmd.build import build_main
    except ImportError:
        raise SystemExit("Sphinx is missing: pip install 'weavesim[docs]', or run make site") from None
    started = time.monotonic()
    stage(out / "source")
    settings = ["-c", str(Path(__file__).parent), "-d", str(out / "kept"), "-j", str(jobs), "-q"]
    code = build_main(["-b", "html", "-W", "--keep-going", *settings, str(out / "source"), str(out / "html")])
    if code:
        raise typer.Exit(code)
    found = problems(out / "html")
    print("\n".join(found), file=sys.stderr)
    if found:
        raise SystemExit(f"{len(found)} problems of the built pages")
    print(f"{out / 'html' / 'index.html'} ({time.monotonic() - started:.0f} s)")


if __name__ == "__main__":
    typer.run(main)
