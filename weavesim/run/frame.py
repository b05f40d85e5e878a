"""What the observers of a run receive: information about the run, its frames, and its outcome."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from datetime import UTC, datetime
from enum import Enum
from itertools import count
from typing import TYPE_CHECKING, Protocol, TypeVar
from uuid import uuid4

import numpy as np

from ..errors import InputError
from ..process.motions.paths import Place, Pose

if TYPE_CHECKING:
    from ..engine.setup import Setup
    from ..fabric.fabric import Fabric
    from ..process.grippers import Gripper
    from ..process.supports import Support
    from ..sheet.blank import Blank
    from ..sheet.symmetry import Symmetry
    from ..tools.tool import Tool
    from .estimate import Estimate


OfSheet = TypeVar("OfSheet")


@dataclass(frozen=True)
class SheetInfo:
    """One sheet of a run.

    Attributes:
        name: used in outputs, unique in the run.
        blank: the flat sheet.
        fabric: its laws.
        symmetry: planes at which it is cut.
        tools: indices of the tools of its world among those of the run.
        supports: indices of its supports among those of the run.
        world: name of its world: only sheets of the same one can meet.
        follows_thickness: whether it meets tools at its current thickness instead of its initial one.
    """

    name: str
    blank: Blank
    fabric: Fabric
    symmetry: Symmetry
    tools: tuple[int, ...] = ()
    supports: tuple[int, ...] = ()
    world: str = "world"
    follows_thickness: bool = False


@dataclass(frozen=True)
class RunInfo:
    """Information about a run for its observers, all known before the first frame.

    Attributes:
        name: used for the result files.
        sheets: in the order of all frames.
        tools: in the order of all frames.
        supports: in the order of all frames.
        duration: time at which the run ends [s].
        frame_count: frames after the first.
        device: "cpu", "cuda:0", ...
        precision: "float32" or "float64".
        thread_counts: CPU threads that may be used.
        internal_energies: names of the entries of the ledger whose sum is the internal energy.
        warnings: for the user; the run adds to this list until it ends.
        notes: findings about the input.
        setup: the input of the run.
        grippers: in the order of all frames.
        expected: what the run will take.
        run_id: unlike that of any other run; every result tells it.
        parts: where the run was resumed from a checkpoint, in words.
    """

    name: str
    sheets: tuple[SheetInfo, ...]
    tools: tuple[Tool, ...]
    supports: tuple[Support, ...]
    duration: float
    frame_count: int
    device: str = "cpu"
    precision: str = "float32"
    thread_counts: tuple[int, ...] = (1,)
    internal_energies: tuple[str, ...] = ()
    warnings: list[str] = field(default_factory=list)
    notes: tuple[str, ...] = ()
    setup: Setup | None = None
    grippers: tuple[Gripper, ...] = ()
    expected: Estimate | None = None
    run_id: str = field(default_factory=lambda: new_run_id())
    parts: tuple[str, ...] = ()

    @property
    def sheet(self) -> SheetInfo:
        """The only sheet of a run.

        Raises:
            InputError: the run has several.
        """
        return only_sheet(self.sheets)

    @property
    def worlds(self) -> tuple[tuple[SheetInfo, ...], ...]:
        """Sheets of every world, in order."""
        names = dict.fromkeys(sheet.world for sheet in self.sheets)
        return tuple(tuple(sheet for sheet in self.sheets if sheet.world == name) for name in names)

    @property
    def levels(self) -> tuple[int, ...]:
        """Place of every sheet from the bottom, by the mean height of its blank; of equals the first is lower."""
        heights = [float(sheet.blank.node_position[:, 2].mean()) for sheet in self.sheets]
        return tuple(np.argsort(np.argsort(heights, kind="stable")).tolist())

    @property
    def element_count(self) -> int:
        """Elements of all sheets."""
        return sum(sheet.blank.element_count for sheet in self.sheets)

    @property
    def node_count(self) -> int:
        """Nodes of all sheets."""
        return sum(sheet.blank.node_count for sheet in self.sheets)

    @property
    def tool_names(self) -> tuple[str, ...]:
        """Names of the tools in outputs: if tools of different worlds have the same name, the second is NAME_2."""
        return unique_names(tool.name for tool in self.tools)


@dataclass(frozen=True)
class SheetFrame:
    """State of one sheet at one instant. SI units; float64 copies on the host.

    Attributes:
        name: of the sheet.
        position: nodes, (node_count, 3) [m].
        director: unit directors, (node_count, 3).
        fields: one value per element, (element_count,), by name: those of ``weavesim.run.fields``, in SI units.
        energies: the entries of the ledger that belong to one sheet [J], by name.
        resultants: of each element, (element_count,), by the names of ``ResultantRow``; ``measures.stresses`` makes
            forces and stresses of them.
        kept: elements that are there, (element_count,) bool; empty if all are. Others are waste that a stage has cut
            away: their values are not numbers, and their nodes stand where they were (``run.staging.part``).
    """

    name: str
    position: np.ndarray
    director: np.ndarray
    fields: dict[str, np.ndarray]
    energies: dict[str, float]
    resultants: dict[str, np.ndarray] = field(default_factory=dict)
    kept: np.ndarray = field(default_factory=lambda: np.zeros(0, dtype=bool))


@dataclass(frozen=True)
class Frame:
    """State of a run at one instant. SI units; float64 copies on the host.

    Attributes:
        index: number of the frame, 0 for the undeformed state.
        step_count: time steps done.
        time: [s].
        stroke: displacement of the leading tool along its axis, or without tools that of the first drive [m].
        sheets: in the order of the set-up.
        tool_displacement: along each tool's axis, (tool_count,) [m].
        tool_reaction: force of the sheets on each tool, (tool_count, 3) [N].
        tool_pose: of each tool in a run in which one is carried, (tool_count, 12): rotation matrix, row by row, and
            shift [m]; else (0, 12).
        tool_moment: of the sheets on each tool of such a run, about its pivot, (tool_count, 3) [N m]; else (0, 3).
        tool_wanted: force that drives each tool along its axis, (tool_count,) [N]; not a number where a stroke does.
        energies: every entry of the ledger [J], by name, summed over the sheets.
        support_force: force of each support on its sheet, (support_count, 3) [N]: it balances all other forces on
            its nodes and accelerates their mass.
        gripper_force: of the springs of each gripper, (gripper_count,) [N].
        gripper_slip: of the sheet through each gripper, the mean over its springs, (gripper_count,) [m].
        drive_displacement: of every drive of every support, in order, (drive_count,) [m].
        drive_force: of the support on the sheet along each drive, (drive_count,) [N]: work per unit displacement of
            the drive.
        tool_acts: whether each tool acts in the stage, (tool_count,) bool.
        stage: name of the stage that it belongs to; empty in a run without stages.
    """

    index: int
    step_count: int
    time: float
    stroke: float
    sheets: tuple[SheetFrame, ...]
    tool_displacement: np.ndarray
    tool_reaction: np.ndarray
    energies: dict[str, float]
    support_force: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))
    drive_displacement: np.ndarray = field(default_factory=lambda: np.zeros(0))
    drive_force: np.ndarray = field(default_factory=lambda: np.zeros(0))
    tool_pose: np.ndarray = field(default_factory=lambda: np.zeros((0, 12)))
    tool_moment: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))
    tool_wanted: np.ndarray = field(default_factory=lambda: np.zeros(0))
    gripper_force: np.ndarray = field(default_factory=lambda: np.zeros(0))
    gripper_slip: np.ndarray = field(default_factory=lambda: np.zeros(0))
    tool_acts: np.ndarray = field(default_factory=lambda: np.zeros(0, dtype=bool))
    stage: str = ""

    def place(self, tool: int) -> Place:
        """Where a tool is, by its number: its displacement along its axis [m], or in a run with carried ones a pose."""
        if len(self.tool_pose):
            return Pose.from_numbers(self.tool_pose[tool])
        return float(self.tool_displacement[tool])

    def acts(self, tool: int) -> bool:
        """Whether a tool acts, by its place; all do in a frame that does not tell."""
        return not len(self.tool_acts) or bool(self.tool_acts[tool])

    @property
    def sheet(self) -> SheetFrame:
        """The sheet of a run that has one.

        Raises:
            InputError: the run has several.
        """
        return only_sheet(self.sheets)

    @property
    def position(self) -> np.ndarray:
        """``position`` of the only sheet."""
        return self.sheet.position

    @property
    def director(self) -> np.ndarray:
        """``director`` of the only sheet."""
        return self.sheet.director

    @property
    def fields(self) -> dict[str, np.ndarray]:
        """``fields`` of the only sheet."""
        return self.sheet.fields


def new_run_id() -> str:
    """Start in UTC, and 32 random bits: "20260704T120000Z-1f3a9c2e". Later runs sort after earlier ones."""
    return f"{datetime.now(UTC):%Y%m%dT%H%M%SZ}-{uuid4().hex[:8]}"


def unique_names(names: Iterable[str]) -> tuple[str, ...]:
    """``names`` in order, with repeated ones numbered NAME_2, NAME_3, ..."""
    taken: list[str] = []
    for name in names:
        candidates = (name if k == 1 else f"{name}_{k}" for k in count(1))
        taken.append(next(candidate for candidate in candidates if candidate not in taken))
    return tuple(taken)


def only_sheet(sheets: tuple[OfSheet, ...]) -> OfSheet:
    """The entry of the only sheet of a run.

    Raises:
        InputError: the run has several.
    """
    if len(sheets) != 1:
        raise InputError(f"this run has {len(sheets)} sheets: use one of the tuple ``sheets``")
    return sheets[0]


class Outcome(Enum):
    """How a run ended."""

    FINISHED = "finished"
    INTERRUPTED = "interrupted"
    STOPPED = "stopped"
    NOT_FINITE = "not finite"


class Observer(Protocol):
    """Receives the frames of a run; a file-writing observer leaves a readable file at every ``finish``."""

    def start(self, info: RunInfo) -> None:
        """Called once, before the first frame."""

    def frame(self, frame: Frame) -> None:
        """Called for every frame, in their order."""

    def finish(self, outcome: Outcome) -> None:
        """Called once the run has ended, however it has."""
