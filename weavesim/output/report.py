"""One HTML file about a run, with its pictures inside: it opens anywhere, without a network."""

from __future__ import annotations

import base64
import math
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from .files import write_text

# Endings of summary names that are units.
_UNITS = {
    "deg": "°", "mm": "mm", "s": "s", "j": "J", "n": "N", "m": "m", "pa": "Pa", "kg": "kg", "per_second": "1/s",
}  # fmt: skip

_PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{{ report.title }}</title>
<style>
:root { --ink: #23262d; --grey: #6b7280; --line: #e3e6eb; --accent: #5b3fb5; }
* { box-sizing: border-box; }
body { margin: 0; background: #f6f7f9; color: var(--ink); font: 15px/1.5 system-ui, "Segoe UI", Helvetica, Arial, sans-serif; }
main { max-width: 1180px; margin: 0 auto; padding: 2.2rem 1.4rem 4rem; }
h1 { font-size: 1.9rem; line-height: 1.2; margin: 0 0 .2rem; }
h2 { font-size: 1.2rem; margin: 2.4rem 0 .8rem; }
.sub { color: var(--grey); margin: 0 0 1.6rem; }
.tiles { display: grid; grid-template-columns: repeat(auto-fit, minmax(165px, 1fr)); gap: .8rem; }
.tile, figure, .card { background: #fff; border: 1px solid var(--line); border-radius: 10px; }
.tile { padding: .8rem 1rem; }
.tile b { display: block; font-size: 1.45rem; line-height: 1.25; font-variant-numeric: tabular-nums; }
.tile span { color: var(--grey); font-size: .86rem; }
figure { margin: 0 0 1.1rem; padding: 1rem 1rem .7rem; }
figure img { display: block; width: 100%; height: auto; }
figcaption { color: var(--grey); font-size: .9rem; padding: .5rem .2rem 0; }
.card { padding: .4rem 1rem; overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-size: .92rem; }
td { padding: .32rem .6rem .32rem 0; border-bottom: 1px solid var(--line); vertical-align: top; overflow-wrap: anywhere; }
tr:last-child td { border-bottom: 0; }
td:first-child { color: var(--grey); width: 38%; }
td:last-child { font-variant-numeric: tabular-nums; }
.columns { display: grid; grid-template-columns: repeat(auto-fit, minmax(440px, 1fr)); gap: 1.1rem; align-items: start; }
.warning { background: #fff7e6; border: 1px solid #f2d08a; border-radius: 10px; padding: .7rem 1rem; margin-bottom: .6rem; }
@media print { body { background: #fff; } figure { break-inside: avoid; } }
</style>
</head>
<body>
<main>
<h1>{{ report.title }}</h1>
<p class="sub">{{ report.subtitle }}</p>
{% if report.headline %}
<div class="tiles">
{% for label, value in report.headline %}<div class="tile"><b>{{ value }}</b><span>{{ label }}</span></div>
{% endfor %}
</div>
{% endif %}
{% if report.warnings %}
<h2>Warnings</h2>
{% for warning in report.warnings %}<div class="warning">{{ warning }}</div>
{% endfor %}
{% endif %}
{% if pictures %}<h2>Pictures</h2>{% endif %}
{% for source, caption in pictures %}
<figure><img src="data:image/png;base64,{{ source }}" alt="{{ caption }}"><figcaption>{{ caption }}</figcaption></figure>
{% endfor %}
<div class="columns">
{% for title, rows in tables %}
<section><h2>{{ title }}</h2><div class="card"><table>
{% for label, value in rows %}<tr><td>{{ label }}</td><td>{{ value }}</td></tr>
{% endfor %}
</table></div></section>
{% endfor %}
</div>
</main>
</body>
</html>
"""


@dataclass(frozen=True)
class Report:
    """Contents of the page.

    Attributes:
        title, subtitle: heading, and one line below it.
        headline: (label, value) of the few numbers to see first.
        warnings: what a reader must know before believing the rest.
        pictures: (PNG file, caption).
        tables: by heading; a name that ends in a unit (``_mm``, ``_deg``, ...) is shown with it.
    """

    title: str
    subtitle: str
    headline: Sequence[tuple[str, str]] = ()
    warnings: Sequence[str] = ()
    pictures: Sequence[tuple[Path, str]] = ()
    tables: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)


def write_report(path: str | Path, report: Report) -> None:
    """Write the page."""
    from jinja2 import Environment, StrictUndefined

    pictures = [(base64.b64encode(file.read_bytes()).decode("ascii"), caption) for file, caption in report.pictures]
    tables = [(title, [_labelled(name, value) for name, value in rows.items()]) for title, rows in report.tables.items()]
    template = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True).from_string(_PAGE)
    write_text(Path(path), template.render(report=report, pictures=pictures, tables=tables))


def _labelled(name: str, value: Any) -> tuple[str, str]:
    for ending, unit in _UNITS.items():
        if name.endswith(f"_{ending}"):
            return name[: -len(ending) - 1].replace("_", " "), f"{shown(value)}{'' if unit == '°' else ' '}{unit}"
    return name.replace("_", " "), shown(value)


def shown(value: Any) -> str:
    """A value as a person reads it: four significant digits, and a dash for what is not a number."""
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
    if isinstance(value, list | tuple):
        return ", ".join(map(shown, value))
    return textwrap.shorten(str(value), 300)
