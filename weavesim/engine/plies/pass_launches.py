"""Launches of one pass of an interface, with all arguments, on one state."""

from __future__ import annotations

from typing import Any

import warp as wp

from ...kernels.plies.collect import (
    GROUP,
    adopt_lists_kernel,
    begin_travel_kernel,
    count_strays_kernel,
    list_nodes_kernel,
    list_strays_kernel,
    sum_up_kernel,
    survey_groups_kernel,
    survey_struct,
)
from ...kernels.plies.data import FAR, blocks_per_call, listed_struct, record_struct
from ...kernels.plies.node_pass import meet_plies_kernel
from ...kernels.plies.own_search import follow_own_facets_kernel
from ...kernels.plies.reaction import push_facets_kernel, reaction_struct
from ...kernels.plies.search import (
    bound_facets_kernel,
    plan_search_kernel,
    seek_feet_kernel,
    watch_struct,
)
from ..layout import lanes_view
from ..state import State
from .pass_model import PassModel


class PassLaunches:
    """What is launched of any pass on one state: the nodes of a sheet before facets, or before a plane.

    Args:
        model: constants of the pass.
        state: of the run.
        index: of the pass.
        squared_speeds: largest squared speed of every group of blocks of every sheet, written by ``PlyLaunches``.
    """

    def __init__(self, model: PassModel, state: State, index: int, squared_speeds: list[wp.array]) -> None:
        self.model, self._own = model, state.passes[index]
        self._awake = [state.sheets[k].awake for k in (model.place.slave, model.place.master)]
        self._clock, self._speeds = state.clock, squared_speeds
        self._real, self._lanes = model.real, model.lane_count
        self._search = model.search()
        self._record = self._make_record(state.sheets[model.place.slave].contact_force)
        self.facet_group_count = self._search.group.shape[1]
        self._watch, self._survey = self._make_watch(), self._make_survey()
        self.node_block_count = model.slave.block_count

    def _make_record(self, total: wp.array) -> Any:
        record, own = record_struct(self._real, self._lanes)(), self._own
        record.facet, record.standing = lanes_view(own.facet, self._lanes), lanes_view(own.standing, self._lanes)
        record.rows = self.model.rows.view(own.rows)
        record.works, record.total = lanes_view(own.works, self._lanes), lanes_view(total, self._lanes)
        record.way, record.last_step, record.entry = own.way, own.last_step, own.entry
        return record

    def _make_watch(self) -> Any:
        watch, slave, device = watch_struct(self._real)(), self.model.slave, self.model.device
        watch.entry = self._own.entry
        watch.travel = wp.zeros(slave.block_count, dtype=self._real, device=device)
        watch.late = wp.zeros(slave.block_count, dtype=wp.int32, device=device)
        watch.deepest = wp.zeros(slave.block_count, dtype=self._real, device=device)
        watch.found = wp.zeros(slave.node_count, dtype=wp.int32, device=device)
        watch.foot = wp.zeros(slave.node_count, dtype=self.model.types.vec3, device=device)
        watch.stray = wp.zeros(slave.node_count, dtype=wp.int32, device=device)
        # the first update makes the boxes
        watch.drift = wp.full(1, float(FAR), dtype=self._real, device=device)
        watch.low, watch.high = (
            wp.zeros(self.facet_group_count, dtype=self.model.types.vec3, device=device) for _ in range(2)
        )
        watch.radius = wp.zeros(self.facet_group_count, dtype=self._real, device=device)
        return watch

    def _make_survey(self) -> Any:
        survey, device = survey_struct(self._real)(), self.model.device
        blocks, nodes = group_count(self.model.slave.block_count), group_count(self.model.slave.node_count)
        survey.travel, survey.deepest = (wp.zeros(blocks, dtype=self._real, device=device) for _ in range(2))
        survey.late, survey.watched = (wp.zeros(blocks, dtype=wp.int32, device=device) for _ in range(2))
        survey.stray = wp.zeros(nodes, dtype=wp.int32, device=device)
        return survey

    def _launch(self, kernel: wp.Kernel, dim: int, inputs: list, outputs: list | None = None) -> None:
        if dim:
            wp.launch(kernel, dim=dim, inputs=inputs, outputs=outputs or [], device=self.model.device)

    def _calls(self, count: int) -> int:
        """Threads of a launch on ``count`` blocks, each of which does a few."""
        return -(-count // blocks_per_call(self._lanes))

    def meet(self, first: int, count: int) -> None:
        """Contact forces on ``count`` blocks of nodes from ``first``, before anything moves."""
        raise NotImplementedError

    def plan(self) -> None:
        """How far both plies may move until the next update."""
        speeds = [self._speeds[self.model.place.slave], self._speeds[self.model.place.master]]
        self._launch(
            plan_search_kernel(self._real), 1, [self._search, self._clock, *speeds], [self._watch, *self._awake]
        )

    def seek(self, first: int, count: int) -> None:
        """What ``count`` blocks of nodes from ``first`` may touch; works of the last steps are added to their sums."""
        raise NotImplementedError

    def collect(self) -> None:
        """Nodes that have just found a foot, and whether the lists are made anew."""
        blocks, nodes = self._survey.travel.shape[0], self._survey.stray.shape[0]
        self._launch(survey_groups_kernel(self._real), blocks, [self._watch, self._own.way], [self._survey])
        self._launch(count_strays_kernel(self._real), nodes, [self._watch], [self._survey])
        self._launch(sum_up_kernel(self._real), 1, [self._search, self._watch, self._survey, *self._awake])
        self._launch(list_strays_kernel(self._real), nodes, [self._watch, self._survey])


class FacetLaunches(PassLaunches):
    """Every launch of the nodes of one sheet on the facets of another, or of their own.

    Args:
        model, state, index, squared_speeds: see ``PassLaunches``.
        normals: of every sheet, written by ``surface_normals``.
    """

    def __init__(
        self, model: PassModel, state: State, index: int, squared_speeds: list[wp.array], normals: list[wp.array]
    ) -> None:
        super().__init__(model, state, index, squared_speeds)
        slave, master = state.sheets[model.place.slave], state.sheets[model.place.master]
        self._motion = model.slave.motion_layout.view(slave.motion)
        self._corners = model.master.corners.view(master.corner_force)
        self._slaves = model.slaves(slave.motion, normals[model.place.slave])
        self._facets = model.facets(master.motion, normals[model.place.master])
        self._law, self._reaction = model.law(), self._make_reaction()
        self._listed, self._made = self._lists(self._own.listed, self._own.listed_count), self._scratch_lists()
        self.facet_block_count = model.master.element_count // self._lanes

    def _make_reaction(self) -> Any:
        reaction, own, rows = reaction_struct(self._real, self._lanes)(), self._own, self.model.rows
        reaction.listed = lanes_view(own.listed, self._lanes)
        reaction.count, reaction.standing, reaction.rows = own.block_count, own.standing, own.rows
        reaction.row_count, reaction.stride, reaction.entry = rows.row_count, rows.stride, own.entry
        return reaction

    @staticmethod
    def _lists(nodes: wp.array, count: wp.array) -> Any:
        listed = listed_struct()()
        listed.node, listed.count = nodes, count
        return listed

    def _scratch_lists(self) -> Any:
        return self._lists(wp.zeros_like(self._own.listed), wp.zeros_like(self._own.listed_count))

    # --- a step ------------------------------------------------------------------------------------------------------

    def meet(self, first: int, count: int) -> None:
        """Contact forces on ``count`` blocks of nodes from ``first``, before anything moves."""
        self._launch(
            meet_plies_kernel(self._real, self._lanes), self._calls(count),
            [first, first + count, self._slaves, self._facets, self._law, self._clock, self._motion], [self._record],
        )  # fmt: skip

    def push(self, first: int, count: int, corners: wp.array | None = None) -> None:
        """Their reactions on ``count`` blocks of facets from ``first``, after the forces of these elements.

        Args:
            first, count: range of blocks.
            corners: records that these forces are in, [row, block] of lanes; None for those of the state.
        """
        inputs, outputs = [first, first + count, self._reaction], [self._corners if corners is None else corners]
        self._launch(push_facets_kernel(self._real, self._lanes), self._calls(count), inputs, outputs)

    # --- an update of the stable step, in this order, with a barrier between ------------------------------------------

    def bound(self, first: int, count: int) -> None:
        """Boxes of ``count`` groups of facets from ``first``, where strays are sought."""
        self._launch(bound_facets_kernel(self._real), count, [first, self._facets, self._search, self._watch])

    def follow(self, found: Any, first: int, count: int) -> None:
        """Nodes of a sheet that begin or cease to follow its own facets."""
        kernel = follow_own_facets_kernel(self._real, self._lanes)
        self._launch(kernel, count, [first, self._search, found, self._record, self._watch])

    def seek(self, first: int, count: int) -> None:
        """Feet, and blocks to be watched; the works of the last steps are added to their sums."""
        self._launch(
            seek_feet_kernel(self._real, self._lanes), count,
            [first, self._facets, self._search, self._motion, self._listed],
            [self._record, self._watch, self._own.works_sum],
        )  # fmt: skip

    def list_nodes(self, first: int, count: int) -> None:
        """New lists of ``count`` blocks of facets from ``first``."""
        self._launch(
            list_nodes_kernel(self._real), count * self._lanes,
            [first * self._lanes, self._facets, self._search, self._watch, self._own.facet, self._listed],
            [self._made],
        )  # fmt: skip

    def adopt(self, facets: tuple[int, int], nodes: tuple[int, int]) -> None:
        """Take the new lists of blocks of facets, and begin the ways of blocks of nodes anew."""
        self._launch(
            adopt_lists_kernel(self._real, self._lanes), facets[1],
            [facets[0], self._search, self._watch, self._made], [self._listed, self._own.block_count],
        )  # fmt: skip
        self._launch(begin_travel_kernel(self._real, self._lanes), nodes[1], [nodes[0], self._watch, self._record])


def group_count(count: int) -> int:
    """Groups of ``count`` blocks or nodes."""
    return -(-count // int(GROUP))
