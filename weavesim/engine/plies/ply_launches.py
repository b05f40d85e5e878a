"""Contact of all plies of a run in a step, and its search at every update of the stable step."""

from __future__ import annotations

from collections.abc import Iterator

import warp as wp

from ...kernels.plies.collect import GROUP, watch_speed_kernel
from ...kernels.plies.own_search import SLOT_COUNT
from ...kernels.stepping.step import group_maximum_kernel
from ..creases.crease_launches import CreaseLaunches
from ..model import Model
from ..state import State
from ..tiling.corner_ring import CornerRing
from ..tiling.tiles import chunks
from .mirror_launches import MirrorLaunches
from .mirror_model import MirrorModel
from .normals import NormalLaunch
from .own_search import OwnSearch
from .pass_launches import FacetLaunches, PassLaunches, group_count
from .ply_kernels import mirror_kernels, own_contact_kernels, ply_kernels


class PlyLaunches:
    """Launches of all passes of a run on one state; without interfaces and self-contact there are none.

    Args:
        model: constants.
        state: what the launches read and write.
    """

    def __init__(self, model: Model, state: State) -> None:
        self._model, self._state = model, state
        touched = {place for each in model.passes for place in (each.place.slave, each.place.master)}
        self._touched = sorted(touched)
        speeds = [
            wp.zeros(sheet.block_count if index in touched else 0, dtype=sheet.real, device=sheet.device)
            for index, sheet in enumerate(model.sheets)
        ]
        self._speeds = speeds
        self._group_speeds = [
            wp.zeros(group_count(each.shape[0]), dtype=each.dtype, device=each.device) for each in speeds
        ]
        self._normals = {
            index: NormalLaunch(model.sheets[index], state.sheets[index].motion, state.sheets[index].awake)
            for index in self._touched
        }
        normals = [self._normals[index].normals if index in touched else speeds[index] for index in range(len(speeds))]
        self._passes: list[PassLaunches] = [
            MirrorLaunches(each, state, index, self._group_speeds, normals)
            if isinstance(each, MirrorModel)
            else FacetLaunches(each, state, index, self._group_speeds, normals)
            for index, each in enumerate(model.passes)
        ]
        self._on_facets = [each for each in self._passes if isinstance(each, FacetLaunches)]
        self._own = {
            each.place.slave: OwnSearch(
                each,
                state.sheets[each.place.slave].motion,
                normals[each.place.slave],
                [own.entry for own in state.passes[index : index + int(SLOT_COUNT)]],
                state.sheets[each.place.slave].awake,
            )
            for index, each in enumerate(model.passes)
            if each.place.slot == 0
        }

        self._creases = [
            CreaseLaunches(
                each,
                own,
                state.sheets[each.own_pass.place.slave].motion,
                state.sheets[each.own_pass.place.slave].contact_force,
                state.passes[model.passes.index(each.own_pass)].entry,
                state.clock,
            )
            for each, own in zip(model.creases, state.creases, strict=True)
        ]
        # feet on other plies, and at planes, are found with the normals of the update
        self._always = {each.place.slave for each in model.passes if each.place.plane} | {
            each.place.master for each in model.passes if each.place.slot < 0 and not each.place.plane
        }
        self._sought = sorted(self._always | set(self._own))

    def __bool__(self) -> bool:
        return bool(self._passes)

    def find_normals(self, thread_count: int = 1, thread: int = 0) -> None:
        """Normals and creases, this thread's share, before ``meet``; all threads must be done with them."""
        for index, normals in self._normals.items():
            normals.launch(*chunks(self._model.sheets[index].block_count, thread_count)[thread])
        for creases in self._creases:
            creases.meet(thread_count, thread)

    def meet(self, thread_count: int = 1, thread: int = 0) -> None:
        """Contact forces on this thread's share of the nodes of every pass, before anything moves."""
        for each in self._passes:
            # a sheet's passes add to the same sums: its nodes are divided alike in all of them
            each.meet(*chunks(each.node_block_count, thread_count)[thread])
        for creases in self._creases:
            creases.gather(*chunks(creases.model.sheet.block_count, thread_count)[thread])

    def push(self, sheet: int, first: int, count: int, ring: CornerRing | None = None) -> None:
        """Reactions on ``count`` blocks of elements of a sheet from ``first``, after their own forces."""
        for each in self._on_facets:
            if each.model.place.master == sheet:
                each.push(first, count, None if ring is None else ring.at(first))

    def watch_speeds(self, thread_count: int = 1, thread: int = 0) -> None:
        """Largest speeds of this thread's share of the nodes."""
        for index in self._touched:
            sheet, own = self._model.sheets[index], self._state.sheets[index]
            first, count = chunks(sheet.block_count, thread_count)[thread]
            wp.launch(
                watch_speed_kernel(sheet.real, sheet.lane_count),
                dim=count,
                inputs=[first, sheet.motion_layout.view(own.motion)],
                outputs=[self._speeds[index]],
                device=sheet.device,
            )

    def _find_group_speeds(self, index: int) -> None:
        sheet, largest = self._model.sheets[index], self._group_speeds[index]
        wp.launch(
            group_maximum_kernel(sheet.real, GROUP), dim=len(largest), inputs=[self._speeds[index]], outputs=[largest],
            device=sheet.device,
        )  # fmt: skip

    def search(self, thread_count: int = 1, thread: int = 0) -> Iterator[None]:
        """Search for the next steps, after the speeds and the step are known; at each pause all threads must meet."""
        if thread == 0:
            for index in self._touched:
                self._find_group_speeds(index)
            for each in self._passes:
                each.plan()
        yield
        for each in self._on_facets:
            each.bound(*chunks(each.facet_group_count, thread_count)[thread])
        for index in self._sought:
            count = self._model.sheets[index].block_count
            self._normals[index].launch(*chunks(count, thread_count)[thread], always=index in self._always)
        self._search_creases(0, thread_count, thread)
        yield
        yield from self._search_within_sheets(thread_count, thread)
        for each in self._passes:
            if isinstance(each, FacetLaunches) and each.model.is_own:
                found = self._own[each.model.place.slave].found
                each.follow(found, *chunks(each.node_block_count, thread_count)[thread])
            each.seek(*chunks(each.node_block_count, thread_count)[thread])
        self._search_creases(4, thread_count, thread)
        yield
        if thread == 0:
            for each in self._passes:
                each.collect()
        self._search_creases(5, thread_count, thread)
        yield
        for each in self._on_facets:
            each.list_nodes(*chunks(each.facet_block_count, thread_count)[thread])
        self._search_creases(6, thread_count, thread)
        yield
        for each in self._on_facets:
            facets, nodes = chunks(each.facet_block_count, thread_count), chunks(each.node_block_count, thread_count)
            each.adopt(facets[thread], nodes[thread])
        self._search_creases(7, thread_count, thread)
        yield

    def _search_creases(self, phase: int, thread_count: int, thread: int) -> None:
        for creases in self._creases:
            creases.search(phase, thread_count, thread)

    def _search_within_sheets(self, thread_count: int, thread: int) -> Iterator[None]:
        if not self._own:
            return
        for own in self._own.values():
            groups = own.node_group_count, own.facet_group_count
            own.bound(*(chunks(count, thread_count)[thread] for count in groups))
        self._search_creases(1, thread_count, thread)
        yield
        for own in self._own.values():
            own.seek(*chunks(own.node_group_count, thread_count)[thread])
        self._search_creases(2, thread_count, thread)
        yield
        if thread == 0:
            for own in self._own.values():
                own.settle()
        self._search_creases(3, thread_count, thread)
        yield

    @property
    def kernels(self) -> list[wp.Kernel]:
        """All kernels launched here."""
        if not self._passes:
            return []
        kernels = ply_kernels(self._model.real, self._model.lane_count)
        if self._own:
            kernels += own_contact_kernels(self._model.real, self._model.lane_count)
        if any(each.place.plane for each in self._model.passes):
            kernels += mirror_kernels(self._model.real, self._model.lane_count)
        return kernels
