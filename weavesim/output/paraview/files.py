"""Files of VTK in XML: unstructured grids, and the blocks and the times that name them."""

from __future__ import annotations

import sys
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from struct import Struct
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np

from ..files import replacing

_VTK_TYPES = {"float32": "Float32", "float64": "Float64", "int32": "Int32", "int64": "Int64", "uint8": "UInt8"}
_VTK_CELLS = {3: 5, 4: 9}
_BYTE_ORDER = "LittleEndian" if sys.byteorder == "little" else "BigEndian"

# Arrays of one file, by section; ``Packed`` ones are the same in many files.
Sections = tuple[tuple[str, Mapping[str, "np.ndarray | Packed"]], ...]
_HEADER = Struct("=4Q")
# Of zlib at level 0, and of its blocks: whether it is the last, its length, and that with all bits turned.
_STORED_HEAD, _STORED, _CHECK = b"\x78\x01", Struct("<?HH"), Struct(">I")
_LARGEST_STORED = 0xFFFF


class Packed:
    """An array that many files repeat, compressed once.

    Args:
        values: (count,) or (count, component_count).
    """

    def __init__(self, values: np.ndarray) -> None:
        self.dtype, self.ndim, self.shape = values.dtype, values.ndim, values.shape
        self.block = _block(values, 1)  # as small as at higher levels, in a sixth of the time


class Grid:
    """Cells of a mesh, which do not change.

    Args:
        faces: (face_count, 3) or (face_count, 4).
        cell_data: arrays that do not change either, by name.
        point_data: the same.
    """

    def __init__(
        self,
        faces: np.ndarray,
        cell_data: Mapping[str, np.ndarray] | None = None,
        point_data: Mapping[str, np.ndarray] | None = None,
    ) -> None:
        self._count, corners = faces.shape
        self._cells: dict[str, Packed] = {
            "connectivity": Packed(faces.astype(np.int32)),
            "offsets": Packed(np.arange(corners, corners * self._count + 1, corners, dtype=np.int32)),
            "types": Packed(np.full(self._count, _VTK_CELLS[corners], dtype=np.uint8)),
        }
        self._cell_data = {name: Packed(values) for name, values in (cell_data or {}).items()}
        self._point_data = {name: Packed(values) for name, values in (point_data or {}).items()}
        self._said: tuple[tuple[Any, ...], bytes] = (), b""

    def write(
        self,
        path: Path,
        points: np.ndarray,
        point_data: Mapping[str, np.ndarray] | None = None,
        cell_data: Mapping[str, np.ndarray] | None = None,
        run_id: str = "",
    ) -> None:
        """Write a VTU file, with all numbers as binary data after the XML.

        What changes is stored as it is, which is fast; what does not has been compressed before.

        Args:
            path: of the file.
            points: (node_count, 3).
            point_data, cell_data: by name, (count,) or (count, component_count); one of ``_VTK_TYPES``.
            run_id: goes into a comment, which every reader of XML skips.
        """
        sections: Sections = (
            ("Points", {"Points": points}),
            ("Cells", self._cells),
            ("PointData", {**(point_data or {}), **self._point_data}),
            ("CellData", {**(cell_data or {}), **self._cell_data}),
        )
        blocks = [_block_of(values) for _, arrays in sections for values in arrays.values()]
        key = (
            run_id,
            *(
                (name, values.dtype, values.shape, len(block))
                for (name, values), block in zip(_every(sections), blocks, strict=True)
            ),
        )
        if key != self._said[0]:  # else as in the frame before
            self._said = key, self._head(sections, blocks, len(points), run_id)
        # one write, not one of each block
        content = b"".join([self._said[1], *blocks, b"\n</AppendedData>\n</VTKFile>\n"])
        with replacing(path) as temporary, open(temporary, "wb") as file:
            file.write(content)

    def _head(self, sections: Sections, blocks: Sequence[bytes], point_count: int, run_id: str) -> bytes:
        """The XML before all blocks."""
        lines = [
            '<?xml version="1.0"?>',
            *([run_comment(run_id)] if run_id else []),
            f'<VTKFile type="UnstructuredGrid" version="1.0" byte_order="{_BYTE_ORDER}" header_type="UInt64" '
            'compressor="vtkZLibDataCompressor">',
            f'<UnstructuredGrid><Piece NumberOfPoints="{point_count}" NumberOfCells="{self._count}">',
            *_declarations(sections, blocks),
            "</Piece></UnstructuredGrid>",
            '<AppendedData encoding="raw">',
            "_",
        ]
        return "\n".join(lines).encode()


