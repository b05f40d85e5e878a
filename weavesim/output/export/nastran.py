"""A bulk data deck for Nastran: CQUAD4 and CTRIA3, each with a PCOMP of its own layers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from .lamina import Lamina
from .part import Part, check_columns
from .units import UnitSystem

_MATERIAL = 1


def nastran_deck(parts: Sequence[Part], lamina: Lamina, units: UnitSystem) -> str:
    """Bulk data in a deck without loads.

    Raises:
        InputError: a number of a node or an element that is too long for its columns.
    """
    check_columns(parts, "Nastran")
    return "\n".join(_lines(parts, lamina, units)) + "\n"


def card(name: str, *fields: int | float | str | None) -> Iterator[str]:
    """A card in fields of sixteen columns, four on a line."""
    cells = [_field(value) for value in fields]
    for k in range(0, len(cells), 4):
        head = f"{name}*" if k == 0 else "*"
        yield f"{head:8}" + "".join(cells[k : k + 4]).rstrip()


def _field(value: int | float | str | None) -> str:
    if value is None:
        return " " * 16
    if isinstance(value, float):
        text = f"{value:.9E}"
        mantissa, exponent = text.split("E")
        return f"{mantissa}E{int(exponent):+d}".rjust(16)
    return f"{value:>16}"


def _lines(parts: Sequence[Part], lamina: Lamina, units: UnitSystem) -> Iterator[str]:
    yield f"$ formed part from weavesim; units {units.text}"
    yield "$ layers from the bottom to the top of the element's normal; their angles: from the side G1-G2 to the fibres"
    for part in parts:
        yield from (f"$ {note}" for note in part.notes)
    yield f"$ {lamina.source or 'elastic constants as given'}"
    yield from ("SOL 101", "CEND", "BEGIN BULK")
    yield from card(
        "MAT8", _MATERIAL, units.stress * lamina.modulus_along, units.stress * lamina.modulus_across,
        lamina.poisson_ratio, units.stress * lamina.shear_modulus, units.stress * lamina.shear_modulus,
        units.stress * lamina.shear_modulus_across, units.density * lamina.density,
    )  # fmt: skip
    for part in parts:
        for label, point in zip(part.mesh.node_labels, units.length * part.mesh.nodes, strict=True):
            yield from card("GRID", int(label), None, *map(float, point))
    for part in parts:
        yield from _elements(part, units)
    yield "ENDDATA"


def _elements(part: Part, units: UnitSystem) -> Iterator[str]:
    row, layers = 0, part.layers
    for cells in part.mesh.cells:
        name = "CQUAD4" if cells.corners.shape[1] == 4 else "CTRIA3"
        for label, corners in zip(cells.labels, part.mesh.node_labels[cells.corners], strict=True):
            # small fields, which more readers take for elements
            yield f"{name:8}{label:8d}{label:8d}" + "".join(f"{node:8d}" for node in corners)
            stack: list[int | float | str | None] = []
            for layer in layers:
                stack += [_MATERIAL, float(units.length * layer.thickness[row]), float(layer.angle[row]), None]
            # Z0, NSM, SB, FT, TREF, GE, LAM
            yield from card("PCOMP", int(label), None, None, None, None, None, None, None, *stack)
            row += 1
