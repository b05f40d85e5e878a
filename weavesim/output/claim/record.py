"""``run.json``: which run the files of a folder belong to, and everything that is needed to repeat it."""

from __future__ import annotations

import hashlib
import json
import os
import platform
import socket
import sys
from collections.abc import Collection, Iterator, Mapping
from contextlib import suppress
from datetime import UTC, datetime
from fnmatch import fnmatch
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from ...device import cpu_features
from ...run.frame import Frame, RunInfo
from ...version import __version__
from ..files import summary_text, write_text
from ..pace import Pace
from .source import processor_name, source_commit

RECORD_NAME = "run.json"
SETUP_NAME = "setup.json"
# Files of which every frame adds some: they are recorded together from time to time, and found by this pattern too.
NUMBERED = "paraview/frame_[0-9][0-9][0-9][0-9]*.vt[um]"
# Packages whose versions may change a result.
PACKAGES = ("warp-lang", "numpy", "trimesh", "meshio", "pydantic")
_CHUNK = 1 << 20


class RunRecord:
    """The record of a run in its folder, written again whenever a file is added, of each frame only from time to time.

    Args:
        folder: of the run.
        info: about the run.
        options: given by the user, by name.
    """

    def __init__(self, folder: Path, info: RunInfo, options: Mapping[str, Any]) -> None:
        self._folder = folder
        self._names: dict[str, str] = {}  # as JSON
        self._pace = Pace()
        self._hashes: dict[str, str] = {}
        self._hashed: dict[str, tuple[tuple[int, ...], str]] = {}  # state and hash of files so far
        self._content: dict[str, Any] = {
            "run_id": info.run_id,
            "name": info.name,
            "started": datetime.now(UTC).isoformat(timespec="seconds"),
            "process": os.getpid(),
            "host": socket.gethostname(),
            "command": list(sys.argv),
            "folder": os.getcwd(),
            "options": dict(options),
            "input_files": dict(_input_files(options)),
            "resumed": list(info.parts),
            "setup_hash": info.setup.content_hash if info.setup else None,
            "device": info.device,
            "precision": info.precision,
            "versions": versions(),
            "commit": source_commit(),
            "processor": processor_name(),
            "system": platform.platform(),
            "processor_features": cpu_features(),
        }

    def write(self) -> None:
        """Write the file."""
        # written often, with hundreds of names: as JSON with an indent, but without its encoder
        lines = [
            f'\n    {text}: "{self._hashes[name]}"' if name in self._hashes else f"\n    {text}: null"
            for name, text in self._names.items()
        ]
        files = f"{','.join(lines)}\n  " if lines else ""
        content = summary_text(self._content).removesuffix("\n}\n")
        write_text(self._folder / RECORD_NAME, f'{content},\n  "files": {{{files}}}\n}}\n')

    def add(self, path: Path) -> None:
        """A file is about to be written; files outside the folder are not recorded."""
        with suppress(ValueError):
            name = path.relative_to(self._folder).as_posix()
            if name not in self._names and name != RECORD_NAME:
                self._names[name] = json.dumps(name, ensure_ascii=False)
                if not fnmatch(name, NUMBERED):
                    self.write()
                elif self._pace.due():
                    self.write()
                    self._pace.done()

    @property
    def names(self) -> list[str]:
        """Of all recorded files, relative to the folder."""
        return list(self._names)

    def missing(self) -> list[str]:
        """Names of recorded files that are not there, or empty."""
        return [name for name in self._names if not _has_content(self._folder / name)]

    def finish(self, **ending: Any) -> None:
        """Record the ending, and the hashes of all files: they show of which run a file without a run id is."""
        self._content |= {"ended": datetime.now(UTC).isoformat(timespec="seconds"), **ending}
        self.hash_so_far()
        self._hashes = {name: found for name, (_, found) in self._hashed.items()}
        self.write()

    def hash_so_far(self) -> None:
        """Hash the files that are there; those that stay as they are need not be hashed again at the end."""
        before, self._hashed = self._hashed, {}
        for name in self._names:
            with suppress(OSError):
                state, known = _state(self._folder / name), before.get(name)
                if known is None or known[0] != state:
                    known = state, file_hash(self._folder / name)
                self._hashed[name] = known


def hashed_fields(frame: Frame) -> list[str]:
    """Names of the fields in ``frame_hash``, since a later version may have more."""
    return sorted({name for sheet in frame.sheets for name in sheet.fields})


def frame_hash(frame: Frame, fields: Collection[str] | None = None) -> str:
    """SHA-256 of the state that a frame shows: time, tools, and every position, director and field, to the bit.

    Args:
        frame: the state.
        fields: names of those that count; None for all.
    """
    digest = hashlib.sha256()
    for part in (frame.time, frame.step_count, *np.asarray(frame.tool_displacement).tolist()):
        digest.update(repr(part).encode())
    digest.update(np.ascontiguousarray(frame.tool_pose).tobytes())  # nothing where no tool is carried
    for sheet in frame.sheets:
        digest.update(np.ascontiguousarray(sheet.position).tobytes())
        digest.update(np.ascontiguousarray(sheet.director).tobytes())
        for name in sorted(sheet.fields if fields is None else set(sheet.fields) & set(fields)):
            digest.update(name.encode() + np.ascontiguousarray(sheet.fields[name]).tobytes())
    return digest.hexdigest()


def _state(path: Path) -> tuple[int, ...]:
    """Of a file: another one after every writing. Files are replaced whole, by new ones."""
    about = path.stat()
    return about.st_ino, about.st_size, about.st_mtime_ns


def _has_content(path: Path) -> bool:
    try:
        return path.stat().st_size > 0
    except OSError:
        return False


def versions() -> dict[str, str]:
    """Versions of what may change a result."""
    found = {"weavesim": __version__, "python": platform.python_version()}
    for name in PACKAGES:
        with suppress(PackageNotFoundError):
            found[name] = version(name)
    return found


def _input_files(options: Mapping[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Path, size and hash of every file that an option names, or a list of an option."""
    for name, value in options.items():
        if name == "out":
            continue
        several = list(value) if isinstance(value, list | tuple) else [value]
        for k, item in enumerate(several, start=1):
            if not isinstance(item, str):
                continue
            path = Path(item)
            with suppress(OSError, ValueError):
                if path.is_file():
                    about = {"path": str(path.absolute()), "bytes": path.stat().st_size, "sha256": file_hash(path)}
                    yield (name if len(several) == 1 else f"{name} {k}"), about


def file_hash(path: Path) -> str:
    """SHA-256 of a file."""
    digest = hashlib.sha256()
    with open(path, "rb") as file:
        while chunk := file.read(_CHUNK):
            digest.update(chunk)
    return digest.hexdigest()
