"""Launches after the elements of a step: pressures and grippers add their forces at the corners."""

from __future__ import annotations

import warp as wp

from ...kernels.loads.grippers import grip_kernel
from ...kernels.loads.pressure import element_pressure_kernel
from ..model import Model
from ..state import State
from ..tiling.corner_ring import CornerRing
from .grips import device_grips
from .pressures import device_pressures


class LoadLaunches:
    """The launches of the loads that follow their sheets, on one state.

    Args:
        model: constants.
        state: what the launches read and write.

    Attributes:
        grips: of the grippers of every sheet that has some, by its index.
    """

    def __init__(self, model: Model, state: State) -> None:
        self._model, self._state = model, state
        self._pressing = element_pressure_kernel(model.real, model.lane_count)
        self._pulling = grip_kernel(model.real)
        self._pressures = {
            index: device_pressures(sheet) for index, sheet in enumerate(model.sheets) if sheet.pressures
        }
        self.grips = {index: device_grips(sheet) for index, sheet in enumerate(model.sheets) if sheet.grippers}

    @property
    def kernels(self) -> list[wp.Kernel]:
        """All kernels launched here."""
        return [*([self._pressing] if self._pressures else []), *([self._pulling] if self.grips else [])]

    def apply(self, index: int, first: int = 0, count: int | None = None, ring: CornerRing | None = None) -> None:
        """Add to the corner forces of sheet ``index``, in ``count`` blocks of elements from ``first``."""
        if index not in self._pressures and index not in self.grips:
            return
        sheet, own, clock = self._model.sheets[index], self._state.sheets[index], self._state.clock
        block_count = sheet.element_count // sheet.lane_count if count is None else count
        if index in self._pressures:
            wp.launch(
                self._pressing,
                dim=block_count,
                inputs=[first, sheet.elements, self._pressures[index], own.motion, clock],
                outputs=[sheet.corners.view(own.corner_force) if ring is None else ring.at(first), own.pressure_work],
                device=sheet.device,
            )
        if index in self.grips:
            grips = self.grips[index]
            first_grip, grip_count = grips.within(first * sheet.lane_count, block_count * sheet.lane_count)
            if grip_count:
                wp.launch(
                    self._pulling,
                    dim=grip_count,
                    inputs=[first_grip, grips.grips, own.motion, clock],
                    outputs=[own.corner_force, own.grip],
                    device=sheet.device,
                )
