"""Writes the page: one HTML file with styles, scripts, pictures and numbers in it."""

from __future__ import annotations

import base64
import json
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...version import __version__
from ..colours import COLOUR_MAP
from ..files import plain, write_text
from .content import PageContent

if TYPE_CHECKING:
    from jinja2 import Template

# In this order: the libraries, then what uses them.
_LIBRARIES = {"three": "three.min.js", "uplot": "uplot.min.js"}
_SCRIPTS = (
    "data",
    "colours",
    "yarns",
    "sheets",
    "view",
    "section",
    "charts",
    "probe",
    "page",
    "controls",
    "live",
    "main",
)
# All of them read without telling red from green, and in grey.
COLOUR_TABLES = (COLOUR_MAP, "cividis", "magma")


@dataclass(frozen=True)
class _Picture:
    source: str
    caption: str


def load() -> None:
    """What every page needs: its template and its colours."""
    _template()
    colour_tables()


def write_page(path: Path, content: PageContent, numbers: str = "") -> None:
    """Write the page; ``numbers`` of ``numbers_of``, where they have been made."""
    write_text(path, page_text(content, numbers))


def numbers_of(content: PageContent) -> str:
    """The numbers of the page, as JSON for a script element."""
    charts = [fabric["charts"] for fabric in content.fabrics]
    data = {**content.data, "fabrics": charts, "colours": colour_tables()}
    return in_script(json.dumps(plain(data), allow_nan=False, separators=(",", ":")))


def page_text(content: PageContent, numbers: str = "") -> str:
    """The page as HTML. Every text of a run is escaped."""
    shown = {
        "page": {
            **vars(content),
            "fallback": _embedded(content.fallback),
            "draw_in": _embedded(content.draw_in),
            "pictures": _embedded(content.pictures),
        },
        "version": __version__,
        "styles": _text("vendor/uplot.min.css") + _text("style.css"),
        "scripts": _scripts(),
        "data": numbers or numbers_of(content),
    }
    return _template().render(shown)


@cache
def _template() -> Template:
    from jinja2 import Environment, StrictUndefined

    made = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    return made.from_string(_text("template.html"))


def in_script(text: str) -> str:
    """JSON that ends no script element, whatever names are in it."""
    return text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")


@cache
def colour_tables() -> dict[str, str]:
    """Name of each colour map to its 256 colours: red, green and blue, one byte each, as base64."""
    from matplotlib import colormaps

    places = np.linspace(0.0, 1.0, 256)
    return {
        name: base64.b64encode(np.rint(255.0 * colormaps[name](places)[:, :3]).astype(np.uint8).tobytes()).decode()
        for name in COLOUR_TABLES
    }


def _embedded(pictures: Iterable[tuple[Path, str]]) -> list[_Picture]:
    """Pictures that are there: one that was removed meanwhile is no reason to have no page."""
    return [
        _Picture(base64.b64encode(path.read_bytes()).decode("ascii"), caption)
        for path, caption in pictures
        if path.is_file()
    ]


@cache
def _text(name: str) -> str:
    return files(__package__).joinpath(name).read_text(encoding="utf-8")


def _scripts() -> list[tuple[str, str]]:
    """Name or licence, and text of each script."""
    libraries = [
        (f"{name}\n{_text(f'vendor/{name}.LICENSE')}", _text(f"vendor/{file}")) for name, file in _LIBRARIES.items()
    ]
    return [*libraries, *((f"weavesim {name}", _text(f"viewer/{name}.js")) for name in _SCRIPTS)]
