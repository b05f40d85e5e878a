"""PLY, ASCII and binary: vertices and faces with any number of corners."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..mesh_file import Cells, MeshFile, cells_by_corners, cells_of, check_finite, check_references
from ..source import LARGEST_COUNT, LARGEST_TEXT, Source, counted, numbers, whole

_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2",
    "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4",
    "double": "f8", "float64": "f8",
}  # fmt: skip
_ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">", "ascii": ""}
_CORNERS = ("vertex_indices", "vertex_index")
_LARGEST_HEADER = 2**16


@dataclass
class _Element:
    """One kind of record: its name, number, and properties: name, type, and type of the length for a list."""

    name: str
    count: int
    properties: list[tuple[str, str, str | None]] = field(default_factory=list)

    @property
    def lists(self) -> bool:
        return any(length for _, _, length in self.properties)

    def column(self, name: str) -> int:
        """Place of a property, -1 if there is none."""
        return next((k for k, (found, _, _) in enumerate(self.properties) if found == name), -1)


def read_ply(source: Source) -> MeshFile:
    """Vertices and surface cells of a PLY file, ASCII or binary.

    Raises:
        InputError: damaged or cut off, or strips of triangles, or no PLY.
    """
    order, elements, start = _header(source)
    if not order and len(source.data) > LARGEST_TEXT:
        raise source.error(f"it is text of more than {LARGEST_TEXT / 2**20:g} MiB", "export binary PLY")
    _check_elements(source, elements)
    if order:
        vertices, cells = _binary(source, elements, start, order)
    else:
        vertices, cells = _ascii(source, elements, start)
    check_finite(source, vertices)
    for block in cells:
        check_references(source, block.nodes, block.labels, len(vertices), "face")
    left = [e for e in elements if e.count and e.name not in ("vertex", "face")]
    notes = tuple(f"{counted(e.count, 'record')} of {e.name} left out: no surface" for e in left)
    return MeshFile(source.name, f"PLY, {'binary' if order else 'ASCII'}", vertices, cells, notes, "face")


def _header(source: Source) -> tuple[str, list[_Element], int]:
    """Byte order ("" for text), elements, and where the data begin."""
    head = source.data[:_LARGEST_HEADER]
    if head.split(None, 1)[:1] != [b"ply"] or not head.startswith(b"ply"):
        raise source.misnamed("PLY", "no PLY file")
    end = head.find(b"end_header")
    if end < 0:
        raise source.error("its header has no end_header")
    order: str | None = None
    elements: list[_Element] = []
    text = head[:end].replace(b"\r\n", b"\n").replace(b"\r", b"\n").decode("latin-1")
    for line, words in enumerate(map(str.split, text.split("\n")), 1):
        try:
            match words:
                case [] | ["ply"] | ["comment" | "obj_info", *_]:
                    pass
                case ["format", kind, "1.0"]:
                    order = _ORDERS[kind]
                case ["element", name, count]:
                    elements.append(_Element(name, whole(count.encode())))
                case ["property", "list", length, kind, name]:
                    elements[-1].properties.append((name, _TYPES[kind], _TYPES[length]))
                case ["property", kind, name]:
                    elements[-1].properties.append((name, _TYPES[kind], None))
                case _:
                    raise ValueError
        except (KeyError, IndexError, ValueError):
            raise source.error(f"line {line} of its header is none of PLY 1.0") from None
    if order is None:
        raise source.error("its header has no format")
    start = end + len(b"end_header")
    start += 2 if source.data[start : start + 2] == b"\r\n" else 1
    return order, elements, start


def _check_elements(source: Source, elements: list[_Element]) -> None:
    names = [element.name for element in elements]
    if len(set(names)) < len(names):
        raise source.error("its header names an element twice")
    for element in elements:
        if not element.name.isidentifier() or len(element.name) > 40:
            raise source.error("its header has an element whose name is no name")
        if element.count and not element.properties:
            raise source.error(f"its header gives {element.name} no properties")
        if not 0 <= element.count <= LARGEST_COUNT:
            raise source.error(f"its header promises {element.count} records of {element.name}")
        if "strip" in element.name.lower() and element.count:
            raise source.error(
                f"it contains {counted(element.count, 'strip')} of triangles, which are not read", "export triangles"
            )
    by_name = dict(zip(names, elements, strict=True))
    vertex, face = by_name.get("vertex"), by_name.get("face")
    if vertex is None or any(vertex.column(axis) < 0 for axis in "xyz"):
        raise source.error("its header has no vertices with x, y and z")
    if any(vertex.properties[vertex.column(axis)][2] for axis in "xyz"):
        raise source.error("its header gives coordinates as lists")
    if face is None or not face.count:
        raise source.error("it has no triangles, only points", "export the tool's surface as a triangle mesh")
    corner = _corner_column(face)
    if corner < 0 or not face.properties[corner][2] or face.properties[corner][1][0] == "f":
        raise source.error("its header gives faces no list of vertex_indices")


def _corner_column(face: _Element) -> int:
    return max(face.column(name) for name in _CORNERS)


# --- text -------------------------------------------------------------------------------------------------------------


def _ascii(source: Source, elements: list[_Element], start: int) -> tuple[np.ndarray, tuple[Cells, ...]]:
    first = source.data.count(b"\n", 0, start) + 1
    lines = [(line, text) for line, text in enumerate(source.data[start:].splitlines(), first) if text.strip()]
    if len(lines) != (expected := sum(element.count for element in elements)):
        raise source.error(
            f"its header promises {expected} records, one on each line, but {len(lines)} lines follow",
            "copy or export it again",
        )
    vertices, position = np.empty((0, 3)), 0
    cells: tuple[Cells, ...] = ()
    for element in elements:
        records = lines[position : position + element.count]
        position += element.count
        if element.name == "vertex":
            vertices = _ascii_vertices(source, element, records)
        elif element.name == "face":
            cells = _ascii_faces(source, element, records)
    return vertices, cells


def _ascii_vertices(source: Source, element: _Element, records: list[tuple[int, bytes]]) -> np.ndarray:
    columns = [element.column(axis) for axis in "xyz"]
    if element.lists:
        raise source.error("its vertices have lists, which are not read")
    vertices = np.empty((len(records), 3))
    for row, (line, text) in enumerate(records):
        words = text.split()
        try:
            if len(words) != len(element.properties):
                raise ValueError
            vertices[row] = numbers([words[k] for k in columns])
        except ValueError:
            raise source.error(
                f"line {line}: {len(element.properties)} finite numbers of a vertex are expected"
            ) from None
    return vertices


def _ascii_faces(source: Source, element: _Element, records: list[tuple[int, bytes]]) -> tuple[Cells, ...]:
    corner = _corner_column(element)
    faces = []
    for line, text in records:
        words = text.split()
        place, face = 0, None
        try:
            for k, (_, _, length) in enumerate(element.properties):
                count = 1 if length is None else whole(words[place])
                place += length is not None
                if count < 0 or place + count > len(words):
                    raise ValueError
                place += count
                if k == corner:
                    face = [whole(word) for word in words[place - count : place]]
                    break  # what follows is colour and texture, and not always as the header says
            more = len(element.properties) > corner + 1
            if (place != len(words) and not more) or face is None or len(face) < 3:
                raise ValueError
        except (ValueError, IndexError):
            raise source.error(f"line {line}: a face of three or more whole numbers is expected") from None
        faces.append(face)
    return cells_by_corners(source, faces, range(1, len(faces) + 1))


# --- binary -----------------------------------------------------------------------------------------------------------


def _binary(
    source: Source, elements: list[_Element], position: int, order: str
) -> tuple[np.ndarray, tuple[Cells, ...]]:
    vertices = np.empty((0, 3))
    cells: tuple[Cells, ...] = ()
    for element in elements:
        _check_left(source, element, position)
        if element.lists:
            records, position = _binary_lists(source, element, position, order)
        else:
            kind = np.dtype([(f"c{k}", order + kind) for k, (_, kind, _) in enumerate(element.properties)])
            _check_left(source, element, position, kind.itemsize)
            table = np.frombuffer(source.data, kind, element.count, position)
            position += element.count * kind.itemsize
            if element.name == "vertex":
                vertices = np.column_stack([table[f"c{element.column(axis)}"].astype(np.float64) for axis in "xyz"])
            continue
        if element.name == "vertex":
            raise source.error("its vertices have lists, which are not read")
        if element.name == "face":
            cells = (
                cells_by_corners(source, records, range(1, len(records) + 1))
                if isinstance(records, list)
                else (cells_of(source, records, np.arange(1, len(records) + 1)),)
            )
    if position != len(source.data):
        raise source.error(
            f"{len(source.data) - position} bytes follow the last record that its header promises",
            "copy or export it again",
        )
    return vertices, cells


def _check_left(source: Source, element: _Element, position: int, size: int = 1) -> None:
    if position + size * element.count > len(source.data):
        raise source.error(
            f"its header promises {element.count} records of {element.name}, but the file ends before",
            "copy or export it again",
        )


def _binary_lists(
    source: Source, element: _Element, position: int, order: str
) -> tuple[np.ndarray | list[list[int]], int]:
    """Corners of faces, as rows if all have equally many; those of other elements are passed over."""
    corner = _corner_column(element)
    lengths = _first_lengths(source, element, position, order)
    fields: list[tuple] = []
    for k, ((_, kind, length), count) in enumerate(zip(element.properties, lengths, strict=True)):
        if length is not None:
            fields.append((f"n{k}", order + length))
        fields.append((f"c{k}", order + kind, (count,)) if length is not None else (f"c{k}", order + kind))
    record = np.dtype(fields)
    if position + element.count * record.itemsize <= len(source.data):
        table = np.frombuffer(source.data, record, element.count, position)
        same = all(
            np.all(table[f"n{k}"] == count)
            for k, ((_, _, length), count) in enumerate(zip(element.properties, lengths, strict=True))
            if length is not None
        )
        if same:
            rows = table[f"c{corner}"].astype(np.int64) if corner >= 0 else np.empty((0, 3), dtype=np.int64)
            return rows, position + element.count * record.itemsize
    return _unequal_lists(source, element, position, order, corner)


def _first_lengths(source: Source, element: _Element, position: int, order: str) -> list[int]:
    if not element.count:
        return [0 if length is not None else 1 for _, _, length in element.properties]
    lengths = []
    for _, kind, length in element.properties:
        count = 1
        if length is not None:
            count, position = _list_length(source, element, position, order + length)
        lengths.append(count)
        position += count * np.dtype(kind).itemsize
    return lengths


def _list_length(source: Source, element: _Element, position: int, kind: str) -> tuple[int, int]:
    size = np.dtype(kind).itemsize
    _check_left(source, _Element(element.name, 1), position, size)
    count = np.frombuffer(source.data, kind, 1, position)[0]
    if not 0 <= count <= len(source.data) or count != int(count):
        raise source.error(f"a record of {element.name} has a list of impossible length")
    return int(count), position + size


def _unequal_lists(
    source: Source, element: _Element, position: int, order: str, corner: int
) -> tuple[list[list[int]], int]:
    faces = []
    for row in range(element.count):
        for k, (_, kind, length) in enumerate(element.properties):
            count = 1
            if length is not None:
                count, position = _list_length(source, element, position, order + length)
            size = count * np.dtype(kind).itemsize
            if position + size > len(source.data):
                raise source.error(
                    f"the file ends in record {row + 1} of {element.count} of {element.name}", "copy or export it again"
                )
            if k == corner:
                if count < 3:
                    raise source.error(f"face {row + 1} has {count} corners", "at least three are needed")
                faces.append(np.frombuffer(source.data, order + kind, count, position).tolist())
            position += size
    return faces, position
