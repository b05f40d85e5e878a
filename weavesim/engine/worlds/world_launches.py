"""Launches that step many worlds of one sheet each at once: each kernel with all its arguments."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from copy import copy
from typing import Any

import numpy as np
import warp as wp

from ...device import block_size
from ...kernels.rows import ClockEntry
from ...kernels.stepping.step import MAXIMUM_GROUP
from ...kernels.stepping.tools import SUM_GROUP
from ...kernels.worlds.arguments import (
    ToolArguments,
    drive_arguments,
    force_arguments,
    frequency_arguments,
    grip_arguments,
    node_arguments,
    record_arguments,
    sample_arguments,
)
from ...kernels.worlds.clocks import check_worlds
from ...tools.device import build_device_tools
from ..launches import TILE_THREAD_COUNT, Launches
from ..layout import lanes_view
from ..model import Model, arrays_in, sampled_meshes
from ..state import State
from ..stepper import LARGEST_INTERVAL
from .mirror import Mirror
from .world_kernels import WorldKernelSet


class WorldLaunches:
    """Every launch of a step of many worlds, on copies of their memory on one device.

    Args:
        device: that computes; its copies have the layout of the models.
        models, states: of runs that are alike (see alike.py), on the host.
        safety: share of the stable step that each run uses.
        largest_step: of each run [s].

    Attributes:
        mirror: of the memory of all runs.
        running: whether each world is stepped, (worlds,) int32.
        running_count: how many are, (1,) int32.
        target: time at which each stops [s], (worlds,) float64.
        block_count: blocks that each has done since this was set to zero, (worlds,) int32.
        clocks: of all worlds, rows ClockEntry, (worlds, rows) float64.
    """

    def __init__(
        self,
        device: wp.Device,
        models: Sequence[Model],
        states: Sequence[State],
        safety: Sequence[float],
        largest_step: Sequence[float],
    ) -> None:
        self._device, self._model = device, models[0]
        self._kernels = WorldKernelSet.of(models[0].setup, str(device))
        count = len(models)
        # keeps what they refer to on the device
        self._models = [_with_tools_on(device, model) for model in models]
        own = [Launches(model, state) for model, state in zip(self._models, states, strict=True)]
        written = [[*(array for _, array in each.state.arrays()), *each.squared_frequency] for each in own]
        structs = [_structs(each) for each in own]
        constant = [[*each.model.arrays(), *_arrays_of(given)] for each, given in zip(own, structs, strict=True)]
        self.mirror = Mirror(device, written, constant)
        self._arguments = {name: self.mirror.structs([given[name] for given in structs]) for name in structs[0]}
        sheet = self._model.sheet
        real, tool_count = sheet.real, self._model.tools.count
        self.clocks = self.mirror.rows([state.clock for state in states], wp.float64, (ClockEntry.row_count(),))
        self._frequencies = self.mirror.rows([each.squared_frequency[0] for each in own], real, (sheet.element_count,))
        group_count = -(-sheet.element_count // MAXIMUM_GROUP)
        self._maxima = wp.zeros((count, group_count), dtype=real, device=device)
        self._sums = self._reaction_sums([state.reaction for state in states]) if tool_count else []
        self._no_reactions = wp.zeros((0, 0), dtype=self._model.types.vec3, device=device)
        self._safety: wp.array = wp.array(np.array(safety), dtype=wp.float64, device=device)
        self._largest_step: wp.array = wp.array(np.array(largest_step), dtype=wp.float64, device=device)
        self.target = wp.zeros(count, dtype=wp.float64, device=device)
        self.running = wp.ones(count, dtype=wp.int32, device=device)
        self.block_count = wp.zeros(count, dtype=wp.int32, device=device)
        self.running_count = wp.zeros(1, dtype=wp.int32, device=device)

    def _reaction_sums(self, reactions: Sequence[wp.array]) -> list[wp.array]:
        """The reactions of all worlds, one row for each tool, and on a GPU sums of groups of them."""
        model, count = self._model, self.mirror.world_count
        rows = self.mirror.rows(reactions, model.types.vec3, (model.tools.count * model.reaction_count,))
        # rows of a world follow those of the one before: whole blocks of entries need no padding
        values = rows.reshape((count * model.tools.count, model.reaction_count))
        if self._kernels.partial_sums is None:
            return [values]
        shape = (values.shape[0], -(-values.shape[1] // SUM_GROUP))
        return [values, wp.zeros(shape, dtype=wp.vec3d, device=self._device)]

    # --- launches ----------------------------------------------------------------------------------------------------

    def _of_blocks(self, kernel: wp.Kernel, name: str, block_count: int) -> None:
        wp.launch(
            kernel,
            dim=self.mirror.world_count * block_count,
            inputs=[block_count, self.running, self._arguments[name]],
            device=self._device,
            block_dim=block_size(kernel, self._device),
        )

    @property
    def _element_blocks(self) -> int:
        return self._model.sheet.element_count // self._model.lane_count

    def element_forces(self) -> None:
        """Corner forces of all elements."""
        self._of_blocks(self._kernels.forces, "forces", self._element_blocks)

    def pull(self) -> None:
        """Add the springs of grippers to the corner forces."""
        if kernel := self._kernels.grips:
            self._of_blocks(kernel, "grips", sum(len(gripper.nodes) for gripper in self._model.sheet.grippers))

    def meet_between_nodes(self) -> None:
        """Contact of the tools between the nodes."""
        if kernel := self._kernels.samples:
            self._of_blocks(kernel, "samples", self._element_blocks)

    def move_nodes(self) -> None:
        """Motion of all nodes."""
        self._of_blocks(self._kernels.nodes, "nodes", self._model.sheet.block_count)

    def move_supports(self) -> None:
        """Displacement of every drive in the next step."""
        if kernel := self._kernels.drives:
            inputs = [self.running, self._arguments["drives"]]
            wp.launch(kernel, dim=self.mirror.world_count, inputs=inputs, device=self._device)

    def move_tools(self) -> None:
        """Sum the reactions, move every tool, and advance the clocks."""
        if len(self._sums) > 1:
            values, sums = self._sums
            wp.launch_tiled(
                self._kernels.partial_sums,
                dim=sums.shape,
                block_dim=TILE_THREAD_COUNT,
                inputs=[values],
                outputs=[sums],
                device=self._device,
            )
        reactions = self._sums[-1] if self._sums else self._no_reactions
        inputs = [self.running, reactions, self._arguments["tools"]]
        wp.launch(self._kernels.tools, dim=self.mirror.world_count, inputs=inputs, device=self._device)

    def refresh(self, beside: Any, join: Any) -> None:
        """Extremes, works and the next step; ``beside`` and ``join`` as those of ``Replay``."""
        with beside():
            self._of_blocks(self._kernels.extremes, "records", self._element_blocks)
            self._of_blocks(self._kernels.works, "records", self._model.sheet.block_count)
            if self._kernels.samples:
                sheet = self._model.sheet
                self._of_blocks(self._kernels.works, "works of samples", sheet.samples.count // sheet.lane_count)
        self._of_blocks(self._kernels.frequencies, "frequencies", self._element_blocks)
        tiled: dict[str, Any] = {"block_dim": TILE_THREAD_COUNT} if self._device.is_cuda else {}
        launch = wp.launch_tiled if self._device.is_cuda else wp.launch
        launch(
            self._kernels.maxima, dim=self._maxima.shape, inputs=[self._frequencies], outputs=[self._maxima],
            device=self._device, **tiled,
        )  # fmt: skip
        wp.launch(
            self._kernels.steps,
            dim=self.mirror.world_count,
            inputs=[self.running, self._maxima, self._safety, self._largest_step, self.clocks],
            device=self._device,
        )
        join()

    def check(self, done: int) -> None:
        """After ``done`` more blocks: which worlds go on."""
        self.running_count.zero_()
        wp.launch(
            check_worlds,
            dim=self.mirror.world_count,
            inputs=[done, LARGEST_INTERVAL, self.target, self.clocks],
            outputs=[self.block_count, self.running, self.running_count],
            device=self._device,
        )


def _with_tools_on(device: wp.Device, model: Model) -> Model:
    """A model whose tools refer to samples of their meshes on ``device``; its arrays stay where they are."""
    if not model.samples:
        return model
    samples = sampled_meshes(model.setup, str(device))
    result = copy(model)
    result.tools = build_device_tools(
        model.setup.tools, model.real, str(model.device), samples, model.contact_stiffness()
    )
    return result


def _structs(own: Launches) -> dict[str, Any]:
    """Arguments of one run, on the host, by the launches that take them."""
    model, state, sheet = own.model, own.state, own.model.sheet
    arguments, (of_sheet,) = own.arguments[0], own.state.sheets
    layout = (sheet.real, sheet.lane_count)
    forces = force_arguments(*layout, sheet.cell_law, sheet.sheet_traits)()
    forces.sheet, forces.motion, forces.clock = arguments.sheet, of_sheet.motion, state.clock
    for name in ("cell_unknowns", "cell_report", "slip", "corner_force"):
        setattr(forces, name, getattr(arguments, name))
    nodes = node_arguments(*layout)()
    nodes.nodes, nodes.laws, nodes.around = sheet.nodes, own.node_laws[0], arguments.around
    nodes.corners, nodes.motion = of_sheet.corner_force, arguments.motion
    nodes.touch, nodes.works = arguments.touch, arguments.node_work
    frequencies = frequency_arguments(*layout, sheet.cell_law, sheet.sheet_traits)()
    frequencies.sheet, frequencies.bounds = arguments.stable_sheet, sheet.step_bounds
    frequencies.motion, frequencies.clock = of_sheet.motion, state.clock
    frequencies.cell_unknowns = lanes_view(of_sheet.cell_unknowns, sheet.lane_count)
    frequencies.inertia = lanes_view(sheet.step_inertia, sheet.lane_count)
    frequencies.squared_frequency = lanes_view(own.squared_frequency[0], sheet.lane_count)
    records = record_arguments(*layout)()
    records.elements, records.motion = sheet.elements, of_sheet.motion
    records.extremes = lanes_view(of_sheet.extremes, sheet.lane_count)
    records.works, records.sums = arguments.node_work, of_sheet.node_work_sum
    tools = ToolArguments()
    tools.drives, tools.clock, tools.books = model.tools.drives, state.clock, own.tool_books
    tools.displacement, tools.velocity = state.tool_displacement, state.tool_velocity
    tools.force, tools.kept = state.tool_force, state.tool_drive
    given = {"forces": forces, "nodes": nodes, "frequencies": frequencies, "records": records, "tools": tools}
    if model.drives.count:
        drives = drive_arguments(sheet.real)()
        drives.first_piece, drives.start, drives.piece = (
            model.drives.first_piece,
            model.drives.start,
            model.drives.piece,
        )
        drives.displacement, drives.increment = state.drive_displacement, state.drive_increment
        drives.clock = state.clock
        given["drives"] = drives
    if between := own.surface.get(0):
        samples = sample_arguments(*layout)()
        samples.samples, samples.laws, samples.sampled = between.samples, between.laws, between.sampled
        samples.around, samples.moved, samples.motion = arguments.around, of_sheet.moved, of_sheet.motion
        samples.corner_force = of_sheet.corner_force
        given["samples"] = samples
        folded = record_arguments(*layout)()
        folded.elements, folded.motion, folded.extremes = records.elements, records.motion, records.extremes
        folded.works, folded.sums = between.works, of_sheet.sample_work_sum
        given["works of samples"] = folded
    if sheet.grippers:
        grips = grip_arguments(sheet.real)()
        grips.grips, grips.motion, grips.clock = own.loads.grips[0].grips, of_sheet.motion, state.clock
        grips.corner_force, grips.kept = of_sheet.corner_force, of_sheet.grip
        given["grips"] = grips
    return given


def _arrays_of(given: dict[str, Any]) -> Iterator[wp.array]:
    for struct in given.values():
        yield from arrays_in(struct)
