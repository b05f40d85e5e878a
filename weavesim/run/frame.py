"""What a run tells its observers: frames, and how it ended."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from typing import TYPE_CHECKING, Protocol

import numpy as np

from ..errors import InputError

if TYPE_CHECKING:
    from .simulation import Simulation


@dataclass(frozen=True)
class SheetFrame:
    """State of one sheet at one instant. SI units; float64 copies on the host.

    Attributes:
        name: of the sheet.
        position: nodes, (node_count, 3) [m].
        director: unit directors, (node_count, 3).
        fields: one value per element, (element_count,): shear_angle [rad], warp_stretch, weft_stretch,
            warp_force and weft_force [N/m], crossover_pressure between warp and weft per reference area [N/m^2],
            crossover_force [N] (if the cell has a crossover_area), area_ratio,
            shear_moment (elastic and friction, without in-plane bending) [N/m], thickness [m],
            fibre_volume_fraction (if the fabric gives its fibre content), unit_cell_residual (worst so far),
            unit_cell_iterations, unit_cell_failed (0 or 1).
        energies: the entries of the ledger that belong to one sheet [J], by name.
    """

    name: str
    position: np.ndarray
    director: np.ndarray
    fields: dict[str, np.ndarray]
    energies: dict[str, float]


@dataclass(frozen=True)
class Frame:
    """State of a run at one instant. SI units; float64 copies on the host.

    Attributes:
        index: number of the frame, 0 for the undeformed state.
        step_count: time steps done.
        time: [s].
        stroke: displacement of the leading tool along its axis, without tools that of the first drive [m].
        sheets: in the order of the set-up.
        tool_displacement: along each tool's axis, (tool_count,) [m].
        tool_reaction: force of the sheets on each tool, (tool_count, 3) [N].
        energies: every entry of the ledger [J], by name, summed over the sheets.
        support_force: force of each support on its sheet, (support_count, 3) [N]: it holds against all other forces on
            its nodes and accelerates their mass.
        drive_displacement: of every drive of every support, in order, (drive_count,) [m].
        drive_force: of the support on the sheet along each drive, (drive_count,) [N]: its work per unit of the drive's
            displacement.
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

    @property
    def sheet(self) -> SheetFrame:
        """The sheet of a run that has one.

        Raises:
            InputError: the run has several.
        """
        if len(self.sheets) != 1:
            raise InputError(f"this run has {len(self.sheets)} sheets: take one of frame.sheets")
        return self.sheets[0]

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


class Outcome(Enum):
    """How a run ended."""

    FINISHED = "finished"
    INTERRUPTED = "interrupted"
    NOT_FINITE = "not finite"


class Observer(Protocol):
    """Receives the frames of a run; a file-writing observer leaves a readable file at every ``finish``."""

    def start(self, simulation: Simulation) -> None: ...

    def frame(self, frame: Frame) -> None: ...

    def finish(self, outcome: Outcome) -> None: ...
