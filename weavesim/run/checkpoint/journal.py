"""All frames of a run so far, one after the other in one file: a run that goes on shows them to its observers again."""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ..frame import Frame, SheetFrame
from .container import SMALLEST_SIZE, Content, DamageError, packed, unpacked

_LENGTH = struct.Struct("<Q")
_OF_FRAME = ("tool_displacement", "tool_reaction", "support_force", "drive_displacement", "drive_force")


def frame_content(frame: Frame) -> Content:
    """A frame as values and arrays; numbers that single precision holds without loss take half the space."""
    arrays = {name: getattr(frame, name) for name in _OF_FRAME}
    sheets = []
    for place, sheet in enumerate(frame.sheets):
        arrays |= {f"{place}/position": sheet.position, f"{place}/director": sheet.director}
        arrays |= {f"{place}/fields/{name}": values for name, values in sheet.fields.items()}
        # lists keep their order, which tables and sums depend on
        sheets.append([sheet.name, list(sheet.fields), list(sheet.energies.items())])
    kinds = {name: np.asarray(array).dtype.str for name, array in arrays.items()}
    values = {
        "index": frame.index, "step_count": frame.step_count, "time": frame.time, "stroke": frame.stroke,
        "energies": list(frame.energies.items()), "sheets": sheets, "kinds": kinds,
    }  # fmt: skip
    return Content(values, {name: _shortened(np.asarray(array)) for name, array in arrays.items()})


def frame_of(content: Content) -> Frame:
    """The frame that ``frame_content`` took apart, with the same bits."""
    values, kinds = content.values, content.values["kinds"]
    arrays = {name: array.astype(kinds[name]) for name, array in content.arrays.items()}
    sheets = tuple(
        SheetFrame(
            name=name,
            position=arrays[f"{place}/position"],
            director=arrays[f"{place}/director"],
            fields={field: arrays[f"{place}/fields/{field}"] for field in fields},
            energies=dict(energies),
        )
        for place, (name, fields, energies) in enumerate(values["sheets"])
    )
    numbers: dict[str, Any] = {name: values[name] for name in ("index", "step_count", "time", "stroke")}
    own = {name: arrays[name] for name in _OF_FRAME}
    return Frame(sheets=sheets, energies=dict(values["energies"]), **numbers, **own)


def _shortened(values: np.ndarray) -> np.ndarray:
    if values.dtype != np.float64:
        return values
    with np.errstate(over="ignore", invalid="ignore", under="ignore"):
        short = values.astype(np.float32)
    return short if short.astype(np.float64).tobytes() == values.tobytes() else values


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
            file.truncate(self.size)
            file.seek(self.size)
            file.write(_LENGTH.pack(length))
            for part in parts:
                file.write(part)
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
