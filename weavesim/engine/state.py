"""Everything that a step writes."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np
import warp as wp

from ..errors import InputError
from ..kernels.rows import (
    CORNER_ROW_COUNT,
    CellReportRow,
    ClockEntry,
    ExtremeRow,
    GripRow,
    MotionRow,
    MovedRow,
    NodeWorkRow,
    SampleRow,
    SlipRow,
    ThicknessRow,
    ToolDriveRow,
    ToolWatchRow,
    ToolWorkRow,
)
from .creases.crease_state import CreaseState
from .layout import BLOCK
from .plies.pass_state import PassState
from .surface.friction import argument_rows

if TYPE_CHECKING:
    from .model import Model
from .sheet_model import SheetModel

# Of the files that ``State.save`` writes; one is read by the same version only.
FILE_VERSION = 11


@dataclass(frozen=True)
class SheetState:
    """What the kernels write of one sheet. Scalars are [row, element or node], padded; see ``kernels/rows.py``."""

    motion: wp.array  # flat, ``SheetModel.motion_layout``: rows MotionRow
    cell_unknowns: wp.array  # (unknowns of the unit cell, at least one, then its slopes; elements)
    cell_report: wp.array  # (rows, elements), CellReportRow
    slip: wp.array  # (rows, elements), SlipRow; (rows, BLOCK) for a fabric without friction inside
    corner_force: wp.array  # flat, ``SheetModel.corners``, rows CornerRow
    node_work: wp.array  # (rows, nodes), ``SheetModel.node_work_rows``, of the last steps [J]
    node_work_sum: wp.array  # (rows, node blocks) float64, of all steps before [J]
    thickness: wp.array  # (rows, nodes), ThicknessRow; (rows, 0) for contact with the initial thickness [m]
    friction: wp.array  # flat, ``SheetModel.friction_layout`` [m]
    depth: wp.array  # (tools, nodes), deepest that each has been in a tool [m]
    # (2 tools, nodes): smallest and largest argument of each tool's friction law; (2, BLOCK) without such laws
    friction_argument: wp.array
    extremes: wp.array  # (rows, elements), ExtremeRow
    gap: wp.array  # (tools, node blocks), how far each may move before a contact is possible [m]
    holding: wp.array  # force of a support on its node, (nodes,) vec3 [N]; empty without supports
    # of contact between nodes, else without columns; samples: those of all elements, one after the other
    moved: wp.array  # (rows, node blocks), MovedRow
    sample_memory: wp.array  # (rows, samples), SampleRow
    sample_work: wp.array  # (rows, samples), NodeWorkRow, of the last steps [J]
    sample_work_sum: wp.array  # (rows, sample blocks) float64, of all steps before [J]
    sample_thickness: wp.array  # (rows, elements), ThicknessRow; (rows, 0) for contact with the initial thickness [m]
    sample_friction: wp.array  # flat, ``Samples.layout`` [m]
    sample_depth: wp.array  # (tools, samples), as depth
    sample_friction_argument: wp.array  # (2 tools, samples), as friction_argument
    sample_gap: wp.array  # (tools, sample blocks, then blocks of elements), as gap, and the smallest of each block
    # (tools, sample blocks) vec3, force of each block of samples on each tool [N]; where tools are carried, as many
    # rows of moments below [N m]
    sample_reaction: wp.array
    contact_force: wp.array  # (3, nodes), of other plies on the nodes [N]; (3, BLOCK) without interfaces
    awake: wp.array  # (1,) int32: 0 while nothing is near enough to touch, so that normals are not needed
    grip: wp.array  # (rows, gripped nodes) float64, GripRow
    pressure_work: wp.array  # (element blocks,) float64, of the pressures so far [J]; empty without any

    def works(self) -> np.ndarray:
        """Works at the nodes of all steps, of ``SheetModel.node_work_rows``, (rows,) [J]; waits for the device."""
        return self.node_work_sum.numpy().sum(axis=1) + self.node_work.numpy().sum(axis=1, dtype=np.float64)

    def sample_works(self) -> np.ndarray:
        """Works at the samples, of NodeWorkRow, up to the positions that the last step started from, (rows,) [J]."""
        return self.sample_work_sum.numpy().sum(axis=1) + self.sample_work.numpy().sum(axis=1, dtype=np.float64)

    def set_works(self, works: np.ndarray) -> None:
        """Set what ``works`` returns; only the sum over the nodes counts."""
        sums = np.zeros(self.node_work_sum.shape)
        sums[:, 0] = works
        self.node_work_sum.assign(sums)
        self.node_work.zero_()

    @classmethod
    def initial(cls, model: SheetModel, touched: bool = False) -> Self:
        """The sheet at time zero; ``touched`` if it has interfaces with others."""
        real, device, tool_rows = model.real, model.device, max(model.tool_count, 1)
        slip_count = model.element_count if model.fabric.has_inner_friction else BLOCK
        thickness = np.zeros((ThicknessRow.row_count(), model.node_count if model.follows_thickness else 0))
        thickness[ThicknessRow.half] = 0.5 * model.fabric.thickness
        samples, sample_blocks = model.samples.count, model.samples.count // model.lane_count
        followed = model.element_count if samples and model.follows_thickness else 0
        sample_thickness = np.zeros((ThicknessRow.row_count(), followed))
        sample_thickness[ThicknessRow.half] = 0.5 * model.fabric.thickness
        motion = wp.zeros(MotionRow.row_count() * model.node_count, dtype=real, device=device)
        model.write_motion(motion, model.initial_motion())

        def zeros(*shape: int, dtype: type = real) -> wp.array:
            return wp.zeros(shape if len(shape) > 1 else shape[0], dtype=dtype, device=device)

        return cls(
            motion=motion,
            cell_unknowns=wp.array(model.initial_unknowns(), dtype=real, device=device),
            cell_report=zeros(CellReportRow.row_count(), model.element_count),
            slip=zeros(SlipRow.row_count(), slip_count),
            corner_force=zeros(CORNER_ROW_COUNT * model.element_count),
            node_work=zeros(len(model.node_work_rows), model.node_count),
            node_work_sum=zeros(len(model.node_work_rows), model.block_count, dtype=wp.float64),
            thickness=wp.array(thickness, dtype=real, device=device),
            friction=zeros(3 * tool_rows * model.node_count),
            depth=zeros(tool_rows, model.node_count),
            friction_argument=wp.array(argument_rows(model, model.node_count), dtype=real, device=device),
            extremes=zeros(ExtremeRow.row_count(), model.element_count),
            gap=zeros(tool_rows, model.block_count),
            holding=zeros(model.node_count if model.supports else 0, dtype=model.types.vec3),
            moved=zeros(MovedRow.row_count(), model.block_count if samples else 0),
            sample_memory=zeros(SampleRow.row_count(), samples),
            sample_work=zeros(NodeWorkRow.row_count(), samples),
            sample_work_sum=zeros(NodeWorkRow.row_count(), sample_blocks, dtype=wp.float64),
            sample_thickness=wp.array(sample_thickness, dtype=real, device=device),
            sample_friction=zeros(3 * tool_rows * samples),
            sample_depth=zeros(tool_rows, samples),
            sample_friction_argument=wp.array(argument_rows(model, samples), dtype=real, device=device),
            sample_gap=zeros(tool_rows, sample_blocks + sample_blocks // max(len(model.samples.places), 1)),
            sample_reaction=zeros(
                (2 if model.node_traits.carried else 1) * tool_rows, sample_blocks, dtype=model.types.vec3
            ),
            contact_force=zeros(3, model.node_count if touched else BLOCK),
            awake=wp.ones(1, dtype=wp.int32, device=device),
            grip=zeros(GripRow.row_count(), sum(len(each.nodes) for each in model.grippers), dtype=wp.float64),
            pressure_work=zeros(model.element_count // model.lane_count if model.pressures else 0, dtype=wp.float64),
        )


@dataclass
class State:
    """All that changes in a run: a run that goes on from it gets the bits of one that never stopped.

    Attributes:
        sheets: in the order of ``Setup.sheets``.
        tool_displacement, tool_velocity: along each tool's axis, (tool_count,) float64 [m], [m/s].
        tool_force: of the sheets on each tool, (tool_count,) vec3d [N].
        tool_pose: entries ToolPoseRow, (tool_count, entries) float64; (0, entries) where no tool is carried.
        tool_moment: of the sheets on each tool about its pivot, (tool_count,) vec3d [N m]; empty likewise.
        tool_work: rows ToolWorkRow, (rows, tool_count) float64 [J].
        tool_watch: rows ToolWatchRow, (rows, tool_count) float64.
        tool_drive: rows ToolDriveRow, (rows, tool_count) float64.
        reaction: parts of ``tool_force``, (tool_count, node blocks of the largest world) vec3 [N]; where tools are
            carried, as many rows of parts of ``tool_moment`` below [N m].
        drive_displacement, drive_increment: of every drive of every support, at the end of the last step and within it,
            (drive_count,) [m].
        clock: rows ClockEntry, float64 [s].
        passes: of the contact between plies, in the order of ``Model.passes``.
        creases: of the sheets that touch themselves, in the order of ``Model.creases``.
        step_count: steps done.
    """

    sheets: tuple[SheetState, ...]
    tool_displacement: wp.array
    tool_velocity: wp.array
    tool_force: wp.array
    tool_pose: wp.array
    tool_moment: wp.array
    tool_work: wp.array
    tool_watch: wp.array
    tool_drive: wp.array
    reaction: wp.array
    drive_displacement: wp.array
    drive_increment: wp.array
    clock: wp.array
    passes: tuple[PassState, ...] = ()
    creases: tuple[CreaseState, ...] = ()
    step_count: int = 0

    @classmethod
    def initial(cls, model: Model) -> Self:
        """The state at time zero, before ``Stepper.start``."""
        device, tool_count, drive_count = model.device, model.tools.count, model.drives.count
        carried = model.tools.carriers is not None
        reaction_rows = 2 * tool_count if carried else tool_count
        clock = np.zeros(ClockEntry.row_count())
        clock[[ClockEntry.step, ClockEntry.mean_step]] = model.reference_step

        def doubles(values: np.ndarray) -> wp.array:
            return wp.array(np.asarray(values, dtype=np.float64), dtype=wp.float64, device=device)

        return cls(
            sheets=tuple(SheetState.initial(sheet, sheet.node_traits.touched) for sheet in model.sheets),
            passes=tuple(PassState.initial(each) for each in model.passes),
            creases=tuple(CreaseState.initial(each) for each in model.creases),
            tool_displacement=doubles(model.tools.initial_displacement),
            tool_velocity=doubles(model.tools.initial_velocity),
            tool_force=wp.zeros(tool_count, dtype=wp.vec3d, device=device),
            tool_pose=doubles(model.tools.initial_pose),
            tool_moment=wp.zeros(tool_count if carried else 0, dtype=wp.vec3d, device=device),
            tool_work=wp.zeros((ToolWorkRow.row_count(), tool_count), dtype=wp.float64, device=device),
            tool_watch=wp.zeros((ToolWatchRow.row_count(), tool_count), dtype=wp.float64, device=device),
            tool_drive=wp.zeros((ToolDriveRow.row_count(), tool_count), dtype=wp.float64, device=device),
            reaction=wp.zeros((max(reaction_rows, 1), model.reaction_count), dtype=model.types.vec3, device=device),
            drive_displacement=wp.zeros(drive_count, dtype=wp.float64, device=device),
            drive_increment=wp.zeros(drive_count, dtype=model.real, device=device),
            clock=doubles(clock),
        )

    @property
    def sheet(self) -> SheetState:
        """The sheet of a run that has one.

        Raises:
            InputError: the run has several.
        """
        if len(self.sheets) != 1:
            raise InputError(f"this run has {len(self.sheets)} sheets: take one of state.sheets")
        return self.sheets[0]

    @property
    def time(self) -> float:
        """[s]; waits for the device."""
        return float(self.clock.numpy()[ClockEntry.time])

    @property
    def step(self) -> float:
        """Current time step [s]; waits for the device."""
        return float(self.clock.numpy()[ClockEntry.step])

    def arrays(self) -> Iterator[tuple[str, wp.array]]:
        """Every array with a name, such as ``clock`` and ``sheets/0/motion``."""
        for field in fields(self):
            value = getattr(self, field.name)
            if isinstance(value, wp.array):
                yield field.name, value
        for index, sheet in enumerate(self.sheets):
            for field in fields(sheet):
                yield f"sheets/{index}/{field.name}", getattr(sheet, field.name)
        for index, each in enumerate(self.passes):
            for field in fields(each):
                yield f"passes/{index}/{field.name}", getattr(each, field.name)
        for index, own in enumerate(self.creases):
            for field in fields(own):
                yield f"creases/{index}/{field.name}", getattr(own, field.name)

    def clone(self) -> State:
        """A copy with arrays of its own."""
        sheets = tuple(SheetState(**_copies(sheet)) for sheet in self.sheets)
        passes = tuple(PassState(**_copies(each)) for each in self.passes)
        creases = tuple(CreaseState(**_copies(each)) for each in self.creases)
        return State(**(_copies(self) | {"sheets": sheets, "passes": passes, "creases": creases}))

    def copy_from(self, other: State) -> None:
        """Take what the next step reads of a state of the same run; may be recorded."""
        self.step_count = other.step_count
        for (name, target), (_, source) in zip(self.arrays(), other.arrays(), strict=True):
            # every step writes all corner forces before it reads any
            if target.size and not name.endswith("corner_force"):
                wp.copy(target, source)

    def save(self, path: str | Path, model: Model) -> None:
        """Write everything to one file, which ``load`` reads; the file appears whole or not at all.

        Raises:
            OSError: it cannot be written.
        """
        path = Path(path)
        about = {"version": FILE_VERSION, "step_count": self.step_count, **model.identity}
        content: dict[str, Any] = self.content()
        temporary = path.with_name(f".{path.name}.partial")
        try:
            with temporary.open("wb") as file:
                np.savez(file, about=np.array(json.dumps(about, sort_keys=True)), **content)
            os.replace(temporary, path)
        finally:
            temporary.unlink(missing_ok=True)

    @classmethod
    def load(cls, path: str | Path, model: Model) -> Self:
        """The state that ``save`` wrote of a run of the same set-up, precision and lane count.

        Raises:
            InputError: a file that is missing, damaged, of another version or of another run.
        """
        try:
            with np.load(path, allow_pickle=False) as file:
                content = {name: file[name] for name in file.files}
            about = dict(json.loads(str(content.pop("about"))))
            step_count = int(about["step_count"])
        except Exception as error:  # a damaged file may fail anywhere in zipfile, NumPy or JSON
            raise InputError(f"state {path}: cannot be read ({error}); the file is missing or damaged") from None
        for name, wanted in {"version": FILE_VERSION, **model.identity}.items():
            if about.get(name) != wanted:
                found = "another one" if name == "setup" else f"{about.get(name)}, but this run has {wanted}"
                raise InputError(
                    f"state {path}: its {name.replace('_', ' ')} is {found}; a state continues the run that wrote it: "
                    "take the set-up and the solver settings of that run"
                )
        state = cls.initial(model)
        try:
            state.take(content, step_count)
        except ValueError as error:
            raise InputError(f"state {path}: {error}; the file is damaged") from None
        return state

    def content(self) -> dict[str, np.ndarray]:
        """Every array by name as it is on the device, padding included, on the host; waits for the device."""
        return {name: array.numpy() for name, array in self.arrays()}

    def take(self, content: Mapping[str, np.ndarray], step_count: int) -> None:
        """Become what ``content`` returned of a state of the same run.

        Raises:
            ValueError: an array that is missing, or of another shape or type; nothing is changed.
        """
        for name, array in self.arrays():
            here = array.numpy()
            if name not in content or (content[name].shape, content[name].dtype) != (here.shape, here.dtype):
                raise ValueError(f"{name} is missing or of another shape or type")
        self.step_count = step_count
        for name, array in self.arrays():
            if array.size:
                array.assign(content[name])


def _copies(values: State | SheetState | PassState | CreaseState) -> dict[str, Any]:
    """Fields by name, arrays as copies."""
    own = {field.name: getattr(values, field.name) for field in fields(values)}
    return {name: wp.clone(value) if isinstance(value, wp.array) else value for name, value in own.items()}
