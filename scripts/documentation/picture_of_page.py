"""A picture of a page in a headless browser, such as docs/images/report.png.

python scripts/documentation/picture_of_page.py out/double_dome/report.html docs/images/report.png \\
    --without ".tiles > div:last-child"    (the wall time, on a machine that does something else too)
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer
from PIL import Image

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from tests.support.browser import headless_browser  # noqa: E402

COLOURS = 256
# Until what is drawn has settled [ms].
PATIENCE = 2000


def main(
    page: Annotated[Path, typer.Argument(exists=True, dir_okay=False)],
    picture: Annotated[Path, typer.Argument(dir_okay=False)],
    width: Annotated[int, typer.Option(help="of the window [pixels]")] = 1280,
    height: Annotated[int, typer.Option(help="of the window [pixels]")] = 1180,
    without: Annotated[list[str] | None, typer.Option(help="CSS selector of what is left out; may be repeated")] = None,
) -> None:
    """Draw the top of a page as a PNG of few colours."""
    with headless_browser() as browser, browser.open(page, width=width, height=height) as opened:
        # the page of a run says when it is drawn
        opened.page.evaluate("typeof weavesim === 'undefined' ? null : weavesim.ready")
        for selector in without or ():
            opened.page.add_style_tag(content=f"{selector} {{ display: none }}")
        opened.page.wait_for_timeout(PATIENCE)
        opened.picture(picture)
    with Image.open(picture) as image:
        image.convert("RGB").quantize(COLOURS).save(picture, optimize=True)


if __name__ == "__main__":
    typer.run(main)
