"""The checksum of ``results.h5``: SHA-256 of everything after the block that HDF5 leaves free at its start.

It is compared before HDF5 reads a byte, so that no damage gets as far as a number, or into a library in C.
"""

from __future__ import annotations

import hashlib
from pathlib import Path

from ...errors import InputError
from ...input_files import shown
from ..claim.record import file_hash

USER_BLOCK = 512
AGAIN = (
    "copy the folder again from where it was written, or repeat the run with weavesim rerun; a file that was changed "
    "on purpose is no result of a run"
)
_START = b"weavesim results, SHA-256 of all bytes from 512 on: "
_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_CHUNK = 2**20


def seal(path: Path) -> None:
    """Write the checksum of an HDF5 file into its first block, which it leaves free."""
    block = _block(path)
    with open(path, "r+b") as file:
        file.write(block)


def check_seal(path: Path, recorded: str | None = None) -> None:
    """Check a file against its checksum.

    Args:
        path: of the file.
        recorded: SHA-256 of the whole file, from elsewhere; for a file of a version that has no checksum of its own.

    Raises:
        InputError: it is not what was written.
    """
    try:
        with open(path, "rb") as file:
            start = file.read(USER_BLOCK)
        if start.startswith(_SIGNATURE):
            whole = recorded is None or file_hash(path) == recorded
        else:
            whole = start == _block(path)
    except OSError as error:
        raise InputError(f"results {shown(path)}: cannot be read ({shown(error)})") from None
    if not whole:
        raise InputError(f"results {shown(path)}: damaged: it is not what was written, by its checksum; {AGAIN}")


def _block(path: Path) -> bytes:
    digest = hashlib.sha256()
    with open(path, "rb") as file:
        file.seek(USER_BLOCK)
        while chunk := file.read(_CHUNK):
            digest.update(chunk)
    return (_START + digest.hexdigest().encode() + b"\n").ljust(USER_BLOCK, b"\0")
