"""Pages in a headless browser: what a reader sees, and what a page says on its console or asks of the network."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

# Names of Debian's and of others' packages.
NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
# WebGL without a graphics card.
OPTIONS = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--hide-scrollbars"]
# For whatever a page is waited for [ms]: WebGL without a graphics card, on a busy machine.
_LONGEST = 300_000
# Schemes that leave the page's own file alone.
_OWN = ("data:", "blob:", "about:")


@dataclass
class OpenPage:
    """A page that is open.

    Attributes:
        page: of Playwright.
        errors: exceptions, and errors and warnings on the console.
        requests: addresses of all that was asked for besides the page itself.
    """

    page: Page
    errors: list[str] = field(default_factory=list)
    requests: list[str] = field(default_factory=list)

    def picture(self, path: Path | None = None, *, selector: str | None = None, whole: bool = False) -> bytes:
        """A PNG of what is seen, of the first element of ``selector``, or of the ``whole`` page."""
        if selector is not None:
            return self.page.locator(selector).first.screenshot(path=path)
        return self.page.screenshot(path=path, full_page=whole)


class HeadlessBrowser:
    """Opens pages."""

    def __init__(self, browser: Browser) -> None:
        self._browser = browser

    @contextmanager
    def open(self, page: Path | str, *, width: int = 1280, height: int = 900, scale: float = 1.0) -> Iterator[OpenPage]:
        """A file, or an address.

        Args:
            page: file or address.
            width, height: of the window [pixels of the page].
            scale: pixels of the screen per pixel of the page.
        """
        address = page.absolute().as_uri() if isinstance(page, Path) else page
        context = self._browser.new_context(
            viewport={"width": width, "height": height}, device_scale_factor=scale, accept_downloads=True
        )
        context.set_default_timeout(_LONGEST)
        context.set_default_navigation_timeout(_LONGEST)
        try:
            view = context.new_page()
            opened = OpenPage(view)
            view.on("pageerror", lambda error: opened.errors.append(str(error)))
            view.on(
                "console",
                lambda said: opened.errors.append(said.text) if said.type in ("error", "warning") else None,
            )
            view.on(
                "request",
                lambda asked: (
                    None if asked.url == address or asked.url.startswith(_OWN) else opened.requests.append(asked.url)
                ),
            )
            view.goto(address)
            yield opened
        finally:
            context.close()


@contextmanager
def headless_browser() -> Iterator[HeadlessBrowser]:
    """A browser; skips the test where there is none.

    While it is open, its thread has a running event loop: close it before a test that needs one of its own.
    """
    path = next(filter(None, map(shutil.which, NAMES)), None)
    if path is None:
        pytest.skip(f"no browser is installed: none of {', '.join(NAMES)} was found (apt-get install chromium)")
    sync_api = pytest.importorskip(
        "playwright.sync_api", reason="Playwright drives the browser: pip install playwright"
    )
    with sync_api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=OPTIONS, timeout=_LONGEST)
        try:
            yield HeadlessBrowser(browser)
        finally:
            browser.close()
