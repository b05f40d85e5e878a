"""Files that are whole or refused: arrays and values with a version and a checksum over every byte.

A container is a magic number, the version of the format, the length of a JSON text, that text, the bytes of all arrays
in its order, and the SHA-256 of everything before. All numbers are little-endian.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
import struct
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

MAGIC = b"WEAVESIM"
# Of the layout above, and of the meaning of what is in it; a container of another version is not read.
FORMAT_VERSION = 1
_HEADER = struct.Struct("<8sIQ")
_DIGEST_SIZE = hashlib.sha256().digest_size
SMALLEST_SIZE = _HEADER.size + _DIGEST_SIZE
PARTIAL = ".partial"


class DamageError(Exception):
    """A container that is not what was written; the message is a reason to put after a colon."""


class Content(NamedTuple):
    """What a container holds.

    Attributes:
        values: plain values, as JSON has them; numbers may be infinite.
        arrays: by name.
    """

    values: dict[str, Any]
    arrays: dict[str, np.ndarray]


def packed(values: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> list[bytes | memoryview]:
    """A container, in parts to be written one after the other."""
    contiguous = {name: np.ascontiguousarray(array) for name, array in arrays.items()}
    table = [[name, array.dtype.str, list(np.shape(arrays[name]))] for name, array in contiguous.items()]
    text = json.dumps({"arrays": table, "values": values}, default=_built_in).encode()
    parts: list[bytes | memoryview] = [_HEADER.pack(MAGIC, FORMAT_VERSION, len(text)), text]
    parts += [array.reshape(-1).view(np.uint8).data for array in contiguous.values() if array.size]
    digest = hashlib.sha256()
    for part in parts:
        digest.update(part)
    return [*parts, digest.digest()]


def _built_in(value: Any) -> Any:
    """A number of NumPy as one of Python."""
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"{type(value).__name__} cannot be kept in a checkpoint")


def unpacked(data: bytes) -> Content:
    """The content of a container.

    Raises:
        DamageError: it is damaged, or of another version.
    """
    if len(data) < SMALLEST_SIZE:
        raise DamageError(f"it is cut off after {len(data)} bytes")
    magic, version, length = _HEADER.unpack_from(data)
    if magic != MAGIC:
        raise DamageError("it is no file of a checkpoint")
    if hashlib.sha256(memoryview(data)[:-_DIGEST_SIZE]).digest() != data[-_DIGEST_SIZE:]:
        raise DamageError("its checksum is wrong: it is damaged or cut off")
    if version != FORMAT_VERSION:
        raise DamageError(f"it is of version {version} of the format, and this weavesim reads {FORMAT_VERSION}")
    start = _HEADER.size + length
    try:
        content = json.loads(data[_HEADER.size : start])
        return Content(dict(content["values"]), dict(_arrays(data, start, content["arrays"])))
    except (ValueError, TypeError, KeyError, RecursionError) as error:  # a checksum is no signature
        raise DamageError(f"it is not as weavesim writes it ({type(error).__name__})") from None


def _arrays(data: bytes, start: int, table: Iterable[Any]) -> Iterator[tuple[str, np.ndarray]]:
    for name, kind, shape in table:
        dtype, count = np.dtype(kind), math.prod(shape)
        yield name, np.frombuffer(data, dtype, count, start).reshape(shape).copy()
        start += dtype.itemsize * count


def write_container(path: Path, values: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> None:
    """Write a container that is on the disk, whole and under its name, when this returns.

    Raises:
        OSError: it cannot be written; what was there before is untouched.
    """
    temporary = path.with_name(f".{path.name}{PARTIAL}")
    try:
        with open(temporary, "wb") as file:
            for part in packed(values, arrays):
                file.write(part)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
    finally:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)
    sync_folder(path.parent)


def read_container(path: Path) -> Content:
    """The content of a file.

    Raises:
        OSError: it cannot be read.
        DamageError: it is damaged, or of another version.
    """
    return unpacked(path.read_bytes())


def sync_folder(folder: Path) -> None:
    """Have the names of the files of a folder on the disk, where the system can do that."""
    if not hasattr(os, "O_DIRECTORY"):
        return
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
