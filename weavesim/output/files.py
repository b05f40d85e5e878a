"""Atomic writing: a file is complete or absent."""

from __future__ import annotations

import json
import math
import os
import re
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..run.frame import RunInfo, unique_names

_LONGEST_NAME = 150

# Is told every file before it is written; None outside the folder of a run.
_told: ContextVar[Callable[[Path], object] | None] = ContextVar("_told", default=None)


@contextmanager
def noting(tell: Callable[[Path], object]) -> Iterator[None]:
    """Inside this context ``tell`` receives the name of every file before it is written."""
    token = _told.set(tell)
    try:
        yield
    finally:
        _told.reset(token)


def note(path: Path) -> None:
    """Tell that a file is about to be written; ``replacing`` does it."""
    if (tell := _told.get()) is not None:
        tell(path)


def temporary_name(path: Path) -> Path:
    """Hidden name next to ``path`` with the same extension, from which writers choose their format."""
    return path.with_name(f".{path.stem}.partial{path.suffix}")


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Yield a temporary name to write to; it replaces ``path`` if nothing is raised, else it is removed."""
    note(path)
    temporary = temporary_name(path)
    try:
        yield temporary
        os.replace(temporary, path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def check_writable(folder: Path) -> None:
    """Create the folder if necessary, and check that it can be written to.

    Raises:
        InputError: it cannot be created, is a file or a link to nowhere, cannot be written to, or has a name that is
            no text.
    """
    shown = os.fsencode(folder).decode("utf-8", "backslashreplace")
    try:
        str(folder.absolute()).encode("utf-8")
        folder.mkdir(parents=True, exist_ok=True)
        # as long as the longest name of a result
        with tempfile.NamedTemporaryFile(dir=folder, prefix=".weavesim".ljust(_LONGEST_NAME, "_")):
            pass
    except UnicodeEncodeError:
        raise InputError(
            f"output folder {shown}: its name is not valid UTF-8, which films and tables need; rename it, or give "
            "another folder"
        ) from None
    except OSError as error:
        reason = error.strerror or str(error)
        if os.path.isfile(folder):
            reason = "it is a file"
        elif os.path.islink(folder) and not os.path.exists(folder):
            reason = f"it is a link to {os.readlink(folder)}, which does not exist"
        raise InputError(
            f"output folder {shown}: cannot be written to ({reason}); give a folder that you may write to"
        ) from None
    except ValueError as error:  # a null character
        raise InputError(f"output folder {shown!r}: {error}; give another name") from None


def file_endings(info: RunInfo) -> tuple[str, ...]:
    """Suffix of file names for each sheet: nothing for a single one, else its name."""
    if len(info.sheets) == 1:
        return ("",)
    return tuple(f"_{name}" for name in unique_names(in_file_name(sheet.name) for sheet in info.sheets))


def world_endings(info: RunInfo) -> tuple[str, ...]:
    """Suffix of file names for each world: nothing for a single one, else its name."""
    if len(info.worlds) == 1:
        return ("",)
    return tuple(f"_{name}" for name in unique_names(in_file_name(sheets[0].world) for sheets in info.worlds))


def in_file_name(name: str) -> str:
    """A name as a part of a file name."""
    return re.sub(r"[^\w.-]+", "_", name)


def write_text(path: Path, text: str) -> None:
    """Write UTF-8 text."""
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")


def plain(value: Any) -> Any:
    """Convert to built-in types for JSON; a number that is not finite becomes None."""
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(entry) for entry in value]
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if value is None or isinstance(value, str | bool | int):
        return value
    return str(value)


def summary_text(summary: Mapping[str, Any]) -> str:
    """``summary`` as JSON; numbers that are not finite become null."""
    return json.dumps(plain(summary), indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def write_summary(path: str | Path, summary: Mapping[str, Any]) -> None:
    """Write ``summary_text`` to a file."""
    write_text(Path(path), summary_text(summary))
