"""Wavefront OBJ: vertices and faces of all objects and groups."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import numpy as np

from ...errors import InputError
from ..kinds import is_text, looks_like
from ..mesh_file import MeshFile, cells_by_corners
from ..source import Source, numbers, whole

# Statements without a surface: texture, normals, names, materials, display.
_WITHOUT_SHAPE = frozenset(
    b"vt vn vp o g s mg usemtl mtllib usemap maplib lod bevel c_interp d_interp shadow_obj trace_obj".split()
)
_CURVED = frozenset(
    b"cstype deg bmat step curv curv2 surf parm trim hole scrv sp end con ctech stech bzp bsp cdc cdp res".split()
)


def read_obj(source: Source) -> MeshFile:
    """Vertices and surface cells of an OBJ file.

    Raises:
        InputError: damaged, or curved surfaces, references to other files, or something that is no OBJ.
    """
    kind = looks_like(source.data)
    if not is_text(source.data) or (kind and "OBJ" not in kind):
        raise source.error(
            f"it looks like {kind or 'binary data'}, not like OBJ", "give it the name of its format, or export OBJ"
        )
    vertices: list[list[float]] = []
    faces: list[list[int]] = []
    labels: list[int] = []
    left_out: Counter[bytes] = Counter()
    for line, fields in _statements(source.data):
        key = fields[0]
        try:
            if key == b"v":
                if len(fields) not in (4, 5, 7, 8):
                    raise source.error(f"line {line}: a vertex needs three coordinates")
                values = numbers(fields[1:5] if len(fields) == 5 else fields[1:4])  # colours may be anything
                if len(fields) == 5 and values[3] != 1.0:
                    raise source.error(f"line {line}: a vertex has a weight, which only curved surfaces need")
                vertices.append(values[:3])
            elif key == b"f" or key == b"fo":
                here = len(vertices)
                corners = [whole(field.split(b"/", 1)[0]) for field in fields[1:]]
                if len(corners) < 3 or 0 in corners:
                    raise source.error(f"line {line}: a face needs three or more corners, counted from 1 or -1")
                faces.append([corner - 1 if corner > 0 else here + corner for corner in corners])
                labels.append(line)
            elif key in (b"l", b"p"):
                left_out[key] += 1
            elif key in _CURVED:
                raise source.error(
                    f"line {line}: curved surfaces ({key.decode()}) are not read", "export the tool as a triangle mesh"
                )
            elif key in (b"call", b"csh"):
                raise source.error(f"line {line}: other files are not read", "copy them into this one")
            elif key not in _WITHOUT_SHAPE:
                raise source.error(f"line {line}: not a statement of OBJ")
        except InputError:
            raise
        except ValueError:
            raise source.error(f"line {line}: finite numbers are expected, with decimal points") from None
    points = np.array(vertices, dtype=np.float64).reshape(-1, 3)
    for face, label in zip(faces, labels, strict=True):
        if min(face) < 0 or max(face) >= len(points):
            raise source.error(f"line {label}: a face uses a vertex that is not there (there are {len(points)})")
    notes = []
    if left_out:
        notes.append(f"{left_out[b'l']} lines and {left_out[b'p']} points left out: they bound no surface")
    return MeshFile(source.name, "OBJ", points, cells_by_corners(source, faces, labels), tuple(notes), "line")


def _statements(data: bytes) -> Iterator[tuple[int, list[bytes]]]:
    """Number of the last line and words of every statement, without comments."""
    begun: list[bytes] = []
    for line, text in enumerate(data.splitlines(), 1):
        if b"#" in text:
            text = text[: text.index(b"#")]
        fields = text.split()
        if fields and fields[-1].endswith(b"\\"):  # goes on in the next line
            begun += [*fields[:-1], *([fields[-1][:-1]] if fields[-1] != b"\\" else [])]
            continue
        if begun:
            fields, begun = begun + fields, []
        if fields:
            yield line, fields
    if begun:
        yield line, begun
