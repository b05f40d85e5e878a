"""STL, ASCII and binary. Vertices are not shared: triangle i has the rows 3 i to 3 i + 2."""

from __future__ import annotations

import re
import struct

import numpy as np

from ...errors import InputError
from ..kinds import is_binary_stl, is_text, looks_like
from ..mesh_file import TRIANGLE, Cells, MeshFile
from ..source import Source, counted, number, numbers

# The text of one triangle; "" stands for a number.
_FACET = (
    *(b"facet", b"normal", b"", b"", b"", b"outer", b"loop"),
    *(3 * (b"vertex", b"", b"", b"")),
    *(b"endloop", b"endfacet"),
)
_WORDS = tuple((place, word) for place, word in enumerate(_FACET) if word)
_COORDINATES = (8, 9, 10, 12, 13, 14, 16, 17, 18)
_BRACKETS = re.compile(rb"(?im)^[ \t]*(end[ \t]*solid|solid)(?![\w])[^\r\n]*")
_LAST_WORD = re.compile(rb"(?i)\bendfacet\b")
# Bytes of text that are taken apart at a time, so that memory stays a small multiple of it.
_PORTION = 2**24


def read_stl(source: Source) -> MeshFile:
    """Vertices and surface cells of an STL file, ASCII or binary.

    Raises:
        InputError: damaged or cut off, or no STL.
    """
    data = source.data
    if is_binary_stl(data):
        return _binary(source, [])
    head = data[:512].lstrip().lower()
    if head.startswith(b"solid") and is_text(data):
        return _ascii(source)
    if head.startswith(b"solid") and b"\0" in data and is_text(stripped := data.rstrip(b"\0 \t\r\n\x1a")):
        return _ascii(Source(source.path, source.what, stripped))  # filled up to a whole block
    kind = looks_like(data)
    if kind and "STL" not in kind:
        raise source.error(f"it looks like {kind}, not like STL", "give it the name of its format, or export STL")
    if is_text(data) and not head.startswith(b"solid"):
        raise source.error("it is text, but does not begin with solid as ASCII STL does")
    return _binary(source, _unequal_length(source))


def _unequal_length(source: Source) -> list[str]:
    """Notes on a binary file whose length does not fit its header, if all that it promises is there."""
    length = len(source.data)
    if length < 84:
        raise source.error(f"it ends after {length} bytes, before the 84 of a binary STL's header")
    count = struct.unpack_from("<I", source.data, 80)[0]
    rest = length - 84 - 50 * count
    if count and 0 < rest < 50:
        return [f"{rest} bytes after the last of {count} triangles ignored"]
    raise source.error(
        f"its header promises {count} triangles, which take {84 + 50 * count} bytes, but the file has {length}: "
        f"it is {'cut off' if rest < 0 else 'longer than that'}, or no STL file",
        "copy or export it again",
    )


def _binary(source: Source, notes: list[str]) -> MeshFile:
    count = struct.unpack_from("<I", source.data, 80)[0]
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", 9), ("attribute", "<u2")])
    corners = np.frombuffer(source.data, record, count, 84)["corners"]
    if not np.all(np.isfinite(corners)):
        bad = np.flatnonzero(~np.all(np.isfinite(corners), axis=1))
        raise source.error(f"{len(bad)} triangles have corners that are not finite, the first is number {bad[0] + 1}")
    return _mesh(source, "binary STL", corners.astype(np.float64).reshape(-1, 3), notes)


def _ascii(source: Source) -> MeshFile:
    data = source.data
    if b"\n" not in data:
        data = data.replace(b"\r", b"\n")  # lines as on old Macintosh computers
        source = Source(source.path, source.what, data)
    brackets = list(_BRACKETS.finditer(data))
    begun = [bracket.group(1).lower() == b"solid" for bracket in brackets]
    if not brackets or begun[-1]:
        where = f" {sum(begun)}, which begins at line {source.line_of(brackets[-1].start(1))}" if brackets else ""
        raise source.error(
            f"the file ends before endsolid of solid{where}: it was cut off, and triangles may be missing",
            "copy or export it again",
        )
    parts: list[np.ndarray] = []
    notes, unended = [], 0
    inside, position = False, 0
    for bracket, begins in zip(brackets, begun, strict=True):
        parts += _facets(source, position, bracket.start(), inside)
        if not begins:
            if not inside:
                raise source.error(f"line {source.line_of(bracket.start(1))} ends a solid that was not begun")
            inside = False
        else:
            if re.search(rb"(?i)\bfacet\s+normal\b", bracket.group()):
                raise source.error(
                    f"line {source.line_of(bracket.start(1))} has triangles behind the name of the solid",
                    "write the name on a line of its own",
                )
            unended += inside
            inside = True
        position = bracket.end()
    _facets(source, position, len(data), False)
    if sum(begun) > 1:
        notes.append(f"the triangles of all {sum(begun)} solids are taken")
    if unended:
        notes.append(f"{counted(unended, 'solid')} without endsolid before the next begins")
    corners = np.concatenate(parts) if parts else np.empty((0, 9))
    return _mesh(source, "ASCII STL", corners.reshape(-1, 3), notes)


def _facets(source: Source, start: int, end: int, inside: bool) -> list[np.ndarray]:
    """Corners of the triangles in a part of the text, each (m, 9)."""
    data = source.data
    if not inside:
        between = data[start:end].strip(b" \t\r\n\0")
        if between:
            line = source.line_of(start + len(data[start:end]) - len(data[start:end].lstrip()))
            raise source.error(f"there is text outside the solids, at line {line}")
        return []
    result = []
    while start < end:
        whole = _LAST_WORD.search(data, start + _PORTION, end) if end - start > _PORTION else None
        stop = whole.end() if whole else end
        tokens = data[start:stop].lower().split()
        count = len(tokens) // len(_FACET)
        good = len(tokens) % len(_FACET) == 0 and all(
            tokens[place :: len(_FACET)] == [word] * count for place, word in _WORDS
        )
        corners = np.empty((count, 9))
        try:
            if not good:
                raise ValueError
            for column, place in enumerate(_COORDINATES):
                corners[:, column] = numbers(tokens[place :: len(_FACET)])
        except ValueError:
            raise _first_fault(source, start, stop) from None
        result.append(corners)
        start = stop
    return result


def _first_fault(source: Source, start: int, end: int) -> InputError:
    """What is wrong in a part of the text, and at which line."""
    line, place = source.line_of(start), 0
    for text in source.data[start:end].lower().split(b"\n"):
        for token in text.split():
            word = _FACET[place]
            if word and token != word:
                if word == b"endloop" and token == b"vertex":
                    return source.error(f"line {line} gives a fourth corner: only triangles are read")
                return source.error(f"line {line}: {word.decode()} is expected")
            if place in _COORDINATES:
                try:
                    number(token)
                except ValueError:
                    return source.error(f"line {line}: a finite number is expected, with a decimal point")
            place = (place + 1) % len(_FACET)
        line += 1
    return source.error(f"a triangle is not complete before line {line - 1}")


def _mesh(source: Source, name: str, vertices: np.ndarray, notes: list[str]) -> MeshFile:
    triangles = np.arange(len(vertices), dtype=np.int64).reshape(-1, 3)
    labels = np.arange(1, len(triangles) + 1)
    cells = (Cells(TRIANGLE, "triangles", triangles, labels),)
    return MeshFile(source.name, name, vertices, cells, tuple(notes), "triangle")
