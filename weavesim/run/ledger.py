"""The energy ledger of a run and its frames, computed from the state without changing it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import reduce
from typing import Any, NamedTuple

import numpy as np

from ..engine.loading.grips import GripperState
from ..engine.state import State
from ..engine.stepper import Stepper
from ..kernels.rows import ToolWatchRow, ToolWorkRow
from ..process.device import support_forces
from ..tools.carried.device import pose_of
from .frame import Frame, SheetFrame, unique_names
from .interface_ledger import InterfaceLedger
from .sheet_ledger import NO_PENETRATION, Penetration, SheetLedger, centred

STORED = ("kinetic", "tool_kinetic", "internal", "contact", "friction_spring", "gripper_spring")
LOST = (
    "friction_loss",
    "damping_loss",
    "tool_damping_loss",
    "gripper_loss",
    "snap_loss",
    "shear_friction_loss",
    "bending_friction_loss",
)
# Entries of a run with interfaces between plies, beside those.
PLY_STORED = ("ply_contact", "ply_friction_spring")
PLY_LOST = ("ply_friction_loss", "ply_damping_loss")
PLY_SUPPLIED = ("ply_thickness_work",)
SUPPLIED = (
    "tool_work", "driving_force_work", "support_work", "load_work", "pressure_work", "gripper_work", "thickness_work",
    "gravity_work", "initial_kinetic",
)  # fmt: skip
# Of a run in stages: what changes between stages put into what is stored.
STAGE_SUPPLIED = ("stage_work",)
# Of a run whose stages trim a sheet: what the waste stored when it was cut away.
TRIM_LOST = ("trimmed_energy",)
# Derived from the other entries.
SUMS = ("internal", "supplied", "used", "balance_error")
# Positions of the entries of the tools among those of the sheets.
_BEFORE_TOOLS = {
    "tool_kinetic": "kinetic",
    "tool_damping_loss": "damping_loss",
    "tool_work": "load_work",
    "driving_force_work": "tool_work",
}


class StageBook(NamedTuple):
    """What the ledger of a stage knows of it.

    Attributes:
        name: of the stage.
        tools: names of those that act.
        carried: what is added to entries of the ledger, by name, so that they go on from the stage before [J].
        trims: whether any stage of the run trims a sheet.
    """

    name: str
    tools: frozenset[str]
    carried: dict[str, float]
    trims: bool = False


class Ledger:
    """Takes frames of a run.

    Args:
        stepper: its state is read.
        stage: of a run that has some; None without stages.

    Attributes:
        stage: as given.
        acting: whether each tool acts, (tool_count,) bool.
        sheets: ledgers of every sheet.
        interfaces: ledger of the contact between plies.
        internal: names of the elastic energies of all sheets; their sum is the entry ``internal``.
        tool_names: as in all outputs.
    """

    def __init__(self, stepper: Stepper, stage: StageBook | None = None) -> None:
        self._stepper, self._setup = stepper, stepper.model.setup
        self.stage = stage
        tools = self._setup.tools
        self.acting = np.array([stage is None or tool.name in stage.tools for tool in tools], dtype=bool)
        self.sheets = [
            SheetLedger(stepper.model, k, stepper.state, self.acting) for k in range(len(stepper.model.sheets))
        ]
        self.internal = tuple(dict.fromkeys(name for sheet in self.sheets for name in sheet.internal))
        self.interfaces = InterfaceLedger(stepper.model, stepper.state)
        self.tool_names = unique_names(tool.name for tool in tools)
        self._driven = np.array([tool.motion.by_force for tool in tools], dtype=bool)
        self._tool_mass = np.array([tool.motion.driven_mass for tool in tools])
        self._last: Frame | None = None

    def frame(self, index: int) -> Frame:
        """A frame of the current state; waits for the device."""
        state, ahead = self._stepper.state, self._stepper.look_ahead()
        sheets = tuple(
            replace(frame, fields=frame.fields | self.interfaces.fields(k, ahead))
            for k, frame in enumerate(sheet.frame(ahead) for sheet in self.sheets)
        )
        tool_displacement = state.tool_displacement.numpy().copy()
        drive_displacement = state.drive_displacement.numpy().copy()
        support_force, drive_force = self._support_outputs(ahead)
        # the next step has evaluated them at these positions
        grippers = [
            GripperState.of(model, own.grip)
            for model, own in zip(self._stepper.model.sheets, ahead.sheets, strict=True)
        ]
        leading = tool_displacement[self._setup.leading_tool :] if len(tool_displacement) else drive_displacement
        self._last = Frame(
            index=index,
            step_count=state.step_count,
            time=state.time,
            stroke=float(leading[0]) if len(leading) else 0.0,
            sheets=sheets,
            tool_displacement=tool_displacement,
            tool_reaction=state.tool_force.numpy().copy(),
            tool_pose=np.array([pose_of(entries).numbers for entries in state.tool_pose.numpy()]).reshape(-1, 12),
            tool_moment=state.tool_moment.numpy().copy(),
            energies=self._balance(sheets, ahead),
            support_force=support_force,
            gripper_force=np.concatenate([each.force for each in grippers]),
            gripper_slip=np.concatenate([each.slip for each in grippers]),
            drive_displacement=drive_displacement,
            drive_force=drive_force,
            tool_wanted=np.array([tool.motion.force_at(state.time) for tool in self._setup.tools]),
            tool_acts=self.acting,
            stage=self.stage.name if self.stage else "",
        )
        return self._last

    def completed(self, frame: Frame) -> Frame:
        """A frame with the fields that only those of observers have, if it is the last one that was taken.

        Those of a checkpoint have them, or cannot get them any more. Waits for the device.
        """
        if frame is not self._last:
            return frame
        sheets = tuple(
            replace(sheet, fields=sheet.fields | ledger.written_fields(sheet))
            for ledger, sheet in zip(self.sheets, frame.sheets, strict=True)
        )
        return replace(frame, sheets=sheets)

    def _support_outputs(self, ahead: State) -> tuple[np.ndarray, np.ndarray]:
        """Current forces of all supports (support_count, 3), and along all drives (drive_count,) [N]."""
        force: list[list[float]] = []
        along: list[float] = []
        for sheet, state in zip(self._stepper.model.sheets, ahead.sheets, strict=True):
            own_force, own_along = support_forces(sheet.supports, state.holding.numpy())
            force += own_force
            along += own_along
        return np.array(force).reshape(-1, 3), np.array(along)

    def _balance(self, sheets: tuple[SheetFrame, ...], ahead: State) -> dict[str, float]:
        """Every entry of the ledger [J], the sums of supplied and used energy, and their difference."""
        entries: dict[str, float] = {}
        for sheet in sheets:
            for name, value in sheet.energies.items():
                entries[name] = entries[name] + value if name in entries else value
        state = self._stepper.state
        work = centred(state.tool_work, ahead.tool_work, state.step_count > 0)
        of_tools = {
            "tool_kinetic": 0.5 * float(self._tool_mass @ (state.tool_velocity.numpy() * ahead.tool_velocity.numpy())),
            "tool_damping_loss": float(work[ToolWorkRow.damping].sum()),
            # also of tools that a force moves along their axes
            "tool_work": float(work[ToolWorkRow.on_sheet][~self._driven].sum() + work[ToolWorkRow.carrying].sum()),
            "driving_force_work": float(work[ToolWorkRow.driving][self._driven].sum()),
        }
        entries = _inserted(entries, of_tools)
        stored: tuple[str, ...] = STORED
        lost: tuple[str, ...] = LOST
        supplied: tuple[str, ...] = SUPPLIED
        if self.interfaces.passes:
            entries |= self.interfaces.entries(state, ahead)
            stored, lost, supplied = stored + PLY_STORED, lost + PLY_LOST, supplied + PLY_SUPPLIED
        if self.stage is not None:
            supplied += STAGE_SUPPLIED
            entries["stage_work"] = 0.0
            if self.stage.trims:
                lost += TRIM_LOST
                entries |= dict.fromkeys(TRIM_LOST, 0.0)
            for name, value in self.stage.carried.items():
                entries[name] += value
        entries["supplied"] = sum(entries[name] for name in supplied)
        entries["used"] = sum(entries[name] for name in stored + lost)
        entries["balance_error"] = entries["supplied"] - entries["used"]
        return entries

    def carry_on(self, last: Mapping[str, float], index: int, trimmed: bool = False) -> None:
        """Begin a stage: works and losses go on from the ``last`` entries of the stage before, of the same state.

        What the change puts into the stored energies is booked as ``stage_work``; what a trim takes out of them, as
        ``trimmed_energy``.

        Args:
            last: entries of the ledger before the change [J].
            index: of the frame at that time.
            trimmed: whether a trim is all that has changed.
        """
        assert self.stage is not None
        carried = self.stage.carried
        carried.clear()
        now = self.frame(index).energies
        stored = [name for name in STORED + PLY_STORED if name in now]
        names = LOST + PLY_LOST + SUPPLIED + PLY_SUPPLIED + STAGE_SUPPLIED + TRIM_LOST
        carried |= {name: last[name] - now[name] for name in names if name in now}
        change = sum(now[name] for name in stored) - sum(last[name] for name in stored)
        if trimmed:
            carried["trimmed_energy"] -= change
        else:
            carried["stage_work"] += change

    def watched(self) -> dict[str, np.ndarray]:
        """What every step has booked of the tools so far, by names of ``ToolWatchRow``, (tool_count,) each."""
        return dict(zip(ToolWatchRow.names(), self._stepper.state.tool_watch.numpy().copy(), strict=True))

    def interface_report(self) -> list[dict[str, Any]]:
        """Numbers of every interface between plies for the summary; waits for the device."""
        if not self.interfaces.passes:
            return []
        return self.interfaces.report(self._stepper.state, self._stepper.look_ahead())

    def penetration(self, frame: Frame) -> Penetration:
        """Deepest penetration of a frame just taken."""
        found = (ledger.penetration(sheet) for ledger, sheet in zip(self.sheets, frame.sheets, strict=True))
        return replace(reduce(Penetration.deeper, found, NO_PENETRATION), time=frame.time)


def _inserted(entries: dict[str, float], of_tools: dict[str, float]) -> dict[str, float]:
    """``entries`` with those of the tools inserted after the related ones, in the order of all outputs."""
    names = list(entries)
    for name, before in _BEFORE_TOOLS.items():
        names.insert(names.index(before) + 1, name)
    return {name: of_tools[name] if name in of_tools else entries[name] for name in names}
