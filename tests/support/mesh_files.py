"""Mesh files as other programs write them, made without the readers that are tested with them."""

import contextlib
import io
import struct
import warnings
from pathlib import Path

import numpy as np

from weavesim.meshes.formats.meshio_process import found_in
from weavesim.meshes.source import Source


def die(count: int = 8) -> tuple[np.ndarray, np.ndarray]:
    """A bowl 30 mm deep in a plate of 200 x 200 mm: nodes [mm] and ``count`` x ``count`` quadrilaterals, from above."""
    side = np.linspace(-100.0, 100.0, count + 1)
    x, y = (grid.ravel() for grid in np.meshgrid(side, side, indexing="ij"))
    share = np.clip(np.hypot(x, y) / 80.0, 0.0, 1.0)
    nodes = np.column_stack([x, y, -15.0 * (1.0 + np.cos(np.pi * share)) + 0.0])
    index = np.arange((count + 1) ** 2).reshape(count + 1, count + 1)
    quads = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1).reshape(-1, 4)
    return nodes, quads


def split(quads: np.ndarray) -> np.ndarray:
    """Two triangles of each quadrilateral."""
    return quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)


def ascii_solid(nodes: np.ndarray, triangles: np.ndarray, name: str = "die", end: bool = True) -> str:
    lines = [f"solid {name}"]
    for corners in nodes[triangles]:
        lines += ["facet normal 0 0 1", "  outer loop"]
        lines += [f"    vertex {x:.9g} {y:.9g} {z:.9g}" for x, y, z in corners]
        lines += ["  endloop", "endfacet"]
    return "\n".join([*lines, *([f"endsolid {name}"] if end else [])]) + "\n"


def binary_stl(nodes: np.ndarray, triangles: np.ndarray, header: bytes = b"", count: int | None = None) -> bytes:
    records = np.zeros(len(triangles), np.dtype([("n", "<f4", 3), ("c", "<f4", 9), ("a", "<u2")]))
    records["c"] = nodes[triangles].reshape(-1, 9)
    promised = len(triangles) if count is None else count
    return header.ljust(80, b"\0") + struct.pack("<I", promised) + records.tobytes()


def nodes_of_deck(nodes: np.ndarray, first: int = 1) -> str:
    return "".join(f"{first + k}, {x:.9g}, {y:.9g}, {z:.9g}\n" for k, (x, y, z) in enumerate(nodes))


def elements_of_deck(elements: np.ndarray, first: int = 1, first_node: int = 1) -> str:
    rows = enumerate((np.asarray(elements) + first_node).tolist())
    return "".join(f"{first + k}, {', '.join(map(str, row))}\n" for k, row in rows)


def obj_text(nodes: np.ndarray, faces: list) -> str:
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in nodes]
    return "\n".join([*lines, *("f " + " ".join(str(k + 1) for k in face) for face in faces)]) + "\n"


def written(folder: Path, name: str, content: str | bytes) -> Path:
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def area_of(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Areas of triangles as vectors, (m, 3)."""
    p, q, r = (vertices[triangles[:, k]] for k in range(3))
    return 0.5 * np.cross(q - p, r - p)


def meshio_within_this_process(source: Source, ending: str) -> tuple[int, bytes]:
    """In place of ``by_meshio._read_apart``, which takes half a second each time."""
    silent = io.StringIO()
    try:
        with contextlib.redirect_stdout(silent), contextlib.redirect_stderr(silent), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return 0, found_in(str(source.path), ending)
    except (Exception, SystemExit):
        return 1, b""
