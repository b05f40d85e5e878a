"""The command line of weavesim, recording all bits of all frames; scripts/same_results.py starts it.

    PYTHONPATH=CHECKOUT python -P scripts/comparison/recorded_run.py RECORD.npz double-dome --out FOLDER

Tables have nine digits and films are in single precision, so frames are recorded when created. RECORD.npz contains

- ``frames/NAME``: every number of every frame, (frame_count, ...), named as in ``Frame``: ``energies.kinetic``;
- ``frames/sha256 of NAME``: hashes of the arrays over nodes and elements, one per frame;
- ``last/NAME``: these arrays of the last frame.
"""

from __future__ import annotations

import dataclasses
import hashlib
import os
import runpy
import sys
from collections.abc import Iterator, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

# Modules that define ``Frame``, newest version first.
FRAME_PLACES = ("weavesim", "weavesim.recording")
# Larger arrays are stored as hashes.
LARGEST_NUMBER_COUNT = 32


def frame_class() -> type:
    """The ``Frame`` class of the imported weavesim."""
    for place in FRAME_PLACES:
        try:
            return import_module(place).Frame
        except (ImportError, AttributeError):
            continue
    raise SystemExit(f"this weavesim has no Frame in {', '.join(FRAME_PLACES)}: add its module to {__file__}")


def numbers(value: Any, name: str = "") -> Iterator[tuple[str, np.ndarray]]:
    """Everything in a frame by name, with dots between nested names."""
    if dataclasses.is_dataclass(value):
        value = {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}
        for sheet in value.pop("sheets", ()):
            # in older versions frames had these themselves
            value |= {part: getattr(sheet, part) for part in ("position", "director", "fields")}
    if isinstance(value, Mapping):
        for key, item in value.items():
            yield from numbers(item, f"{name}.{key}" if name else str(key))
    elif value is not None:
        yield name, np.asarray(value)


class Record:
    """Stores frames by index; a frame that is created twice is stored once, in its last form."""

    def __init__(self) -> None:
        self._rows: dict[int, dict[str, np.ndarray]] = {}
        self._last: dict[str, np.ndarray] = {}

    def add(self, frame: Any) -> None:
        row, large = {}, {}
        for name, value in numbers(frame):
            if value.size > LARGEST_NUMBER_COUNT:
                large[name] = value.copy()
                digest = hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest()
                row[f"sha256 of {name}"] = np.array(digest, dtype="S64")
            else:
                row[name] = value.copy()
        self._rows[int(frame.index)] = row
        self._last = large

    def write(self, path: Path) -> None:
        rows = [row for _, row in sorted(self._rows.items())]
        frames = {f"frames/{name}": np.stack([row[name] for row in rows]) for name in rows[0]} if rows else {}
        np.savez(path, **frames, **{f"last/{name}": value for name, value in self._last.items()})


def main() -> None:
    path = Path(sys.argv[1])
    checkout = Path(os.environ["PYTHONPATH"]).resolve()
    import weavesim

    if not Path(weavesim.__file__).resolve().is_relative_to(checkout):
        raise SystemExit(f"{weavesim.__file__} was imported, which is not in {checkout}")
    kind, record = frame_class(), Record()
    make = kind.__init__

    def made(frame: Any, *arguments: Any, **named: Any) -> None:
        make(frame, *arguments, **named)
        record.add(frame)

    kind.__init__ = made  # type: ignore[misc]
    # one id for all, where runs have ids, so that files can be compared byte by byte
    frames = sys.modules[kind.__module__]
    if hasattr(frames, "new_run_id"):
        frames.new_run_id = lambda: "compared"
    sys.argv = ["weavesim", *sys.argv[2:]]
    try:
        runpy.run_module("weavesim", run_name="__main__")
    finally:
        record.write(path)


if __name__ == "__main__":
    main()
