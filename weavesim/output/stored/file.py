"""``results.h5``: written from the last frame of a run, and read back (docs/outputs.md).

Groups ``sheets/0``, ``sheets/1``, ... in the order of the set-up, and ``tools/0``, ...: names may have any characters.
The file begins with the SHA-256 of the rest, in the block that HDF5 leaves to its users (``sealed.py``).
"""

from __future__ import annotations

import json
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...errors import InputError
from ...input_files import check_bounded, read_bounded, shown
from ...measures.findings import FormedSheet
from ...measures.stresses import STRESS_FIELDS
from ...process.motions.paths import Place, Pose
from ...run.fields import FIELDS
from ...run.frame import Frame, RunInfo
from ...run.staging.part import part_of
from ...sheet.blank import Blank
from ...sheet.symmetry import Symmetry
from ...tools.tool import Tool
from ...version import __version__
from ..claim.record import RECORD_NAME, SETUP_NAME
from ..files import replacing
from .sealed import AGAIN, USER_BLOCK, check_seal, seal
from .values import DIRECTIONS, ElementValue, element_values

if TYPE_CHECKING:
    from ...engine.setup import Setup
    from ...fabric.fabric import Fabric

FILE_NAME = "results.h5"
FORMAT, FORMAT_VERSION = "weavesim results", 2
# Those of version 1 have no checksum of their own.
READ_VERSIONS = (1, 2)
LARGEST_FILE = 4 * 2**30
LARGEST_SETUP = 2**30
# Fields that are not a number where they have no meaning; nothing is infinite.
_MAY_BE_MISSING = {"tool_gap"}
# What a damaged file makes of HDF5 and of the values in it.
_DAMAGE = (
    OSError, KeyError, ValueError, TypeError, AttributeError, RuntimeError, IndexError, OverflowError, MemoryError,
)  # fmt: skip
_REFERENCE = ("node_position", "material_coordinates", "initial_director", "quads", "warp_direction", "weft_direction")
# Of the mesh of a user, where it has some.
_NUMBERS = ("node_number", "element_number")


@dataclass(frozen=True, eq=False)
class StoredSheet:
    """A sheet at the end of a run, as its file has it.

    Attributes:
        name: unique in the run.
        blank: the flat sheet.
        position: formed nodes, (node_count, 3) [m].
        director: their unit directors, (node_count, 3).
        values: of the elements by name, in the units of files.
        thickness: of the undeformed fabric [m].
        symmetry: planes at which it is cut.
        tools: places, among those of the result, of the tools that it may touch.
        fabric: name of its fabric.
    """

    name: str
    blank: Blank
    position: np.ndarray
    director: np.ndarray
    values: dict[str, ElementValue]
    thickness: float
    symmetry: Symmetry
    tools: tuple[int, ...]
    fabric: str

    @cached_property
    def fields(self) -> dict[str, np.ndarray]:
        """The fields of the run by name, in SI units, (element_count,) each."""
        out = {}
        for each in FIELDS:
            if value := self.values.get(each.file_name):
                out[each.name] = np.deg2rad(value.values) if each.unit == "rad" else value.values
        return out

    @cached_property
    def formed(self) -> FormedSheet:
        """The sheet with its measures."""
        return FormedSheet(self.blank, self.position, self.fields, self.thickness, self.symmetry)


