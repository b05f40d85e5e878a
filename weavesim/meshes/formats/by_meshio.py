"""VTK, Gmsh and Medit files by meshio; what it says it read is compared with what the file promises."""

from __future__ import annotations

import io
import re
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np

from ..mesh_file import (
    POLYGON,
    QUAD,
    SECOND_ORDER,
    TRIANGLE,
    Cells,
    MeshFile,
    cells_of,
    check_finite,
    check_references,
)
from ..source import Source, counted, listed, whole

# File name ending: name of the format in meshio, and in words, and what its files begin with.
FORMATS = {
    ".vtk": ("vtk", "legacy VTK", b"# vtk"),
    ".vtu": ("vtu", "VTK in XML", b"<"),
    ".msh": ("gmsh", "Gmsh", b"$"),
    ".mesh": ("medit", "Medit", b""),
}
# Bounds of the process that reads: memory in bytes, and per byte of the file; time in seconds.
_LEAST_MEMORY = 2**30
_MEMORY_PER_BYTE = 24
_LONGEST = 600
_WITHOUT_SURFACE = re.compile(r"vertex|line\d*|empty")
_VOLUMES = re.compile(r"(tetra|hexahedron|wedge|pyramid|polyhedron|penta_prism|hexa_prism)\d*")


def read_by_meshio(source: Source) -> MeshFile:
    """Vertices and surface cells of a VTK, Gmsh or Medit file.

    Raises:
        InputError: damaged or cut off, volumes, or cells that meshio or this package does not read.
    """
    ending, name, start = FORMATS[source.suffix]
    if not source.data.lstrip().lower().startswith(start):
        raise source.misnamed(name)
    promised = _PROMISED[ending](source)
    if promised is not None and promised > len(source.data):
        raise source.error(f"it promises {promised} cells, more than a file of this size can have")
    points, blocks = _blocks(source, ending, name)
    found = sum(len(nodes) for _, nodes in blocks)
    if promised is not None and found != promised:
        raise source.error(
            f"it promises {promised} cells, but meshio can read {found} of them: the others are of kinds that it does "
            "not know, or the file is cut off",
            "write triangles and quadrilaterals only, in one piece",
        )
    vertices = np.zeros((len(points), 3))
    if points.ndim != 2 or not 2 <= points.shape[1] <= 3 or points.dtype.kind not in "iuf":
        raise source.error("its points have no x, y and z")
    vertices[:, : points.shape[1]] = points
    check_finite(source, vertices)
    return _mesh(source, name, vertices, blocks)


def _mesh(source: Source, name: str, vertices: np.ndarray, blocks: list[tuple[str, np.ndarray]]) -> MeshFile:
    cells: dict[tuple[str, int], list[tuple[np.ndarray, np.ndarray]]] = {}
    left_out: dict[str, int] = {}
    first = 1
    for kind, nodes in blocks:
        labels = np.arange(first, first + len(nodes))
        first += len(nodes)
        if not len(nodes):
            continue
        if _WITHOUT_SURFACE.fullmatch(kind):
            left_out[kind] = left_out.get(kind, 0) + len(nodes)
            continue
        if _VOLUMES.fullmatch(kind):
            raise source.error(
                f"it contains {counted(len(nodes), 'cell')} of kind {kind}, which fill a volume",
                "write its surface only",
            )
        if kind not in (TRIANGLE, QUAD, POLYGON, *SECOND_ORDER):
            raise source.error(
                f"it contains {counted(len(nodes), 'cell')} of kind {kind}, which is not read", "write first order only"
            )
        check_references(source, nodes, labels, len(vertices), "cell")
        # of first order, the number of corners says the kind: a polygon may be a triangle
        cells.setdefault((kind if kind in SECOND_ORDER else "", nodes.shape[1]), []).append((nodes, labels))
    notes = []
    if left_out:
        found = listed([f"{count} {kind}" for kind, count in left_out.items()], 10)
        notes.append(f"cells that bound no surface left out: {found}")
    result = []
    for (kind, _), parts in cells.items():
        nodes, labels = (np.concatenate(part) for part in zip(*parts, strict=True))
        result.append(Cells(kind, kind, nodes, labels) if kind else cells_of(source, nodes, labels, "cell"))
    if not result:
        raise source.error(
            f"it contains no triangles or quadrilaterals, {listed(notes)}" if notes else "it has no cells"
        )
    return MeshFile(source.name, name, vertices, tuple(result), tuple(notes), "cell")


