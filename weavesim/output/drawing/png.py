"""PNG files of pictures without transparency."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Mapping

import numpy as np

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
# Of zlib; the usual 6 takes twice the time for a few per cent.
_LEVEL = 3
_LARGEST_MEMORY = 9


def png_of(pixels: np.ndarray, dots_per_inch: float, texts: Mapping[str, str] | None = None) -> bytes:
    """A picture as a PNG file.

    Rows are packed as they are: pictures of few colours have equal pixels side by side. Pillow, which tries five
    filters for every row, takes twice as long, and its files are larger.

    Args:
        pixels: red, green and blue, whatever else is left out, (height, width, 3 or more) uint8.
        dots_per_inch: for programs that show it in its size.
        texts: by keyword, which are Latin-1; see section 11.3.3 of the specification.
    """
    height, width = pixels.shape[:2]
    rows = np.zeros((height, 1 + 3 * width), dtype=np.uint8)  # each begins with its filter, 0 is none
    rows[:, 1:].reshape(height, width, 3)[:] = pixels[:, :, :3]
    packer = zlib.compressobj(_LEVEL, zlib.DEFLATED, zlib.MAX_WBITS, _LARGEST_MEMORY)
    per_metre = round(dots_per_inch / 0.0254)
    return b"".join(
        (
            _SIGNATURE,
            _chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)),
            _chunk(b"pHYs", struct.pack(">IIB", per_metre, per_metre, 1)),
            *(_chunk(b"tEXt", f"{word}\0{text}".encode("latin-1")) for word, text in (texts or {}).items()),
            _chunk(b"IDAT", packer.compress(rows.data) + packer.flush()),
            _chunk(b"IEND", b""),
        )
    )


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(data, zlib.crc32(kind)))