def run_comment(run_id: str) -> str:
    """A comment in XML that tells the run."""
    return f"<!-- weavesim run {run_id} -->"


def blocks_text(blocks: Mapping[str, str | Mapping[str, str]], run_id: str) -> str:
    """Text of a VTM file: named blocks in other files.

    Args:
        blocks: file of each, by name; or the files of a group of blocks.
        run_id: goes into a comment.
    """
    return (
        f'<?xml version="1.0"?>\n{run_comment(run_id)}\n'
        '<VTKFile type="vtkMultiBlockDataSet" version="1.0" byte_order="LittleEndian">\n'
        f"  <vtkMultiBlockDataSet>\n{_entries(blocks, '    ')}\n  </vtkMultiBlockDataSet>\n</VTKFile>\n"
    )


def _entries(blocks: Mapping[str, str | Mapping[str, str]], indent: str) -> str:
    lines = []
    for index, (name, content) in enumerate(blocks.items()):
        if isinstance(content, str):
            lines.append(f'{indent}<DataSet index="{index}" name={quoteattr(name)} file={quoteattr(content)}/>')
        else:
            lines.append(f'{indent}<Block index="{index}" name={quoteattr(name)}>')
            lines += [_entries(content, indent + "  "), f"{indent}</Block>"]
    return "\n".join(lines)


def times_text(files: Iterable[tuple[float, str]], run_id: str) -> str:
    """Text of a PVD file: (time [s], file) of each frame."""
    entries = "\n".join(f'    <DataSet timestep="{time!r}" file={quoteattr(file)}/>' for time, file in files)
    return (
        f'<?xml version="1.0"?>\n{run_comment(run_id)}\n'
        '<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">\n'
        f"  <Collection>\n{entries}\n  </Collection>\n</VTKFile>\n"
    )


def _every(sections: Sections) -> Iterator[tuple[str, np.ndarray | Packed]]:
    """Name and values of every array, in the order of their blocks."""
    for _, arrays in sections:
        yield from arrays.items()


def _declarations(sections: Sections, blocks: Sequence[bytes]) -> Iterator[str]:
    """Lines of XML that declare all arrays, whose ``blocks`` of bytes follow the XML."""
    offset, following = 0, iter(blocks)
    for section, arrays in sections:
        yield f"<{section}>"
        for name, values in arrays.items():
            shape = "" if values.ndim == 1 or section == "Cells" else f' NumberOfComponents="{values.shape[1]}"'
            yield (
                f'<DataArray type="{_VTK_TYPES[values.dtype.name]}" Name={quoteattr(name)}{shape} '
                f'format="appended" offset="{offset}"/>'
            )
            offset += len(next(following))
        yield f"</{section}>"


def _block_of(values: np.ndarray | Packed) -> bytes:
    return values.block if isinstance(values, Packed) else _block(values, 0)


def _block(values: np.ndarray, level: int) -> bytes:
    """One block of zlib with VTK's header: how many blocks, their size, that of a last partial one, and compressed."""
    data = np.ascontiguousarray(values).reshape(-1).view(np.uint8).data
    compressed = [zlib.compress(data, level)] if level else _stored(data)
    return b"".join([_HEADER.pack(1, values.nbytes, 0, sum(map(len, compressed))), *compressed])


def _stored(data: memoryview) -> list[bytes | memoryview]:
    """What zlib makes of data that it does not compress, without the memory that it gets ready to do so (RFC 1950)."""
    starts = range(0, max(len(data), 1), _LARGEST_STORED)
    parts: list[bytes | memoryview] = [_STORED_HEAD]
    for start in starts:
        part = data[start : start + _LARGEST_STORED]
        parts += [_STORED.pack(start == starts[-1], len(part), len(part) ^ 0xFFFF), part]
    return [*parts, _CHECK.pack(zlib.adler32(data))]
