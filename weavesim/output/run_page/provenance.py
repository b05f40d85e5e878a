"""Where a page comes from: when, by what command, of which version and inputs, on which machine."""

from __future__ import annotations

import json
import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..claim.record import RECORD_NAME
from .values import Row


def record_of(folder: Path) -> dict[str, Any]:
    """``run.json`` of a folder; empty if it cannot be read."""
    try:
        return json.loads((folder / RECORD_NAME).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}


def provenance_rows(record: Mapping[str, Any], run_id: str) -> list[Row]:
    """What ``run.json`` says of the origin of a run."""
    versions = dict(record.get("versions") or {})
    rows = [Row("run", run_id or str(record.get("run_id") or "not known"))]
    if not record:
        return rows
    rows.append(Row("started", f"{_instant(record.get('started'))} on {record.get('host') or 'an unknown machine'}"))
    rows += [Row("resumed", str(part)) for part in record.get("resumed") or ()]
    rows.append(Row("command", shlex.join(map(str, record.get("command") or ())) or "not known"))
    rows.append(Row("in the folder", str(record.get("folder") or "not known")))
    rows.append(Row("version", f"weavesim {versions.pop('weavesim', 'not known')}"))
    rows.append(Row("commit", str(record.get("commit") or "not known: not run from a checkout")))
    rows.append(Row("other versions", ", ".join(f"{name} {text}" for name, text in versions.items())))
    rows.append(Row("set-up, SHA-256", str(record.get("setup_hash") or "not known")))
    files: Mapping[str, Any] = record.get("input_files") or {}
    for name, file in files.items():
        rows.append(Row(f"{str(name).replace('_', ' ')}", f"{file.get('path')}, {file.get('bytes')} bytes"))
        rows.append(Row("SHA-256", str(file.get("sha256")), 1))
    if not files:
        rows.append(Row("input files", "none: all input is in the command and in weavesim itself"))
    rows.append(Row("device", f"{record.get('device')}, {record.get('precision')}"))
    machine = ", ".join(str(record[key]) for key in ("processor", "system") if record.get(key))
    rows.append(Row("machine", machine or "not known"))
    return rows


def _instant(text: Any) -> str:
    return str(text).replace("T", " ").replace("+00:00", " UTC") if text else "at a time that is not known"