def _blocks(source: Source, ending: str, name: str) -> tuple[np.ndarray, list[tuple[str, np.ndarray]]]:
    """Points, and cells by kind in the order of the file; read in a process of its own (``meshio_process.py``)."""
    code, content = _read_apart(source, ending)
    if code == 3:
        raise source.error("it needs far more memory than a file of its size should: it is damaged")
    if code:
        raise source.error(f"it is damaged, or uses a part of {name} that meshio does not know, like strips or pixels")
    with np.load(io.BytesIO(content), allow_pickle=False) as found:
        points = found["points"]
        blocks = [(str(kind), found[f"nodes_{k}"]) for k, kind in enumerate(found["kinds"])]
    if any(nodes.ndim != 2 or nodes.dtype.kind not in "iu" for _, nodes in blocks):
        raise source.error(f"it contains cells without a fixed number of corners, which are not read from {name}")
    return points, [(kind, nodes.astype(np.int64)) for kind, nodes in blocks]


def _read_apart(source: Source, ending: str) -> tuple[int, bytes]:
    """Exit code and output of ``meshio_process.py``."""
    memory = _LEAST_MEMORY + _MEMORY_PER_BYTE * len(source.data)
    program = Path(__file__).with_name("meshio_process.py")
    # -P: modules beside the program must not hide those of the library
    command = [sys.executable, "-P", str(program), str(source.path.absolute()), ending, str(memory), str(_LONGEST)]
    try:
        done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, timeout=_LONGEST)
    except subprocess.TimeoutExpired:
        raise source.error(f"meshio takes longer than {_LONGEST} s for it", "convert it to STL, PLY or OBJ") from None
    except OSError as error:
        raise source.error(f"meshio cannot be started ({error.strerror})", "convert it to STL, PLY or OBJ") from None
    return done.returncode, done.stdout


# --- what files promise -----------------------------------------------------------------------------------------------


def _in_vtk(source: Source) -> int | None:
    head = source.data[:4096]
    dataset = re.search(rb"(?im)^dataset[ \t]+(\w+)", head)
    kind = dataset.group(1).decode("ascii", "replace").upper() if dataset else "MISSING"
    if kind not in ("UNSTRUCTURED_GRID", "STRUCTURED_GRID"):
        raise source.error(
            f"its dataset is {kind[:30]}; UNSTRUCTURED_GRID and STRUCTURED_GRID are read",
            "save it as an unstructured grid (.vtu), or as STL or PLY",
        )
    points = re.search(rb"(?im)^points[ \t]+(\d{1,18})", source.data)
    if points and int(points.group(1)) > len(source.data):
        raise source.error(f"it promises {int(points.group(1))} points, more than a file of this size can have")
    if kind == "STRUCTURED_GRID":
        size = re.search(rb"(?im)^dimensions[ \t]+(\d{1,9})[ \t]+(\d{1,9})[ \t]+(\d{1,9})", head)
        if not size:
            raise source.error("its grid has no dimensions")
        cells = 1
        for extent in map(int, size.groups()):
            cells *= max(extent - 1, 1)
        return cells
    types = _matched(source, rb"(?im)^cell_types[ \t]+(\d{1,18})")
    cells = _matched(source, rb"(?im)^cells[ \t]+(\d{1,18})")
    cells -= bool(re.search(rb"(?m)^OFFSETS[ \t]", source.data))  # since version 5 their ends are counted
    if cells != types:
        raise source.error(f"it promises {cells} cells, but the types of {types}")
    return types


