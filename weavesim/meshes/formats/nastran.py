"""Bulk data of Nastran and OptiStruct: grid points and shells, in free, small and large fields.

meshio passes over the coordinate systems of grid points, and over shells with offsets; hence a reader of our own.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np

from ..kinds import is_text, looks_like
from ..mesh_file import QUAD, TRIANGLE, Cells, MeshFile
from ..source import Source, listed, number, whole
from .grid import Block, Grid

_SURFACES = {
    "CTRIA3": (TRIANGLE, 3), "CTRIAR": (TRIANGLE, 3), "CQUAD4": (QUAD, 4), "CQUADR": (QUAD, 4), "CSHEAR": (QUAD, 4),
    "CTRIA6": ("triangle6", 6), "CQUAD8": ("quad8", 8),
}  # fmt: skip
_VOLUMES = ("CTETRA", "CHEXA", "CPENTA", "CPYRA", "CHEX8", "CHEX20")
# Cards whose name begins with C as those of elements do.
_NO_ELEMENTS = ("CORD", "CEND", "CONV", "CREEP", "CSSCHD", "CSUPER", "CYAX", "CYJOIN", "CYSYM", "CONTACT", "CAMPBLL")
_NAME = re.compile(r"[A-Z][A-Z0-9]{0,7}\Z")
_EXPONENT = re.compile(rb"(?<=[0-9.])([+-])(?=\d+\Z)")


def read_nastran(source: Source) -> MeshFile:
    """Vertices and surface cells of a deck of Nastran or OptiStruct.

    Raises:
        InputError: damaged, or volumes, other coordinate systems, or elements that are not read.
    """
    if not is_text(source.data):
        raise source.misnamed("a Nastran deck", "binary data")
    ids: list[int] = []
    position: list[list[float]] = []
    rows: dict[str, list[tuple[int, list[int]]]] = {}
    left_out: dict[str, int] = {}
    for line, name, fields in _cards(source):
        try:
            if name == "GRID":
                ids.append(_whole(fields[0]))
                position.append(_point(source, line, fields))
            elif name in _SURFACES:
                count = _SURFACES[name][1]
                nodes = [_whole(field) for field in fields[2 : 2 + count]]
                if len(nodes) != count:
                    raise _NotANumber
                rows.setdefault(name, []).append((line, [_whole(fields[0]), *nodes]))
            elif name == "GRDSET" and fields[1:2] not in ([], [b""], [b"0"]):
                raise source.error(f"line {line}: grid points in another system than the basic one", _ONE_SYSTEM)
            elif name.startswith(_VOLUMES):
                raise source.error(f"line {line}: {name} fills a volume", "write its surface as CTRIA3 and CQUAD4")
            elif name.startswith(("CTRI", "CQUAD", "CSHELL")):
                raise source.error(f"line {line}: elements {name} are not read", "write CTRIA3 and CQUAD4")
            elif name == "INCLUDE":
                raise source.error(f"line {line}: INCLUDE is not followed", "copy the other file to this place")
            elif name.startswith(("C", "PLOTEL", "RB")) and not name.startswith(_NO_ELEMENTS):
                left_out[name] = left_out.get(name, 0) + 1
        except (IndexError, _NotANumber):
            raise source.error(f"line {line}: the numbers of {name} are expected, all of them") from None
    return _mesh(source, ids, position, rows, left_out)


_ONE_SYSTEM = "write all grid points in the basic system"


class _NotANumber(Exception):
    """A field that holds something else than it should."""


def _whole(field: bytes) -> int:
    try:
        return whole(field)
    except ValueError:
        raise _NotANumber from None


def _mesh(
    source: Source,
    ids: list[int],
    position: list[list[float]],
    rows: dict[str, list[tuple[int, list[int]]]],
    left_out: dict[str, int],
) -> MeshFile:
    notes = []
    if left_out:
        what = listed([f"{count} {name}" for name, count in left_out.items()], 10)
        notes.append(f"elements that bound no surface left out: {what}")
    if not rows:
        kind = looks_like(source.data)
        raise source.error(
            "it has no CTRIA3 or CQUAD4" + (f"; it looks like {kind}" if kind and "Nastran" not in kind else ""),
            "write the surface as shells",
        )
    grid = Grid("the deck")
    if ids:
        grid.nodes.append((np.array(ids), np.array(position)))
    for name, found in rows.items():
        table = np.array([values for _, values in found])
        lines = np.array([line for line, _ in found])
        grid.blocks.append(Block(_SURFACES[name][0], name, table[:, 0], table[:, 1:], lines))
    labels, points, blocks = grid.resolved(source, notes)
    cells = tuple(Cells(b.kind, f"{b.name} elements", b.nodes, b.ids) for b in blocks)
    return MeshFile(source.name, "Nastran deck", points, cells, tuple(notes), "element", labels)


def _point(source: Source, line: int, fields: list[bytes]) -> list[float]:
    if fields[1:2] not in ([], [b""], [b"0"]):
        raise source.error(f"line {line}: a grid point in another system than the basic one", _ONE_SYSTEM)
    for field in fields[5:6]:  # the system of displacements: a whole number
        if field:
            _whole(field)
    if any(field.strip(b"0") for field in fields[5:8]) and not any(b"." in field for field in fields[2:5]):
        raise source.error(
            f"line {line}: whole numbers in place of coordinates, as decimal commas make them",
            "write decimals with a point",
        )
    result = []
    for field in [*fields[2:5], b"", b"", b""][:3]:
        try:
            result.append(number(_EXPONENT.sub(rb"e\1", field)) if field else 0.0)
        except ValueError:
            raise _NotANumber from None
    return result


def _cards(source: Source) -> Iterator[tuple[int, str, list[bytes]]]:
    """Line, name and fields of every card, those of its continuation lines with them."""
    lines = source.data.splitlines()
    begin = next((k for k, text in enumerate(lines) if text.strip().upper().startswith(b"BEGIN")), -1)
    card: tuple[int, str, list[bytes]] | None = None
    for line, text in enumerate(lines[begin + 1 :], begin + 2):
        text = text.split(b"$", 1)[0].rstrip()
        if not text:
            continue
        name, fields = _fields(text)
        if name == "GRID" and b"," not in text:
            _check_widths(source, line, text)
        if name == "ENDDATA":
            break
        if name in ("", "+"):
            if card is None:
                raise source.error(f"line {line} continues a card that was not begun")
            card[2].extend(fields)
            continue
        if not _NAME.match(name):
            raise source.error(f"line {line} is no card of bulk data")
        if card is not None:
            yield card
        card = (line, name, fields)
    if card is not None:
        yield card


def _check_widths(source: Source, line: int, text: bytes) -> None:
    """Refuse a coordinate that goes on in the next field, where its last digits would be a coordinate of their own."""
    text = text.expandtabs(8)
    size, ends = (16, (3,)) if b"*" in text[:8] else (8, (3, 4, 5))
    for k in ends:
        begin = 8 + k * size
        rest = text[begin : begin + size].split(b" ")[0]
        # what follows z may be the system of the displacements; 0 would be no digit that is missed
        if rest and text[begin - 1 : begin].strip() and b"." not in rest and (k != ends[-1] or rest != b"0"):
            raise source.error(
                f"line {line}: a coordinate is wider than its field of {size} characters",
                "write commas between the fields, or fields of 16 characters (GRID*)",
            )


def _fields(text: bytes) -> tuple[str, list[bytes]]:
    """Name of a card, "" or "+" where one goes on, and its fields without blanks: eight, or four wide ones."""
    if b"," in text:
        words = [word.strip() for word in text.split(b",")]
        first, fields = words[0], words[1:9]
        wide = first.endswith(b"*")
        fields = fields[:4] if wide else fields
    else:
        text = text.expandtabs(8)
        first = text[:8].strip()
        wide = b"*" in first
        size = 16 if wide else 8
        fields = [text[8 + k * size : 8 + (k + 1) * size].strip() for k in range(4 if wide else 8)]
    fields += [b""] * ((4 if wide else 8) - len(fields))
    if first.startswith((b"+", b"*")):
        return "+", fields
    return first.rstrip(b"* ").decode("latin-1").upper(), fields
