"""Tables of docs/fabrics.md from the registry of laws: kinds, fields, units, defaults, constructors, presets.

Only built-in kinds are listed.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import get_origin

import numpy as np
from pydantic.fields import FieldInfo

from weavesim.checks import Parameters
from weavesim.fabric import PRESETS, UNIT_CELLS, Fabric
from weavesim.fabric.families import constructors, implied_kind, kinds_of_field
from weavesim.fabric.provenance import given_numbers
from weavesim.ranges import QUANTITIES, SLIPS, quantity_of


def built_in_kinds(owner: type[Parameters], field: str) -> dict[str, type[Parameters]]:
    """Kinds of a field that are part of weavesim."""
    return {
        name: kind
        for name, kind in kinds_of_field(owner, field).items()
        if kind.__module__.startswith("weavesim.") and owner is not kind
    }


def tables() -> str:
    """All tables, as Markdown."""
    lines = ["### The file", "", *table(Fabric.model_fields.items())]
    for field in Fabric.model_fields:
        kinds = built_in_kinds(Fabric, field)
        if kinds:
            is_list = get_origin(Fabric.model_fields[field].annotation) is tuple
            heading = f"[[{field}]]" if is_list else f"[{field}]"
            lines += ["", f"### `{heading}`", "", *_family(Fabric, field, kinds)]
    lines += ["", "### Quantities: units, allowed and usual ranges", "", *quantity_table()]
    lines += ["", "### Presets", "", "For `based_on` and `--fabric`:", "", *preset_table(), ""]
    lines += ["Unit cells with values, for `weavesim.fabric.UNIT_CELLS`: " + _listed(UNIT_CELLS) + "."]
    return "\n".join(lines) + "\n"


def _family(owner: type[Parameters], field: str, kinds: dict[str, type[Parameters]]) -> Iterator[str]:
    implied = implied_kind(owner, field)
    article = "an" if str(implied)[:1] in "AEIOU" else "a"
    hint = f" Without a `kind` it is {article} `{implied}`." if implied in kinds else ""
    yield f"Kinds: {_listed(kinds)}.{hint}"
    shown: dict[str, type[Parameters]] = {}
    for name, kind in kinds.items():
        yield from ("", f"**`{name}`**: {_summary(kind)}")
        # a kind with all the fields of an earlier one lists only its own fields
        like = next((other for other, base in shown.items() if _contains(kind, base)), None)
        fields = dict(kind.model_fields)
        if like:
            fields = {key: item for key, item in fields.items() if key not in shown[like].model_fields}
            yield from ("", f"All fields of `{like}`" + (", and:" if fields else "."))
        if fields:
            yield from ("", *table(fields.items()))
        if known := constructors(kind):
            yield from ("", f"Constructors: {_listed(f'{name}.{constructor}' for constructor in known)}.")
        shown[name] = kind
        for inner in kind.model_fields:
            within = {key: item for key, item in built_in_kinds(kind, inner).items() if key not in shown}
            if within:
                yield from ("", f"In place of `{inner}` and the like:", "", *_family(kind, inner, within))
                shown |= within


def table(fields: Iterator[tuple[str, FieldInfo]] | Sequence[tuple[str, FieldInfo]]) -> list[str]:
    """One row for each field: name, unit, quantity, default, meaning."""
    rows = ["| field | unit | quantity | default | meaning |", "|---|---|---|---|---|"]
    for name, field in fields:
        text = field.description or ""
        unit = re.search(r" ?\[([^\]]+)\]", text)
        meaning = text.replace(unit.group(0), "", 1).strip() if unit else text
        quantity = quantity_of(field)
        rows.append(
            f"| `{name}` | {unit.group(1) if unit else ''} | {quantity.name if quantity else ''} | {_default(field)} | "
            f"{_escaped(meaning)} |"
        )
    return rows


def preset_table() -> Iterator[str]:
    """One row for each preset: its numbers, and the moment of shear law and friction when it is sheared from rest."""
    angles = (5.0, 10.0, 20.0, 30.0, 40.0)
    heads = [f"{angle:.0f}°" for angle in angles]
    columns = ["preset", "fabric", "numbers, assumed", f"moment of shear and friction [N/m] at {heads[0]}", *heads[1:]]
    yield f"| {' | '.join(columns)} |"
    yield "|---|---|---|" + "---|" * len(angles)
    for name, make in PRESETS.items():
        fabric = make()
        origins = [fabric.origin_of(number) for number in given_numbers(fabric)]
        assumed = sum(origin.assumed for origin in origins if origin is not None)
        path = np.radians(np.linspace(0.0, 40.0, 401))
        moment = fabric.shear.moment(path, fabric.thickness)
        if fabric.shear_friction is not None:
            moment = moment + fabric.shear_friction.moment_along(path)
        moment = np.interp(np.radians(angles), path, moment)
        values = " | ".join(f"{value:.3g}" for value in moment)
        yield f"| `{name}` | {fabric.name} | {len(origins)}, {assumed} | {values} |"


def quantity_table() -> Iterator[str]:
    """One row for each quantity: unit, legal and plausible range, units that are likely given instead."""
    yield from ("| quantity | unit | allowed | usual | likely slip | meaning |", "|---|---|---|---|---|---|")
    for name, row in QUANTITIES.items():
        unit = {"1": "", "m/unit": "m per unit"}.get(row.unit, row.unit)
        slips = ", ".join(other for other, _ in SLIPS[row.unit])
        yield f"| {name} | {unit} | {_range(row.legal)} | {_range(row.plausible)} | {slips} | {row.meaning} |"


def _range(limits: tuple[float, float]) -> str:
    low, high = limits
    return f"{f'{low:.3g} to' if low else 'up to'} {high:.4g}"


def _default(field: FieldInfo) -> str:
    value = field.default
    if field.is_required():
        return "required"
    if isinstance(value, Parameters):
        return "as below"
    if isinstance(value, float):
        return f"{value:.6g}"
    return "none" if value is None else _escaped(f"`{list(value) if isinstance(value, tuple) else value!r}`")


def _contains(kind: type[Parameters], base: type[Parameters]) -> bool:
    def said(field: FieldInfo) -> tuple[str | None, str]:
        return field.description, repr(field.default)

    return all(
        name in kind.model_fields and said(kind.model_fields[name]) == said(field)
        for name, field in base.model_fields.items()
    )


def _summary(kind: type[Parameters]) -> str:
    return _escaped((kind.__doc__ or "").strip().split("\n\n")[0].replace("\n", " ").replace("    ", ""))


def _listed(names) -> str:
    return ", ".join(f"`{name}`" for name in names)


def _escaped(text: str) -> str:
    return text.replace("``", "`").replace("|", "\\|")