@dataclass(frozen=True, eq=False)
class StoredRun:
    """The end of a run, as its folder has it.

    Attributes:
        folder: of the run.
        run_id, name: of the run.
        time: reached [s].
        outcome: how the run ended, or "running".
        sheets: in the order of the set-up.
        tool_displacement: along each tool's axis, (tool_count,) [m].
        tool_acts: whether each tool acts at the end, (tool_count,) bool; empty if all do.
        tool_pose: rotation matrix, row by row, and shift [m] of each tool of a run in which one is carried,
            (tool_count, 12); else (0, 12).
    """

    folder: Path
    run_id: str
    name: str
    time: float
    outcome: str
    sheets: tuple[StoredSheet, ...]
    tool_displacement: np.ndarray
    tool_acts: np.ndarray = field(default_factory=lambda: np.zeros(0, dtype=bool))
    tool_pose: np.ndarray = field(default_factory=lambda: np.zeros((0, 12)))

    @cached_property
    def setup(self) -> Setup:
        """The set-up of the run.

        Raises:
            InputError: its file is missing or damaged.
        """
        from ...engine.setup import Setup

        text = read_bounded(self.folder / SETUP_NAME, "set-up of the run", LARGEST_SETUP)
        return Setup.from_json(text.decode("utf-8"))

    @property
    def tools(self) -> tuple[Tool, ...]:
        """In the order of ``tool_displacement``."""
        return self.setup.tools

    def place(self, tool: int) -> Place:
        """Where a tool is at the end, by its number: its displacement along its axis [m], or its pose."""
        return Pose.from_numbers(self.tool_pose[tool]) if len(self.tool_pose) else float(self.tool_displacement[tool])

    def acting_tools(self, sheet: StoredSheet) -> tuple[int, ...]:
        """Places of the tools that a sheet may touch and that act at the end."""
        return tuple(place for place in sheet.tools if not len(self.tool_acts) or self.tool_acts[place])

    def fabric(self, sheet: StoredSheet) -> Fabric:
        """The fabric of one of its sheets."""
        return self.setup.sheets[self.sheets.index(sheet)].fabric

    def formed(self, sheet: StoredSheet) -> FormedSheet:
        """One of its sheets with its measures, and the thickness at which it meets tools, which the set-up tells."""
        dynamics = [world.dynamics for world in self.setup.worlds for _ in world.sheets][self.sheets.index(sheet)]
        return replace(sheet.formed, follows_thickness=dynamics.contact_thickness == "current")


def write_results(path: Path, info: RunInfo, frame: Frame, outcome: str) -> None:
    """Write the last frame of a run."""
    import h5py

    with replacing(path) as temporary:
        with h5py.File(temporary, "w", userblock_size=USER_BLOCK) as file:
            _write(file, info, frame, outcome)
        seal(temporary)


def _write(file: Any, info: RunInfo, frame: Frame, outcome: str) -> None:
    file.attrs.update(
        {"format": FORMAT, "format_version": FORMAT_VERSION, "weavesim_version": __version__,
         "run_id": info.run_id, "name": info.name, "time": frame.time, "outcome": outcome}
    )  # fmt: skip
    for index, each in enumerate(zip(info.sheets, frame.sheets, strict=True)):
        sheet, state = part_of(*each)
        group = file.create_group(f"sheets/{index}")
        group.attrs.update(
            {"name": sheet.name, "fabric": sheet.fabric.name, "thickness": sheet.fabric.thickness,
             "symmetry": "".join(sheet.symmetry.planes), "tools": np.array(sheet.tools, dtype=np.int64)}
        )  # fmt: skip
        for name in _REFERENCE:
            group[f"reference/{name}"] = getattr(sheet.blank, name)
        for name in _NUMBERS:
            if (numbers := getattr(sheet.blank, name)) is not None:
                group[f"reference/{name}"] = numbers
        group["nodes/position"], group["nodes/director"] = state.position, state.director
        write_values(group.create_group("elements"), element_values(sheet, state))
    for index, (name, tool) in enumerate(zip(info.tool_names, info.tools, strict=True)):
        group = file.create_group(f"tools/{index}")
        group.attrs.update({"name": name, "axis": tool.axis, "displacement": frame.tool_displacement[index],
                            "reaction": frame.tool_reaction[index], "acts": frame.acts(index)})  # fmt: skip
        if len(frame.tool_pose):
            group.attrs.update({"pose": frame.tool_pose[index], "moment": frame.tool_moment[index]})


def write_values(group: Any, values: dict[str, ElementValue]) -> None:
    """Write values as datasets of an HDF5 group, with their unit and meaning as attributes."""
    for name, value in values.items():
        dataset = group.create_dataset(name, data=value.values)
        dataset.attrs.update({"unit": value.unit, "description": value.description})


