"""Atomic writing: a file is complete or absent."""

from __future__ import annotations

import json
import math
import os
import re
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..run.frame import RunInfo, unique_names


def temporary_name(path: Path) -> Path:
    """Hidden name next to ``path`` with the same extension, from which writers choose their format."""
    return path.with_name(f".{path.stem}.partial{path.suffix}")


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Yield a temporary name to write to; it replaces ``path`` if nothing is raised, else it is removed."""
    temporary = temporary_name(path)
    try:
        yield temporary
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


def check_writable(folder: Path) -> None:
    """Create the folder if necessary, and check that it can be written to.

    Raises:
        InputError: it cannot be created, is a file, or cannot be written to.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=folder, prefix=".weavesim"):
            pass
    except OSError as error:
        raise InputError(
            f"output folder {folder}: cannot be written to ({error.strerror or error}); "
            "give a folder that you may write to"
        ) from None


def file_endings(info: RunInfo) -> tuple[str, ...]:
    """Suffix of file names for each sheet: nothing for a single one, else its name."""
    if len(info.sheets) == 1:
        return ("",)
    return tuple(f"_{name}" for name in unique_names(re.sub(r"[^\w.-]+", "_", sheet.name) for sheet in info.sheets))


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


def write_summary(path: str | Path, summary: Mapping[str, Any]) -> None:
    """Write ``summary`` as JSON; numbers that are not finite become null."""
    write_text(Path(path), json.dumps(plain(summary), indent=2, ensure_ascii=False, allow_nan=False) + "\n")
