"""The kernels of a run and their launches with all arguments."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Any

import warp as wp

from ..device import block_size
from ..kernels.carried.motion import carried_motion_kernel
from ..kernels.contact.penalty import touch_struct
from ..kernels.contact.tool_distance import tool_set_struct
from ..kernels.shell.extremes import element_extremes_kernel
from ..kernels.shell.force import element_force_kernel
from ..kernels.shell.frequency import element_frequency_kernel, frequency_lane_count
from ..kernels.stepping.node import node_motion_kernel
from ..kernels.stepping.node_data import support_struct, surroundings_struct
from ..kernels.stepping.step import (
    MAXIMUM_GROUP,
    fold_works_kernel,
    group_maximum_kernel,
    partial_maximum_kernel,
    set_step_kernel,
)
from ..kernels.stepping.supports import support_motion_kernel
from ..kernels.stepping.tools import SUM_GROUP, ToolBooks, partial_sum_kernel, tool_motion_kernel
from ..tools.carried.device import carried_motion
from .layout import lanes_view
from .loading.load_launches import LoadLaunches
from .model import Model
from .plies.ply_launches import PlyLaunches
from .sheet_model import SheetModel
from .state import SheetState, State
from .surface.contact import SurfaceContact
from .surface.friction import set_friction
from .tiling.corner_ring import CornerRing
from .tiling.division import Division
from .tiling.tiles import chunks

# A single thread reduces up to this number of entries; more of them are reduced in tiles first.
LARGEST_SINGLE_REDUCTION = 8
# Threads of a GPU that share a tile.
TILE_THREAD_COUNT = 256


@dataclass(frozen=True)
class SheetKernels:
    """Kernels generated for the traits of one sheet; sheets with the same traits share them."""

    forces: wp.Kernel
    nodes: wp.Kernel
    frequencies: wp.Kernel
    extremes: wp.Kernel
    frequency_lane_count: int  # the wide kernel takes long to compile: only for cells that run faster with it

    @classmethod
    def of(cls, sheet: SheetModel) -> SheetKernels:
        """The kernels for the traits of a sheet."""
        real, lane_count = sheet.real, sheet.lane_count
        frequency_lanes = frequency_lane_count(lane_count, sheet.cell_law)
        return cls(
            forces=element_force_kernel(real, lane_count, sheet.cell_law, sheet.sheet_traits),
            nodes=node_motion_kernel(real, lane_count, sheet.node_traits),
            frequencies=element_frequency_kernel(real, frequency_lanes, sheet.cell_law, sheet.sheet_traits),
            extremes=element_extremes_kernel(real, lane_count, sheet.sheet_traits.flat),
            frequency_lane_count=frequency_lanes,
        )


@dataclass(frozen=True)
class SheetArguments:
    """Arguments of the launches of one sheet, on one state."""

    sheet: Any
    stable_sheet: Any  # for the stable step, whose kernel may have other lanes
    around: Any
    touch: Any
    motion: wp.array
    cell_unknowns: wp.array
    cell_report: wp.array
    slip: wp.array
    corner_force: wp.array
    node_work: wp.array


class Launches:
    """Every launch of a run on one state: which kernel, over which range, with which arguments.

    Args:
        model: constants.
        state: what the launches read and write.

    Attributes:
        sheet_kernels, arguments, node_laws: of every sheet; surface: of those with contact between nodes.
        tool_books: what is booked of the tools.
        squared_frequency: of the elements of every sheet, at the last refresh [1/s^2].
    """

    def __init__(self, model: Model, state: State) -> None:
        self.model, self.state = model, state
        real, device = model.real, model.device
        self.sheet_kernels = [SheetKernels.of(sheet) for sheet in model.sheets]
        self.arguments = [self._of_sheet(index) for index in range(len(model.sheets))]
        self.node_laws = [sheet.node_laws() for sheet in model.sheets]
        self.surface = {
            index: SurfaceContact(
                sheet,
                state.sheets[index],
                self._reaction(sheet)[:, sheet.block_count :],
                self._reaction(sheet, moments=True)[:, sheet.block_count :] if sheet.node_traits.carried else None,
            )  # fmt: skip
            for index, sheet in enumerate(model.sheets)
            if sheet.samples.count
        }
        self.plies = PlyLaunches(model, state)
        self._sums = self._reaction_sums()
        # sums are in double precision
        summed = wp.float64 if len(self._sums) > 1 else real
        if model.tools.carriers is None:
            self._tool_motion = tool_motion_kernel(summed, model.tools.waits)
        else:
            self._tool_motion = carried_motion_kernel(summed)
        self.tool_books = ToolBooks()
        self.tool_books.work, self.tool_books.watch = state.tool_work, state.tool_watch
        self._support_motion = support_motion_kernel(real)
        self.loads = LoadLaunches(model, state)
        self._partial_maximum = (
            partial_maximum_kernel(real) if device.is_cuda else group_maximum_kernel(real, MAXIMUM_GROUP)
        )
        self._set_step = set_step_kernel(real)
        self._fold_works = fold_works_kernel(real, model.lane_count)
        self._divided: dict[int, list[Division]] = {}
        self.squared_frequency = [wp.zeros(sheet.element_count, dtype=real, device=device) for sheet in model.sheets]
        group_counts = [-(-sheet.element_count // MAXIMUM_GROUP) for sheet in model.sheets]
        of_sheets = wp.zeros(sum(group_counts), dtype=real, device=device)
        starts = [sum(group_counts[:k]) for k in range(len(group_counts))]
        self._own_maxima = [of_sheets[a : a + n] for a, n in zip(starts, group_counts, strict=True)]
        self._maxima = [of_sheets]
        while len(self._maxima[-1]) > LARGEST_SINGLE_REDUCTION:
            group_count = -(-len(self._maxima[-1]) // MAXIMUM_GROUP)
            self._maxima.append(wp.zeros(group_count, dtype=real, device=device))

    def _reaction_sums(self) -> list[wp.array]:
        """The reactions, and sums of sums of them until few are left; on a CPU one thread takes them all."""
        arrays = [self.state.reaction]
        while (
            self.model.device.is_cuda
            and self.model.tools.count
            and (len(arrays) == 1 or arrays[-1].shape[1] > LARGEST_SINGLE_REDUCTION)
        ):
            row_count, entry_count = arrays[-1].shape
            of_groups = (row_count, -(-entry_count // SUM_GROUP))
            arrays.append(wp.zeros(of_groups, dtype=wp.vec3d, device=self.model.device))
        return arrays

    def _partial_sums_of(self, values: wp.array) -> wp.Kernel:
        """The kernel that sums the reactions, or sums of them, which are in double precision."""
        return partial_sum_kernel(self.model.real if values is self.state.reaction else wp.float64)

    @property
    def maxima(self) -> wp.array:
        """A few numbers, the largest of which is the highest squared frequency at the last refresh [1/s^2]."""
        return self._maxima[-1]

    def _surroundings(self, sheet: SheetModel, own: SheetState) -> Any:
        """What acts on the nodes of a sheet; structs within a struct are copies, and filled before."""
        state, around = self.state, surroundings_struct(sheet.real, sheet.lane_count)()
        around.clock = state.clock
        tools = tool_set_struct(sheet.real)()
        tools.part = self.model.tools.part
        tools.tool, tools.law = map(sheet.places.tools.of, (self.model.tools.tool, self.model.tools.law))
        tools.argument, tools.coefficient = self.model.tools.argument, self.model.tools.coefficient
        tools.displacement, tools.velocity = map(sheet.places.tools.of, (state.tool_displacement, state.tool_velocity))
        tools.pose = sheet.places.tools.of(state.tool_pose) if sheet.node_traits.carried else None
        around.tools = tools
        supports = support_struct(sheet.real, sheet.lane_count)()
        supports.held, supports.direction = sheet.held, sheet.drive_direction
        supports.increment, supports.holding = sheet.places.drives.of(state.drive_increment), own.holding
        around.supports = supports
        around.ply_force = lanes_view(own.contact_force, sheet.lane_count)
        return around

    def _of_sheet(self, index: int) -> SheetArguments:
        sheet, own = self.model.sheets[index], self.state.sheets[index]
        lane_count = sheet.lane_count
        touch = touch_struct(sheet.real, lane_count)()
        touch.friction = sheet.friction_layout.view(own.friction)
        touch.gap, touch.depth = own.gap, lanes_view(own.depth, lane_count)
        touch.thickness, touch.moved = lanes_view(own.thickness, lane_count), own.moved
        set_friction(touch, sheet, own.friction_argument, samples=False)
        touch.reaction = self._reaction(sheet)[:, : sheet.block_count]
        if sheet.node_traits.carried:
            touch.moment = self._reaction(sheet, moments=True)[:, : sheet.block_count]
        return SheetArguments(
            sheet=sheet.device_sheet(lane_count),
            stable_sheet=sheet.device_sheet(self.sheet_kernels[index].frequency_lane_count),
            around=self._surroundings(sheet, own),
            touch=touch,
            motion=sheet.motion_layout.view(own.motion),
            cell_unknowns=lanes_view(own.cell_unknowns, lane_count),
            cell_report=lanes_view(own.cell_report, lane_count),
            slip=lanes_view(own.slip, lane_count),
            corner_force=sheet.corners.view(own.corner_force),
            node_work=lanes_view(own.node_work, lane_count),
        )  # fmt: skip

    def _reaction(self, sheet: SheetModel, moments: bool = False) -> wp.array:
        """The entries of one sheet in the forces on its tools, or in their moments, [tool, block]."""
        rows, places = sheet.places.tools if sheet.tool_count else slice(0, 1), sheet.places
        first = self.model.tools.count if moments else 0
        of_tools = self.state.reaction[first + rows.start : first + rows.stop]
        return of_tools[:, places.first_reaction : places.last_reaction]

    def divided(self, thread_count: int) -> list[Division]:
        """A step of every sheet, divided among threads, always the same."""
        if thread_count not in self._divided:
            self._divided[thread_count] = [
                Division.of(sheet, thread_count, by_entries=k in self.surface or k in self.loads.grips)
                for k, sheet in enumerate(self.model.sheets)
            ]
        return self._divided[thread_count]

    # --- the launches of a step --------------------------------------------------------------------------------------

    def element_forces(
        self, index: int, first: int = 0, count: int | None = None, ring: CornerRing | None = None
    ) -> None:
        """Corner forces of sheet ``index``, in ``count`` blocks of elements from ``first``; with ``ring`` a tile's."""
        sheet, own, arguments = self.model.sheets[index], self.state.sheets[index], self.arguments[index]
        wp.launch(
            self.sheet_kernels[index].forces,
            dim=sheet.element_count // sheet.lane_count if count is None else count,
            inputs=[first, arguments.sheet, own.motion, self.state.clock],
            outputs=[
                arguments.cell_unknowns, arguments.cell_report, arguments.slip,
                arguments.corner_force if ring is None else ring.at(first),
            ],
            device=sheet.device,
            block_dim=block_size(self.sheet_kernels[index].forces, sheet.device),
        )  # fmt: skip

    def meet_between_nodes(self, index: int, first: int = 0, count: int | None = None) -> None:
        """Meet the tools between the nodes of sheet ``index``, in ``count`` blocks of elements from ``first``.

        Nothing where only nodes meet tools; else after ``element_forces`` of these, and before their nodes move.
        """
        if index in self.surface:
            arguments = self.arguments[index]
            self.surface[index].launch(first, count, arguments.around)

    def move_nodes(self, index: int, first: int = 0, count: int | None = None, ring: CornerRing | None = None) -> None:
        """Gather, meet the tools, and move the nodes of sheet ``index``, in ``count`` blocks from ``first``."""
        sheet, own, arguments = self.model.sheets[index], self.state.sheets[index], self.arguments[index]
        nodes, corner_force = (sheet.nodes, own.corner_force) if ring is None else (ring.nodes, ring.records)
        wp.launch(
            self.sheet_kernels[index].nodes,
            dim=sheet.block_count if count is None else count,
            inputs=[first, nodes, self.node_laws[index], arguments.around, corner_force],
            outputs=[arguments.motion, arguments.touch, arguments.node_work],
            device=sheet.device,
            block_dim=block_size(self.sheet_kernels[index].nodes, sheet.device),
        )

    def move_supports(self) -> None:
        """Displacement of every drive in the next step."""
        drives = self.model.drives
        if drives.count:
            wp.launch(
                self._support_motion,
                dim=1,
                inputs=[drives.first_piece, drives.start, drives.piece, self.state.clock],
                outputs=[self.state.drive_displacement, self.state.drive_increment],
                device=self.model.device,
            )

    def move_tools(self) -> None:
        """Sum the reactions, move every tool, and advance the clock."""
        tools, state, device = self.model.tools, self.state, self.model.device
        for values, sums in itertools.pairwise(self._sums):
            wp.launch_tiled(
                self._partial_sums_of(values), dim=sums.shape, block_dim=TILE_THREAD_COUNT, inputs=[values],
                outputs=[sums], device=device,
            )  # fmt: skip
        inputs, moved = [tools.drives], [state.tool_displacement, state.tool_velocity]
        if tools.carriers is not None:
            inputs, moved = [*inputs, tools.carriers], [carried_motion(state)]
        wp.launch(
            self._tool_motion,
            dim=tools.drives.thread_count,
            inputs=[*inputs, self._sums[-1]],
            outputs=[state.clock, *moved, state.tool_force, state.tool_drive, self.tool_books],
            device=device,
        )

    # --- the stable step ---------------------------------------------------------------------------------------------

    def frequency_block_count(self, index: int) -> int:
        """Blocks of elements of ``element_frequencies``."""
        return self.model.sheets[index].element_count // self.sheet_kernels[index].frequency_lane_count

    def element_frequencies(self, index: int, first: int, count: int) -> None:
        """Bounds of the highest frequencies of sheet ``index``, in ``count`` blocks of elements from ``first``."""
        sheet, own = self.model.sheets[index], self.state.sheets[index]
        lane_count = self.sheet_kernels[index].frequency_lane_count
        wp.launch(
            self.sheet_kernels[index].frequencies,
            dim=count,
            inputs=[
                first, self.arguments[index].stable_sheet, sheet.step_bounds, own.motion,
                lanes_view(own.cell_unknowns, lane_count), lanes_view(sheet.step_inertia, lane_count), self.state.clock,
            ],
            outputs=[lanes_view(self.squared_frequency[index], lane_count)],
            device=sheet.device,
        )  # fmt: skip

    def fold_works(self, index: int, thread: int = 0, thread_count: int = 1) -> None:
        """Add the works of the last steps of sheet ``index`` to their sums: the share of one thread."""
        own, arguments = self.state.sheets[index], self.arguments[index]
        folded = [(arguments.node_work, own.node_work_sum)]
        if index in self.surface:
            folded.append((self.surface[index].works, own.sample_work_sum))
        for works, sums in folded:
            first, count = chunks(sums.shape[1], thread_count)[thread]
            wp.launch(self._fold_works, dim=count, inputs=[first], outputs=[works, sums], device=self.model.device)

    def element_extremes(self, index: int, first: int, count: int) -> None:
        """Extremes so far of sheet ``index``, in ``count`` blocks of elements from ``first``."""
        sheet, own = self.model.sheets[index], self.state.sheets[index]
        wp.launch(
            self.sheet_kernels[index].extremes,
            dim=count,
            inputs=[first, sheet.elements, own.motion],
            outputs=[lanes_view(own.extremes, sheet.lane_count)],
            device=sheet.device,
        )

    def set_step(self, safety: float, largest_step: float) -> None:
        """The next step, from the highest frequency of all sheets."""
        of_sheets = zip(self.squared_frequency, self._own_maxima, strict=True)
        for values, maxima in [*of_sheets, *itertools.pairwise(self._maxima)]:
            self._take_maxima(values, maxima)
        wp.launch(
            self._set_step,
            dim=1,
            inputs=[self.maxima, safety, largest_step],
            outputs=[self.state.clock],
            device=self.model.device,
        )

    def _take_maxima(self, values: wp.array, maxima: wp.array) -> None:
        """Largest of each group of ``values``, in tiles on a GPU."""
        device = self.model.device
        tiled: dict[str, Any] = {"block_dim": TILE_THREAD_COUNT} if device.is_cuda else {}
        launch = wp.launch_tiled if device.is_cuda else wp.launch
        launch(self._partial_maximum, dim=[len(maxima)], inputs=[values], outputs=[maxima], device=device, **tiled)

    # --- the rest ----------------------------------------------------------------------------------------------------

    def set_damping(self, rate: float | None) -> None:
        """Set one rate [1/s] for all nodes and directors, from the next recording on; None uses ``Dynamics``."""
        self.node_laws = [sheet.node_laws() for sheet in self.model.sheets]
        if rate is not None:
            for laws in self.node_laws:
                laws.damping = laws.director_damping = rate

    @property
    def kernels(self) -> list[wp.Kernel]:
        """All kernels launched here, each once."""
        own = [
            kernel
            for kernels in self.sheet_kernels
            for kernel in (kernels.forces, kernels.nodes, kernels.frequencies, kernels.extremes)
        ]
        own += [surface.kernel for surface in self.surface.values()]
        common = [self._tool_motion, self._partial_maximum, self._set_step, self._fold_works]
        common += [self._partial_sums_of(values) for values in self._sums[:-1]]
        if self.model.drives.count:
            common.append(self._support_motion)
        return list(dict.fromkeys([*own, *common, *self.loads.kernels, *self.plies.kernels]))