def read_results(folder: str | Path) -> StoredRun:
    """The end of a run, from its folder.

    Raises:
        InputError: there is no such file, or it is damaged or of another version.
    """
    folder = Path(folder)
    path = folder / FILE_NAME
    if not folder.is_dir():
        raise InputError(f"run {shown(folder)}: it is no folder; give the folder of a run, its --out")
    if not path.exists():
        raise InputError(
            f"run {shown(folder)}: it has no {FILE_NAME}, which every run leaves unless it is left out (--without "
            "results, --write without it) or is older than this file; run it again"
        )
    check_bounded(path, "results", LARGEST_FILE)
    check_seal(path, _recorded_hash(folder))
    import h5py

    try:
        with h5py.File(path, "r") as file:
            if file.attrs.get("format") != FORMAT or file.attrs.get("format_version") not in READ_VERSIONS:
                raise InputError(
                    f"results {shown(path)}: it is no file of this format, or of another version than "
                    f"{FORMAT_VERSION}; run it again with this version of weavesim"
                )
            sheets = tuple(_read_sheet(file[f"sheets/{k}"]) for k in range(len(file["sheets"])))
            tools = file.get("tools", {})
            displacement = np.array([tools[str(k)].attrs["displacement"] for k in range(len(tools))], dtype=float)
            # a file of a version before it has none, and all tools acted
            acts = np.array([tools[str(k)].attrs.get("acts", True) for k in range(len(tools))], dtype=bool)
            poses = [tools[str(k)].attrs["pose"] for k in range(len(tools)) if "pose" in tools[str(k)].attrs]
            pose = np.array(poses, dtype=float).reshape(-1, 12)
            text = {name: str(file.attrs[name]) for name in ("run_id", "name", "outcome")}
            time = float(file.attrs["time"])
            if not (np.isfinite(time) and np.isfinite(displacement).all() and np.isfinite(pose).all()):
                raise ValueError("the time, or the place of a tool, is not finite")
            return StoredRun(folder, text["run_id"], text["name"], time, text["outcome"],
                             sheets, displacement, acts, pose)  # fmt: skip
    except InputError:
        raise
    except _DAMAGE as error:
        raise InputError(f"results {shown(path)}: damaged ({shown(error)}); {AGAIN}") from None


def _recorded_hash(folder: Path) -> str | None:
    """The SHA-256 of the results in the record of the run, if it has one that can be read."""
    try:
        record = json.loads(read_bounded(folder / RECORD_NAME, "record of the run", LARGEST_SETUP))
        found = record["files"][FILE_NAME]
    except (InputError, ValueError, KeyError, TypeError):
        return None
    return found if isinstance(found, str) else None


def _content(item: Any) -> np.ndarray:
    """A dataset; one that promises more than a file has is damaged."""
    if item.nbytes > LARGEST_FILE or (item.size and item.id.get_storage_size() < item.nbytes):
        raise ValueError("it promises more values than it has")
    return item[()]


def _read_sheet(group: Any) -> StoredSheet:
    values = {
        name: ElementValue(str(item.attrs["unit"]), str(item.attrs["description"]), _content(item))
        for name, item in group["elements"].items()
    }
    numbers = [name for name in _NUMBERS if name in group["reference"]]
    blank = Blank(**{name: _content(group[f"reference/{name}"]) for name in (*_REFERENCE, *numbers)})
    if any(len(value.values) != blank.element_count for value in values.values()):
        raise ValueError("the values of its elements are not as many as its elements")
    position, director = _content(group["nodes/position"]), _content(group["nodes/director"])
    if position.shape != (blank.node_count, 3) or not np.isfinite(position).all():
        raise ValueError("the positions of its nodes are not as many as its nodes, or not finite")
    if director.shape != position.shape or not np.isfinite(director).all():
        raise ValueError("the directors of its nodes are not as many as its nodes, or not finite")
    for name, value in values.items():
        _check_finite(name, value.values)
    thickness = float(group.attrs["thickness"])
    if not 0.0 < thickness < np.inf:
        raise ValueError("its thickness is not a positive length")
    return StoredSheet(
        name=str(group.attrs["name"]),
        blank=blank,
        position=position,
        director=director,
        values=values,
        thickness=thickness,
        symmetry=Symmetry(tuple(str(group.attrs["symmetry"]))),
        tools=tuple(int(k) for k in group.attrs["tools"]),
        fabric=str(group.attrs["fabric"]),
    )


def _check_finite(name: str, values: np.ndarray) -> None:
    """Check that a field is finite; the own ones of a user, and some of ours, are not a number where they do not apply.

    Raises:
        ValueError: it is not.
    """
    own = {field.file_name for field in FIELDS} | set(DIRECTIONS) | set(STRESS_FIELDS)
    wrong = np.isinf(values) if name in _MAY_BE_MISSING or name not in own else ~np.isfinite(values)
    if wrong.any():
        raise ValueError(f"{name} has values that are not finite")


def recorded_summary(folder: Path) -> dict[str, Any]:
    """``summary.json`` of a run; empty if there is none."""
    path = folder / "summary.json"
    if not path.exists():
        return {}
    try:
        return json.loads(read_bounded(path, "summary", LARGEST_SETUP))
    except ValueError:
        raise InputError(f"summary {shown(path)}: damaged; run it again") from None
