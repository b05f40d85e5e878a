"""Every entry of a run's results by name."""

from __future__ import annotations

import csv
import hashlib
import json
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

# Names of entries that were changed deliberately, old to new.
RENAMED: dict[str, str] = {}


# Summary entries that differ from run to run.
OF_THE_CLOCK = {
    "wall_time_s", "stepping_time_s", "output_time_s", "element_steps_per_second", "threads", "weavesim_version",
    "run_id",
}  # fmt: skip

# Files that are compared byte by byte, and only reported.
BYTES_ONLY = (".usdc", ".png", ".vtu", ".pvd")


def read_results(folder: Path) -> dict[str, np.ndarray]:
    """Every entry of a run by name, numbers with all bits and tables as text."""
    entries: dict[str, np.ndarray] = {}
    with np.load(folder / "frames.npz") as record:
        entries |= {name: record[name] for name in record.files}
    out = folder / "out"
    for path in sorted(out.rglob("*.csv")):
        entries |= {f"{path.name}/{name}": column for name, column in read_table(path).items()}
    for path in sorted(out.rglob("final_state.vtu")):
        entries |= {f"{path.name}/{name}": values for name, values in read_final_state(path)}
    for path in sorted(out.rglob("summary.json")):
        # notes contain the paths of the tool meshes
        summary = json.loads(re.sub(r"[^\s\"]*/inputs/", "inputs/", path.read_text(encoding="utf-8")))
        entries |= {f"{path.name}/{name}": values for name, values in leaves(summary) if name not in OF_THE_CLOCK}
    return {RENAMED.get(name, name): values for name, values in entries.items()}


def read_table(path: Path) -> dict[str, np.ndarray]:
    """Columns of a CSV as text, by header."""
    with path.open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    return {name: np.array([row[k] for row in rows], dtype=str) for k, name in enumerate(header)}


def read_final_state(path: Path) -> Iterator[tuple[str, np.ndarray]]:
    import meshio

    mesh = meshio.read(path)
    yield "points", mesh.points
    yield "quads", mesh.cells[0].data
    for name, values in mesh.point_data.items():
        yield without_unit(name), values
    for name, blocks in mesh.cell_data.items():
        yield without_unit(name), blocks[0]


def without_unit(name: str) -> str:
    """The name that older versions gave a field, whose names had no units but degrees."""
    return re.sub(r"_(?:n_per_m|pa|n|m)$", "", name)


def leaves(value: Any, name: str = "") -> Iterator[tuple[str, np.ndarray]]:
    """Entries of nested JSON; a list of numbers or of texts is one entry."""
    if isinstance(value, Mapping):
        for key, item in value.items():
            yield from leaves(item, f"{name}.{key}" if name else key)
    elif isinstance(value, list) and any(isinstance(item, Mapping | list) for item in value):
        for index, item in enumerate(value):
            yield from leaves(item, f"{name}.{index}")
    else:
        yield name, np.asarray("null" if value is None else value)


def other_files(folder: Path) -> dict[str, str]:
    """SHA-256 of the files that are compared as bytes, by path."""
    out = folder / "out"
    return {
        str(path.relative_to(out)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(out.rglob("*"))
        if path.suffix in BYTES_ONLY and path.name != "final_state.vtu"
    }


def sha256(values: np.ndarray) -> str:
    """SHA-256 of type, shape and bits."""
    head = f"{values.dtype.str} {values.shape} ".encode()
    return hashlib.sha256(head + np.ascontiguousarray(values).tobytes()).hexdigest()
