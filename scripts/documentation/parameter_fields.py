"""Fields of parameter classes for the reference: type, default, what it is, and the range that is allowed."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from weavesim.ranges import Quantity

LONGEST_DEFAULT = 60


def described(lines: list[str]) -> set[str]:
    """Names that the docstring itself explains."""
    return {name for line in lines for name in re.findall(r"\w+", (re.match(r"\s+([\w, ]+):", line) or ["", ""])[1])}


def type_of(field: FieldInfo) -> str:
    """Annotation as a reader would write it."""
    text = getattr(field.annotation, "__name__", "") if isinstance(field.annotation, type) else str(field.annotation)
    text = re.sub(r"\b(?:\w+\.)+(?=\w)", "", text or str(field.annotation))
    return re.sub(r"Annotated\[([\w\[\], |.]+?), .*\]", r"\1", text)


def default_of(field: FieldInfo) -> str:
    """Default as text; empty for none, or one that is too long to read."""
    if field.default is PydanticUndefined:
        return ""
    default = getattr(field.default, "value", field.default)
    if default is None or default in ("", ()):
        return ""
    text = repr(default) if not isinstance(default, Path) else default.as_posix()
    return text if len(text) <= LONGEST_DEFAULT and "array(" not in text else ""


def range_of(field: FieldInfo) -> str:
    """Allowed range of a physical quantity, with its unit."""
    quantity = next((one for one in field.metadata if isinstance(one, Quantity)), None)
    if quantity is None:
        return ""
    (least, most), unit = quantity.row.legal, quantity.row.unit
    return f"allowed {least:g} to {most:g} {'' if unit == '1' else unit}".rstrip()


def field_lines(model: type[BaseModel], known: set[str]) -> list[str]:
    """A definition list in reStructuredText of the fields of a class."""
    lines = []
    for name, field in model.model_fields.items():
        if name.startswith("_"):
            continue
        notes = [f"default ``{default}``" for default in (default_of(field),) if default]
        notes += [text for text in (range_of(field),) if text]
        text = re.sub(r"([*|_`])", r"\\\1", field.description or "") if name not in known else ""
        if not text and not notes:
            continue
        body = "; ".join(part for part in (text, ", ".join(notes)) if part)
        lines += [f"``{name}`` : ``{type_of(field)}``", f"    {body}", ""]
    return lines


def add_fields(app: Any, what: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:
    """Append its fields to the docstring of a parameter class, before Napoleon reads it."""
    if what == "class" and isinstance(thing, type) and issubclass(thing, BaseModel):
        found = field_lines(thing, described(lines))
        if found:
            lines += ["", ".. rubric:: Fields", "", *found]


def short_signature(app: Any, what: str, name: str, thing: Any, *rest: Any) -> tuple[str, str] | None:
    """Leave the signature of a parameter class to its fields."""
    if what == "class" and isinstance(thing, type) and issubclass(thing, BaseModel):
        return "", ""
    return None


def setup(app: Any) -> dict[str, Any]:
    """Register with Sphinx."""
    app.connect("autodoc-process-docstring", add_fields, priority=100)
    app.connect("autodoc-process-signature", short_signature)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
