"""Launches of the contact of a sheet with its mirror image, on one state."""

from __future__ import annotations

import warp as wp

from ...kernels.plies.mirror import meet_mirror_kernel, watch_mirror_kernel
from ...kernels.stepping.step import fold_works_kernel
from ..state import State
from .mirror_model import MirrorModel
from .pass_launches import PassLaunches


class MirrorLaunches(PassLaunches):
    """Launches of one such pass on one state: the plane does not move, and there are neither facets nor lists.

    Args:
        model, state, index, squared_speeds: see ``PassLaunches``.
        normals: of every sheet, written by ``surface_normals``.
    """

    model: MirrorModel

    def __init__(
        self, model: MirrorModel, state: State, index: int, squared_speeds: list[wp.array], normals: list[wp.array]
    ) -> None:
        super().__init__(model, state, index, squared_speeds)
        self._mirror = model.mirror(state.sheets[model.place.slave].motion, normals[model.place.slave])

    def meet(self, first: int, count: int) -> None:
        """Forces on ``count`` blocks of nodes from ``first``, before anything moves."""
        kernel = meet_mirror_kernel(self._real, self._lanes)
        self._launch(kernel, count, [first, self._mirror, self._clock], [self._record])

    def seek(self, first: int, count: int) -> None:
        """Which nodes may touch, and blocks to be watched; the works of the last steps are added to their sums."""
        kernel = watch_mirror_kernel(self._real, self._lanes)
        self._launch(kernel, count, [first, self._mirror], [self._record, self._watch])
        self._launch(
            fold_works_kernel(self._real, self._lanes), count, [first], [self._record.works, self._own.works_sum]
        )
