"""Launches of the contact of creases of one sheet, on one state."""

from __future__ import annotations

from typing import Any

import warp as wp

from ...kernels.creases.data import GROUP, crease_search_struct
from ...kernels.creases.meet import gather_creases_kernel, meet_creases_kernel
from ...kernels.creases.search import (
    adopt_pairs_kernel,
    bound_creases_kernel,
    list_creases_kernel,
    list_pairs_kernel,
    look_at_edges_kernel,
    sum_creases_kernel,
    sum_pairs_kernel,
)
from .crease_model import CreaseModel
from .crease_state import CreaseState

# Threads of a launch on a GPU, where each does every so manieth crease; on a CPU a launch is one call.
LARGEST_LAUNCH = 16384


class CreaseLaunches:
    """Every launch of the contact of creases of one sheet on one state.

    Args:
        model: constants.
        own: what is written.
        motion: of the sheet's nodes.
        total: contact force on its nodes, (3, nodes) [N], after its passes.
        entry: PassEntry of the first pass of the sheet on itself.
        clock: of the state.
    """

    def __init__(
        self, model: CreaseModel, own: CreaseState, motion: wp.array, total: wp.array, entry: wp.array, clock: wp.array
    ) -> None:
        self.model, self._total, self._entry, self._clock = model, total, entry, clock
        self._edges, self._creases = model.edges(motion), own.creases(model)
        self._search = self._make_search()
        self._around = model.integers(model.around)

    def _make_search(self) -> Any:
        model, search = self.model, crease_search_struct(self.model.real)()
        group_count = -(-model.edge_count // int(GROUP))
        vec3 = wp.types.vector(3, model.real)

        def zeros(like: Any, dtype: Any) -> wp.array:
            return wp.zeros(like, dtype=dtype, device=model.device)

        search.of_group, search.largest_turn = zeros(group_count, wp.int32), zeros(group_count, model.real)
        search.low, search.high = zeros(group_count, vec3), zeros(group_count, vec3)
        search.first, search.count = zeros(model.edge_count, wp.int32), zeros(model.edge_count, wp.int32)
        search.partner = zeros(model.entry_count, wp.int32)
        search.rows = wp.zeros_like(self._creases.rows)
        return search

    def _launch(self, kernel: wp.Kernel, count: int, part: tuple[int, int], inputs: list) -> None:
        """This thread's share of at most ``count`` edges, groups or creases: every so manieth."""
        thread, thread_count = part
        dim = 1
        if self.model.device.is_cuda:
            dim = thread_count = max(1, min(count, LARGEST_LAUNCH))
        wp.launch(kernel, dim=dim, inputs=[thread, thread_count, *inputs], device=self.model.device)

    def meet(self, thread_count: int, thread: int) -> None:
        """Forces on this thread's share of the creases, before anything moves."""
        kernel = meet_creases_kernel(self.model.real)
        inputs = [self._edges, self._clock, self._creases]
        self._launch(kernel, self.model.edge_count, (thread, thread_count), inputs)

    def gather(self, first: int, count: int) -> None:
        """Forces of their edges on ``count`` blocks of nodes from ``first``, after all passes and all creases."""
        lanes, device = self.model.sheet.lane_count, self.model.device
        start = min(first * lanes, self._around.shape[1])
        stop = min((first + count) * lanes, self._around.shape[1])
        dim = max(stop - start, 1) if device.is_cuda else 1
        inputs = [start, stop, dim, self._around, self._creases]
        wp.launch(gather_creases_kernel(self.model.real), dim=dim, inputs=inputs, outputs=[self._total], device=device)

    def search(self, phase: int, thread_count: int, thread: int) -> None:
        """One of eight phases of an update of the stable step, with a barrier after each."""
        real, part = self.model.real, (thread, thread_count)
        edges, creases, search, entry = self._edges, self._creases, self._search, self._entry
        edge_count, group_count = self.model.edge_count, search.of_group.shape[0]
        if phase == 0:
            self._launch(look_at_edges_kernel(real), group_count, part, [edges, entry, creases, search])
        elif phase == 1 and thread == 0:
            self._launch_one(sum_creases_kernel(real), [edges, entry, creases, search])
        elif phase == 2:
            self._launch(list_creases_kernel(real), group_count, part, [edges, creases, search])
        elif phase == 3:
            self._launch(bound_creases_kernel(real), group_count, part, [edges, entry, creases, search])
        elif phase == 4:
            self._launch(list_pairs_kernel(real, True), edge_count, part, [edges, entry, creases, search])
        elif phase == 5 and thread == 0:
            self._launch_one(sum_pairs_kernel(real), [creases, search, entry])
        elif phase == 6:
            self._launch(list_pairs_kernel(real, False), edge_count, part, [edges, entry, creases, search])
            self._launch(adopt_pairs_kernel(real)[1], edge_count, part, [edges, creases])
        elif phase == 7:
            self._launch(adopt_pairs_kernel(real)[0], edge_count, part, [creases, search])

    def _launch_one(self, kernel: wp.Kernel, inputs: list) -> None:
        wp.launch(kernel, dim=1, inputs=inputs, device=self.model.device)


def crease_kernels(real: type) -> list[wp.Kernel]:
    """The kernels of the contact of creases, roughly in order of decreasing compile time."""
    return [
        meet_creases_kernel(real),
        list_pairs_kernel(real, False),
        list_pairs_kernel(real, True),
        look_at_edges_kernel(real),
        bound_creases_kernel(real),
        *adopt_pairs_kernel(real),
        gather_creases_kernel(real),
        list_creases_kernel(real),
        sum_pairs_kernel(real),
        sum_creases_kernel(real),
    ]
