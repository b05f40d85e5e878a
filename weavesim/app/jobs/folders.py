"""Read the folder of a run."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from ...errors import InputError
from ...input_files import MEBIBYTE, read_bounded, shown

LARGEST_RECORD = 64 * MEBIBYTE


def read_record(folder: Path) -> dict[str, Any]:
    """``run.json`` of a folder.

    Raises:
        InputError: it is no folder of a run.
    """
    from ...output.claim.record import RECORD_NAME

    if not (folder / RECORD_NAME).is_file():
        inner = sorted(path.parent for path in folder.glob(f"*/{RECORD_NAME}"))
        hint = f"; it has runs in {', '.join(shown(path) for path in inner[:5])}" if inner else ""
        raise InputError(f"folder {shown(folder)}: no run wrote its results there ({RECORD_NAME} is missing){hint}")
    return _read(folder / RECORD_NAME)


def read_summary(folder: Path) -> dict[str, Any]:
    """``summary.json`` of a folder; {} without one."""
    from ...output.claim.remains import SUMMARY_NAME

    return _read(folder / SUMMARY_NAME) if (folder / SUMMARY_NAME).is_file() else {}


def _read(path: Path) -> dict[str, Any]:
    try:
        content = json.loads(read_bounded(path, "record", LARGEST_RECORD))
    except (ValueError, RecursionError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"record {shown(path)}: damaged ({shown(error)})") from None
    if not isinstance(content, dict):
        raise InputError(f"record {shown(path)}: damaged (a table is needed)")
    return content
