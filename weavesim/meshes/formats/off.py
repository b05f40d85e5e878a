"""OFF: vertices and faces with any number of corners, colours and normals passed over."""

from __future__ import annotations

import re

import numpy as np

from ..mesh_file import MeshFile, cells_by_corners, check_references
from ..source import LARGEST_COUNT, Source, numbers, whole

# OFF with colours (C), normals (N) or texture coordinates (ST) per vertex; other letters change the dimension.
_HEADER = re.compile(rb"(?:ST)?C?N?OFF\Z")


def read_off(source: Source) -> MeshFile:
    """Vertices and surface cells of an OFF file, ASCII.

    Raises:
        InputError: damaged or cut off, in binary or of another dimension, or no OFF.
    """
    rows = []
    for line, text in enumerate(source.data.splitlines(), 1):
        words = text.split(b"#", 1)[0].split()
        if words:
            rows.append((line, words))
    if not rows or not rows[0][1][0].endswith(b"OFF"):
        raise source.misnamed("OFF", "no OFF file")
    head = rows[0][1]
    if not _HEADER.match(head[0]) or head[1:2] == [b"BINARY"]:
        raise source.error("it is OFF in binary, or of another dimension than three", "export ASCII OFF, STL or PLY")
    rest = rows[1:]
    counts = head[1:]
    if not counts:
        if not rest:
            raise source.error("it ends after its first line")
        counts, rest = rest[0][1], rest[1:]
    try:
        vertex_count, face_count = (whole(count) for count in counts[:2])
        if min(vertex_count, face_count) < 0 or max(vertex_count, face_count) > LARGEST_COUNT:
            raise ValueError
    except ValueError:
        raise source.error("it does not begin with the numbers of vertices and faces") from None
    if len(rest) != vertex_count + face_count:
        raise source.error(
            f"it promises {vertex_count} vertices and {face_count} faces, one a line, but {len(rest)} lines follow",
            "copy or export it again",
        )
    vertices = np.empty((vertex_count, 3))
    for row, (line, words) in enumerate(rest[:vertex_count]):
        try:
            vertices[row] = numbers(words[:3])
        except ValueError:
            raise source.error(f"line {line}: three finite coordinates are expected") from None
    faces, labels = [], []
    for line, words in rest[vertex_count:]:
        try:
            count = whole(words[0])
            face = [whole(word) for word in words[1 : 1 + count]]
            if count < 3 or len(face) != count:
                raise ValueError
        except ValueError:
            raise source.error(f"line {line}: a face of three or more whole numbers is expected") from None
        faces.append(face)
        labels.append(line)
    cells = cells_by_corners(source, faces, labels)
    for block in cells:
        check_references(source, block.nodes, block.labels, vertex_count, "the face at line")
    return MeshFile(source.name, "OFF", vertices, cells, (), "line")
