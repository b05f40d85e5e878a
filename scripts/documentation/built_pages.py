"""What a built site must be: links and anchors lead somewhere, nothing is loaded from a network, no formula is left."""

from __future__ import annotations

from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

# Attributes that make a browser load something, by tag.
LOADED = {"script": "src", "img": "src", "link": "href", "iframe": "src", "source": "src", "video": "src"}


class Page(HTMLParser):
    """Anchors, links and loaded files of one page, and the text outside code that still has LaTeX in it."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.links: list[str] = []
        self.loaded: list[str] = []
        self.raw: list[str] = []
        self._inside: list[str] = []
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = dict(attrs)
        self.anchors.update(value for key in ("id", "name") if (value := values.get(key)))
        if tag == "a" and (target := values.get("href")):
            self.links.append(target)
        if tag in LOADED and (target := values.get(LOADED[tag])):
            self.loaded.append(target)
        if tag in ("code", "pre", "script", "style", "math"):
            self._inside.append(tag)

    def handle_endtag(self, tag: str) -> None:
        if self._inside and self._inside[-1] == tag:
            self._inside.pop()

    def handle_data(self, data: str) -> None:
        if not self._inside and ("$" in data or "\\frac" in data):
            self.raw.append(data.strip()[:60])


@cache
def page(path: Path) -> Page:
    """A page, read once."""
    return Page(path)


def is_outside(target: str) -> bool:
    """Whether a link leaves the site."""
    parts = urlsplit(target)
    return bool(parts.scheme or parts.netloc)


def problems(site: Path) -> list[str]:
    """What is wrong with a built site, one line each."""
    page.cache_clear()
    found = []
    pages = [path for path in sorted(site.rglob("*.html")) if "_static" not in path.parts]
    for path in pages:
        name = path.relative_to(site).as_posix()
        one = page(path)
        found += [f"{name}: loads {target} from a network" for target in one.loaded if is_outside(target)]
        found += [f"{name}: a formula is left as text: {text}" for text in one.raw]
        for target in [*one.links, *one.loaded]:
            if is_outside(target):
                continue
            parts = urlsplit(target)
            there = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if not there.is_file():
                found.append(f"{name}: {target} is not there")
            elif parts.fragment and there.suffix == ".html" and unquote(parts.fragment) not in page(there).anchors:
                found.append(f"{name}: {target} has no such anchor")
    return found