def _in_vtu(source: Source) -> int | None:
    end = source.data.find(b"<AppendedData")
    head = source.data[: end if end >= 0 else None]
    if b"<VTKFile" not in head:
        raise source.misnamed("VTK in XML")
    pieces = re.findall(rb"<Piece\b[^>]*>", head)
    counts = [re.search(rb"NumberOfCells\s*=\s*[\"'](\d{1,18})[\"']", piece) for piece in pieces]
    if not pieces or not all(counts):
        kind = re.search(rb"<VTKFile\b[^>]*\btype\s*=\s*[\"'](\w{1,30})[\"']", head)
        what = kind.group(1).decode() if kind else "unknown"
        raise source.error(f"it has no cells that it counts (its type is {what})", "save it as an unstructured grid")
    return sum(int(count.group(1)) for count in counts if count)


def _in_gmsh(source: Source) -> int | None:
    version = re.search(rb"(?m)^\$MeshFormat\s+([\d.]{1,10})\s+([01])\s+(\d)", source.data)
    if not version:
        raise source.error("it is no mesh of Gmsh in format 2 or 4", "save it in one of these")
    start = re.search(rb"(?m)^\$Elements[ \t]*\r?\n", source.data)
    if not start:
        raise source.error("it has no elements, or is cut off before them")
    if b"$EndElements" not in source.data[start.end() :]:
        raise source.error("it ends before $EndElements: it was cut off", "copy or export it again")
    if version.group(2) == b"0":
        _check_lines_of_gmsh(source, start.end(), version.group(1).startswith(b"2"))
    if version.group(1).startswith(b"2"):
        return _matched(source, rb"(?m)^\$Elements[ \t]*\r?\n\s*(\d{1,18})")
    if version.group(2) == b"1":  # binary: four numbers, the second counts elements
        if len(source.data) < start.end() + 16:
            raise source.error("it ends within its elements")
        return struct.unpack_from("<2Q" if version.group(3) == b"8" else "<2I", source.data, start.end())[1]
    return _matched(source, rb"(?m)^\$Elements[ \t]*\r?\n\s*\d+\s+(\d{1,18})")


def _check_lines_of_gmsh(source: Source, start: int, second: bool) -> None:
    """Check that the elements of a text have as many lines as it promises; meshio passes over what is left.

    Raises:
        InputError: they have not.
    """
    lines = source.data[start : source.data.index(b"$EndElements", start)].split(b"\n")
    lines = [line for line in lines if line.strip()]
    try:
        head = [whole(word) for word in lines[0].split()]
        expected = 1 + (head[0] if second else head[0] + head[1])
    except (ValueError, IndexError):
        raise source.error("it does not say how many elements it has") from None
    if len(lines) != expected:
        raise source.error(
            f"it promises elements on {expected - 1} lines, but has {len(lines) - 1}", "copy or export it again"
        )


def _in_medit(source: Source) -> int | None:
    if b"MeshVersionFormatted" not in source.data[:1000]:
        raise source.misnamed("Medit's text format")
    text = re.sub(rb"#[^\n]*", b"", source.data)
    kinds = rb"(?m)^\s*(?:Edges|Triangles|Quadrilaterals|Tetrahedra|Prisms|Pyramids|Hexahedra|Hexaedra)\s+(\d{1,18})\b"
    return sum(map(int, re.findall(kinds, text)))


def _matched(source: Source, pattern: bytes) -> int:
    found = re.search(pattern, source.data)
    if not found:
        raise source.error("it does not say how many cells it has")
    return int(found.group(1))


_PROMISED = {"vtk": _in_vtk, "vtu": _in_vtu, "gmsh": _in_gmsh, "medit": _in_medit}
