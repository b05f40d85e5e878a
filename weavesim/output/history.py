"""Scalars of every frame of a run."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from ..run.frame import Frame, Outcome, RunInfo, unique_names
from .tables import write_table

# Entries of the ledger whose names state what they are; the others are energies.
_NOT_ENERGIES = ("energy", "work", "loss", "error", "supplied", "used")
# Entries of the ledger that are written of each of several sheets.
_ENERGIES_OF_A_SHEET = ("internal", "kinetic", "contact", "friction_loss", "damping_loss")
# Ratios of two energies, by their names in the ledger.
_RATIOS = {
    "kinetic over internal energy": ("kinetic", "internal"),
    "hourglass over internal energy": ("hourglass", "internal"),
    "damping loss over supplied work": ("damping_loss", "supplied"),
    "balance error over supplied work": ("balance_error", "supplied"),
}
# Of the largest lower energy, below which there is no ratio.
_LEAST_SHARE = 1.0e-3


class History:
    """Observer that keeps the scalars of every frame and the last frame.

    Attributes:
        tool_names: in the order of the tools.
        last_frame: the latest frame, None before the first.
        index, step_count, time [s], stroke [m]: one per frame.
        tool_displacement: (frame_count, tool_count) [m].
        tool_reaction: force of the sheet on each tool, (frame_count, tool_count, 3) [N].
        tool_pose: of each tool of a run in which one is carried, (frame_count, tool_count, 12): rotation matrix, row by
            row, and shift [m]; else (frame_count, 0, 12).
        tool_moment: of the sheets on each tool of such a run about its pivot, (frame_count, tool_count, 3) [N m].
        tool_wanted: force that drives each tool, (frame_count, tool_count) [N]; not a number where a stroke does.
        energies: by name, (frame_count,) [J].
        support_names, drive_names: in the order of the supports, and of all their drives.
        support_force: of each support on the sheet, (frame_count, support_count, 3) [N].
        drive_displacement, drive_force: (frame_count, drive_count) [m], [N].
        gripper_names: in the order of the grippers.
        gripper_force, gripper_slip: (frame_count, gripper_count) [N], [m].
        sheet_columns: of a run of several sheets, energies and largest shear angle of each, by the name of the column.
    """

    def __init__(self) -> None:
        self.tool_names: list[str] = []
        self.support_names: list[str] = []
        self.drive_names: list[str] = []
        self.gripper_names: list[str] = []
        self.last_frame: Frame | None = None
        self._rows: list[tuple] = []
        self._of_sheets: list[dict[str, float]] = []

    def start(self, info: RunInfo) -> None:
        """Take the names, and forget the frames of an earlier run."""
        self.tool_names = list(info.tool_names)
        self.support_names = [support.name for support in info.supports]
        self.drive_names = [f"{s.name}_drive_{k + 1}" for s in info.supports for k in range(len(s.drives))]
        self.gripper_names = [gripper.name for gripper in info.grippers]
        self.last_frame, self._rows, self._of_sheets = None, [], []

    def frame(self, frame: Frame) -> None:
        """Keep the scalars of a frame."""
        self.last_frame = frame
        self._of_sheets.append(_of_sheets(frame))
        self._rows.append(
            (
                frame.index,
                frame.step_count,
                frame.time,
                frame.stroke,
                np.array(frame.tool_displacement, dtype=float),
                np.array(frame.tool_reaction, dtype=float).reshape(-1, 3),
                dict(frame.energies),
                np.array(frame.support_force, dtype=float).reshape(-1, 3),
                np.array(frame.drive_displacement, dtype=float),
                np.array(frame.drive_force, dtype=float),
                np.array(
                    frame.tool_wanted if len(frame.tool_wanted) else [math.nan] * len(self.tool_names), dtype=float
                ),
                np.array(frame.gripper_force, dtype=float),
                np.array(frame.gripper_slip, dtype=float),
                np.array(frame.tool_pose, dtype=float).reshape(-1, 12),
                np.array(frame.tool_moment, dtype=float).reshape(-1, 3),
            )
        )

    def finish(self, outcome: Outcome) -> None:
        """Nothing to close; ``write`` creates the file."""

    @property
    def frame_count(self) -> int:
        """Frames so far."""
        return len(self._rows)

    @property
    def index(self) -> np.ndarray:
        """Numbers of the frames, (frame_count,)."""
        return self._column(0)

    @property
    def step_count(self) -> np.ndarray:
        """Steps so far at each frame, (frame_count,)."""
        return self._column(1)

    @property
    def time(self) -> np.ndarray:
        """Instants of the frames, (frame_count,) [s]."""
        return self._column(2)

    @property
    def stroke(self) -> np.ndarray:
        """Displacement of the leading tool along its axis, or without tools of the first drive, (frame_count,) [m]."""
        return self._column(3)

    @property
    def tool_displacement(self) -> np.ndarray:
        """Of each tool along its axis, (frame_count, tool_count) [m]."""
        return self._column(4).reshape(self.frame_count, len(self.tool_names))

    @property
    def tool_reaction(self) -> np.ndarray:
        """Force of the sheets on each tool, (frame_count, tool_count, 3) [N]."""
        return self._column(5).reshape(self.frame_count, len(self.tool_names), 3)

    @property
    def energies(self) -> dict[str, np.ndarray]:
        """Entries of the ledger by name, (frame_count,) each [J]; not a number in frames without one."""
        names = self._rows[0][6] if self._rows else {}
        return {name: np.array([row[6].get(name, math.nan) for row in self._rows], dtype=float) for name in names}

    @property
    def energy_ratios(self) -> dict[str, np.ndarray]:
        """Sizes of ratios by which a quasi-static run is judged, by what they are, (frame_count,) each [%].

        Not a number where the lower energy is below a thousandth of its largest, or the ratio is zero.
        """
        book, found = self.energies, {}
        for label, (name, over) in _RATIOS.items():
            if name in book and over in book:
                base = np.abs(book[over])
                base = np.where(base > _LEAST_SHARE * base.max(initial=0.0), base, np.nan)
                values = 100.0 * np.abs(book[name]) / base
                found[label] = np.where(values > 0.0, values, np.nan)
        return found

    @property
    def support_force(self) -> np.ndarray:
        """Force of each support on its sheet, (frame_count, support_count, 3) [N]."""
        return self._column(7).reshape(self.frame_count, len(self.support_names), 3)

    @property
    def drive_displacement(self) -> np.ndarray:
        """Of each drive along its direction, (frame_count, drive_count) [m]."""
        return self._column(8).reshape(self.frame_count, len(self.drive_names))

    @property
    def drive_force(self) -> np.ndarray:
        """Of each drive along its direction, (frame_count, drive_count) [N]."""
        return self._column(9).reshape(self.frame_count, len(self.drive_names))

    @property
    def tool_wanted(self) -> np.ndarray:
        """Force that drives each tool, (frame_count, tool_count) [N]; not a number where a stroke does."""
        return self._column(10).reshape(self.frame_count, len(self.tool_names))

    @property
    def gripper_force(self) -> np.ndarray:
        """Of the springs of each gripper, (frame_count, gripper_count) [N]."""
        return self._column(11).reshape(self.frame_count, len(self.gripper_names))

    @property
    def gripper_slip(self) -> np.ndarray:
        """Of the sheet through each gripper, the mean over its springs, (frame_count, gripper_count) [m]."""
        return self._column(12).reshape(self.frame_count, len(self.gripper_names))

    @property
    def tool_pose(self) -> np.ndarray:
        """Rotation matrix, row by row, and shift [m] of each tool, (frame_count, tool_count, 12), if one is carried."""
        return self._column(13)

    @property
    def tool_moment(self) -> np.ndarray:
        """Of the sheets on each tool about its pivot, (frame_count, tool_count, 3) [N m], where one is carried."""
        return self._column(14)

    @property
    def sheet_columns(self) -> dict[str, np.ndarray]:
        """Energies [J] and largest shear angle of each of several sheets, by column, (frame_count,) each."""
        names = self._of_sheets[0] if self._of_sheets else {}
        return {name: np.array([row.get(name, math.nan) for row in self._of_sheets]) for name in names}

    def _column(self, place: int) -> np.ndarray:
        return np.array([row[place] for row in self._rows])

    def write(self, path: str | Path) -> None:
        """Write ``history.csv``: frame, step count, time, stroke; displacement and force of each tool; of each of a run
        in which one is carried, shift, turn (a rotation vector) and moment about its pivot; force that drives
        each of those that a force moves; force of each support; displacement and force of each drive;
        force and slip of each gripper; every energy; what there is of each of several sheets.
        """
        energies, of_sheets = self.energies, self.sheet_columns
        header = ["frame", "step_count", "time_s", "stroke_m"]
        for name in self.tool_names:
            header += [f"{name}_displacement_m", *(f"{name}_force_{axis}_n" for axis in "xyz")]
        if self.tool_pose.size:
            header += [f"{name}_{what}" for name in self.tool_names for what in _OF_CARRIED]
        carried = _of_carried(self.tool_pose, self.tool_moment)
        wanted = self.tool_wanted
        driven = np.isfinite(wanted).any(axis=0) if len(wanted) else np.zeros(len(self.tool_names), dtype=bool)
        header += [f"{name}_wanted_force_n" for name, by_force in zip(self.tool_names, driven, strict=True) if by_force]
        header += [f"{name}_force_{axis}_n" for name in self.support_names for axis in "xyz"]
        header += [f"{name}_{what}" for name in self.drive_names for what in ("displacement_m", "force_n")]
        of_gripper = ("gripper_force_n", "gripper_slip_m")
        header += [f"{name}_{what}" for name in self.gripper_names for what in of_gripper]
        header += [f"{name}_j" if name.endswith(_NOT_ENERGIES) else f"{name}_energy_j" for name in energies]
        header += list(of_sheets)
        grippers = np.stack([self.gripper_force, self.gripper_slip], axis=2).reshape(self.frame_count, -1)
        rows = []
        for i, (index, step_count, time, stroke, displacement, reaction, _, support, travel, force, *_) in enumerate(
            self._rows
        ):
            tools = np.column_stack([displacement, reaction]).ravel().tolist() if len(displacement) else []
            tools += carried[i].ravel().tolist()
            supports = [*support.ravel().tolist(), *np.column_stack([travel, force]).ravel().tolist()]
            values = (float(values[i]) for values in (*energies.values(), *of_sheets.values()))
            rest = [*wanted[i][driven].tolist(), *supports, *grippers[i].tolist(), *values]
            rows.append([index, step_count, time, stroke, *tools, *rest])
        # a tool and a support may have the same name
        write_table(path, unique_names(header), rows)


def tool_copies(info: RunInfo) -> list[float]:
    """By what the force of each tool on the computed part is multiplied to be that on the whole."""
    shares = [
        [sheet.symmetry.share for sheet in info.sheets if place in sheet.tools] for place in range(len(info.tools))
    ]
    return [1.0 / own[0] if own else 1.0 for own in shares]


def energy_copies(info: RunInfo) -> float | None:
    """The same of energies; None if the sheets are different shares of their wholes."""
    shares = {sheet.symmetry.share for sheet in info.sheets}
    return 1.0 / shares.pop() if len(shares) == 1 else None


def computed_part(info: RunInfo) -> str:
    """What was computed, in words, for numbers that are not of the whole."""
    shares = {sheet.symmetry.share for sheet in info.sheets}
    names = {1.0: "whole part", 0.5: "computed half", 0.25: "computed quarter"}
    return names[shares.pop()] if len(shares) == 1 else "computed parts"


# Columns of each tool of a run in which one is carried along a path or turned.
_OF_CARRIED = (
    *(f"shift_{axis}_m" for axis in "xyz"),
    *(f"turn_{axis}_deg" for axis in "xyz"),
    *(f"moment_{axis}_n_m" for axis in "xyz"),
)


def _of_carried(pose: np.ndarray, moment: np.ndarray) -> np.ndarray:
    """Shift, rotation vector [degrees] and moment of every tool in every frame, (frame_count, tool_count, 9)."""
    if not pose.size:
        return np.zeros((len(pose), 0, len(_OF_CARRIED)))
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_matrix(pose[..., :9].reshape(-1, 3, 3)).as_rotvec(degrees=True)
    return np.concatenate([pose[..., 9:], turn.reshape(*pose.shape[:2], 3), moment], axis=2)


def _of_sheets(frame: Frame) -> dict[str, float]:
    """Scalars of each sheet by the name of their column; none for a single sheet, which has those of the run."""
    if len(frame.sheets) == 1:
        return {}
    found: dict[str, float] = {}
    for sheet in frame.sheets:
        found[f"{sheet.name}_max_shear_angle_deg"] = float(np.nanmax(np.abs(np.rad2deg(sheet.fields["shear_angle"]))))
        for name in _ENERGIES_OF_A_SHEET:
            if name in sheet.energies:
                found[f"{sheet.name}_{name}{'' if name.endswith(_NOT_ENERGIES) else '_energy'}_j"] = sheet.energies[
                    name
                ]
    return found
