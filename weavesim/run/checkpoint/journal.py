"""All frames of a run so far, one after the other in one file: a run that goes on shows them to its observers again."""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator, Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any, Literal

import numpy as np

from ..frame import Frame, SheetFrame
from .container import SMALLEST_SIZE, Content, DamageError, packed, unpacked

_LENGTH = struct.Struct("<Q")
# What a frame is made of.
_KINDS: dict[str, type] = {"Frame": Frame, "SheetFrame": SheetFrame}


def frame_content(frame: Frame) -> Content:
    """A frame as values and arrays, whatever it has; numbers that single precision holds without loss take half the
    space.
    """
    arrays: dict[str, np.ndarray] = {}
    with np.errstate(over="ignore", invalid="ignore", under="ignore"):  # of ``_shortened``
        return Content({"frame": _taken_apart(frame, "frame", arrays)}, arrays)


def frame_of(content: Content) -> Frame:
    """The frame that ``frame_content`` took apart, with the same bits."""
    return _put_together(content.values["frame"], content.arrays)


def _taken_apart(value: Any, name: str, arrays: dict[str, np.ndarray]) -> Any:
    """A value as JSON has it, with its kind; its arrays are moved to ``arrays``."""
    if isinstance(value, np.ndarray):
        arrays[name] = _shortened(value)
        # sums over an array depend on the order of its entries in memory
        return ["array", name, value.dtype.str, memory_order(value)]
    if isinstance(value, dict):
        # a list keeps the order, which tables and sums depend on
        return ["dict", [[key, _taken_apart(entry, f"{name}/{key}", arrays)] for key, entry in value.items()]]
    if isinstance(value, tuple):
        return ["tuple", [_taken_apart(entry, f"{name}/{place}", arrays) for place, entry in enumerate(value)]]
    if type(value) in _KINDS.values():
        entries = {f.name: getattr(value, f.name) for f in fields(value)}
        return [type(value).__name__, _taken_apart(entries, name, arrays)]
    return ["value", value]


def _put_together(described: Any, arrays: Mapping[str, np.ndarray]) -> Any:
    kind, content, *layout = described
    if kind == "array":
        return arrays[content].astype(layout[0], order=layout[1])
    if kind == "dict":
        return {key: _put_together(entry, arrays) for key, entry in content}
    if kind == "tuple":
        return tuple(_put_together(entry, arrays) for entry in content)
    return _KINDS[kind](**_put_together(content, arrays)) if kind in _KINDS else content


def memory_order(array: np.ndarray) -> Literal["C", "F"]:
    """ "F" if the first index is the fastest in memory, else "C"."""
    return "F" if array.ndim > 1 and abs(array.strides[0]) < abs(array.strides[-1]) else "C"


def _shortened(values: np.ndarray) -> np.ndarray:
    if values.dtype != np.float64:
        return values
    short = values.astype(np.float32)
    # bits, which tell zeros and what is not a number apart
    same = short.astype(np.float64).view(np.int64) == values.view(np.int64)
    return short if same.all() else values


class FrameJournal:
    """The file of frames of one run.

    Args:
        path: of the file.

    Attributes:
        count: frames in it.
        size: of these [bytes]; what may follow them belongs to no frame.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.count = self.size = 0

    def begin(self) -> None:
        """Begin without frames.

        Raises:
            OSError: the file cannot be written.
        """
        self.path.write_bytes(b"")
        self.count = self.size = 0

    def append(self, frame: Frame) -> None:
        """Add a frame; where that fails, the next attempt begins at the same place.

        Raises:
            OSError: it cannot be written.
        """
        parts = packed(*frame_content(frame))
        length = sum(len(part) for part in parts)
        with open(self.path, "r+b") as file:
            # what a killed run or a full disk left of another frame
            if file.seek(0, os.SEEK_END) != self.size:
                file.truncate(self.size)
                file.seek(self.size)
            file.write(b"".join([_LENGTH.pack(length), *parts]))
        self.count += 1
        self.size += _LENGTH.size + length

    def sync(self) -> None:
        """Have all frames on the disk when this returns.

        Raises:
            OSError: they cannot be written.
        """
        with open(self.path, "r+b") as file:
            os.fsync(file.fileno())

    def frames(self, count: int, size: int) -> Iterator[Frame]:
        """The first frames, which ``append`` goes on behind.

        Args:
            count: of frames.
            size: of them together [bytes].

        Raises:
            OSError: the file cannot be read.
            DamageError: it is damaged.
        """
        self.count = self.size = 0
        with open(self.path, "rb") as file:
            while self.count < count:
                head = file.read(_LENGTH.size)
                length = _LENGTH.unpack(head)[0] if len(head) == _LENGTH.size else 0
                if not SMALLEST_SIZE <= length <= size - self.size - _LENGTH.size:
                    raise DamageError(f"frame {self.count} of {count} is damaged or cut off")
                yield frame_of(unpacked(file.read(length)))
                self.count += 1
                self.size += _LENGTH.size + length
        if self.size != size:
            raise DamageError(f"its {count} frames take {self.size} bytes instead of {size}")
