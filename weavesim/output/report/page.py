"""The report: one self-contained HTML file with embedded pictures, which needs no network."""

from __future__ import annotations

import base64
import math
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ...measures.units import split_unit
from ..files import write_text

# Longer lists, such as the knots of a curve, are shown by their first and last values.
_LONGEST_LIST = 12


@dataclass(frozen=True)
class Report:
    """Contents of the page.

    Attributes:
        title, subtitle: heading, and one line below it.
        headline: (label, value) of the few most important numbers.
        warnings: what a reader must know before trusting the rest.
        pictures: (PNG file, caption).
        tables: by heading; a name that ends in a unit (``_mm``, ``_deg``, ...) is shown with it.
        run_id: in the head of the page.
    """

    title: str
    subtitle: str
    headline: Sequence[tuple[str, str]] = ()
    warnings: Sequence[str] = ()
    pictures: Sequence[tuple[Path, str]] = ()
    tables: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    run_id: str = ""


def write_report(path: str | Path, report: Report) -> None:
    """Write the page."""
    pictures = [(base64.b64encode(file.read_bytes()).decode("ascii"), caption) for file, caption in report.pictures]
    tables = [
        (title, [_labelled(name, value) for name, value in rows.items()]) for title, rows in report.tables.items()
    ]
    write_text(Path(path), rendered(str(__package__), report=report, pictures=pictures, tables=tables))


def rendered(package: str, **values: Any) -> str:
    """The page of ``template.html`` of a package, in the style of all reports.

    Args:
        package: name of the package.
        values: of the template.
    """
    from importlib.resources import files

    from jinja2 import Environment, StrictUndefined

    styles = files(__package__).joinpath("style.css").read_text(encoding="utf-8")
    page = files(package).joinpath("template.html").read_text(encoding="utf-8")
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True)
    return environment.from_string(page).render(styles=styles, **values)


def _labelled(name: str, value: Any) -> tuple[str, str]:
    name, unit = split_unit(name)
    return name.replace("_", " "), unit.after(shown(value))


def shown(value: Any) -> str:
    """A value for readers: four significant digits, and a dash for what is not a number."""
    if value is None or (isinstance(value, float) and not math.isfinite(value)):
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return f"{value:,}".replace(",", "\u202f") if abs(value) >= 10_000 else str(value)
    if isinstance(value, float):
        return f"{value:,.0f}".replace(",", "\u202f") if 1.0e4 <= abs(value) < 1.0e12 else f"{value:.4g}"
    if isinstance(value, Mapping):
        return ", ".join(f"{str(key).replace('_', ' ')} {shown(entry)}" for key, entry in value.items())
    if isinstance(value, list | tuple) and len(value) > _LONGEST_LIST:
        return f"{len(value)} values from {shown(value[0])} to {shown(value[-1])}"
    if isinstance(value, list | tuple):
        return ", ".join(map(shown, value))
    return textwrap.shorten(str(value), 300)
