"""One time step as a sequence of launches, recorded once and replayed: per thread on a CPU, as a graph on a GPU.

A step is: supports look up how far they go; elements write the forces of their corners; nodes gather the forces, meet
the tools and move, on a CPU tile by tile behind the elements; tools move and the clock advances. Every
``REFRESH_INTERVAL`` steps the stable step is taken anew from the current tangents.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import fields, is_dataclass, replace
from functools import partial

import numpy as np
import warp as wp

from ..device import load_kernel
from ..kernels.contact.penalty import touch_struct
from ..kernels.contact.tool_distance import tool_set_struct
from ..kernels.rows import ROWS_PER_CORNER, ClockEntry, CornerRow
from ..kernels.shell.force import element_force_kernel
from ..kernels.shell.frequency import element_frequency_kernel, frequency_lane_count
from ..kernels.stepping.machine import barrier, flush_subnormals, restore_subnormals
from ..kernels.stepping.node import node_motion_kernel
from ..kernels.stepping.node_data import NodeTraits
from ..kernels.stepping.step import STEP_GROWTH, look_at_clock, partial_maximum_kernel, set_step_kernel
from ..kernels.stepping.supports import support_motion_kernel
from ..kernels.stepping.tools import partial_sum_kernel, tool_motion_kernel
from ..process.device import DeviceSupports
from ..tools.device import DeviceTools
from .compilation import KernelSet, compile_missing
from .layout import lanes_view
from .model import Model
from .setup import STEP_SAFETY
from .state import Ahead, State
from .threads import ThreadChoice
from .tiles import TILE_SIZE, Part, chunks, divide_step

REFRESH_INTERVAL = 20
# Reductions over more entries than this take two launches.
LARGEST_SINGLE_SUM = 4096
GROUP_SIZE = 256
# A thread with more tiles records one step instead of a block of them: a launch takes about 70 us to record.
LARGEST_RECORDED_TILE_COUNT = 8
# At most this many blocks are done before the host looks at the clock, and on a GPU that looks by itself.
LARGEST_REPLAY = 50
LARGEST_INTERVAL = 10_000


def safe_block_count(remaining: float, step: float) -> int:
    """Blocks of which none but the last can reach a time ``remaining`` seconds away, however the step grows."""
    growth = float(STEP_GROWTH) - 1.0
    return max(1, int(math.log1p(growth * remaining / (REFRESH_INTERVAL * step)) / math.log1p(growth)))


class Stepper:
    """Advances a state in blocks of ``REFRESH_INTERVAL`` steps.

    Args:
        model: constants.
        state: what is advanced.
        tools: rigid tools on the same device.
        supports: held nodes, on the same device.
        thread_counts: numbers of CPU threads, ascending, of which the fastest is taken as the run goes; results do not
            depend on it, to the last bit.
        largest_step: upper limit of the time step [s].
        step_safety: share of the stable step 2/omega that is taken.

    Attributes:
        step_count: steps done so far.
        loading_time: of the kernels, with the compilation of those that were not cached [s].
    """

    def __init__(
        self,
        model: Model,
        state: State,
        tools: DeviceTools,
        supports: DeviceSupports,
        *,
        thread_counts: Sequence[int] = (1,),
        largest_step: float = np.inf,
        step_safety: float = STEP_SAFETY,
    ) -> None:
        self.model, self.state, self.tools, self.supports = model, state, tools, supports
        self._choice = ThreadChoice(thread_counts if model.device.is_cpu else (1,))
        self.largest_step, self.step_safety = largest_step, step_safety
        real, lane_count, device = model.real, model.lane_count, model.device
        self._element_forces = element_force_kernel(real, lane_count, model.cell_law, model.sheet_traits)
        self.node_traits = NodeTraits(
            follows_thickness=model.follows_thickness,
            loaded=model.loads is not None,
            supported=supports.struct.held.shape[0] > 0,
            shape_kinds=tools.shape_kinds,
            rotated=tools.rotated,
        )
        self._node_motion = node_motion_kernel(real, lane_count, self.node_traits)
        self._tool_motion = tool_motion_kernel(real)
        self._support_motion = support_motion_kernel(real)
        self._partial_sums = partial_sum_kernel(real)
        # the wide kernel takes long to compile: only for cells that run faster in it
        self._frequency_lane_count = frequency_lane_count(lane_count, model.cell_law)
        model.step_bounds.steps_ahead = REFRESH_INTERVAL
        self._frequencies = element_frequency_kernel(
            real, self._frequency_lane_count, model.cell_law, model.sheet_traits
        )
        self._partial_maximum = partial_maximum_kernel(real)
        self._set_step = set_step_kernel(real)
        self._tool_set = tool_set_struct(real)()
        self._tool_set.tool, self._tool_set.part = tools.tool, tools.part
        self._tool_set.displacement, self._tool_set.velocity = tools.displacement, tools.velocity
        self._squared_frequency = wp.zeros(model.element_count, dtype=real, device=device)
        self._maxima = wp.zeros(-(-model.element_count // GROUP_SIZE), dtype=real, device=device)
        self._counter = wp.zeros(1, dtype=wp.int32, device=device)
        self._sums = state.reaction
        if state.reaction.shape[1] > LARGEST_SINGLE_SUM:
            group_count = -(-state.reaction.shape[1] // GROUP_SIZE)
            self._sums = wp.zeros((state.reaction.shape[0], group_count), dtype=model.types.vec3, device=device)
        # a GPU may do all blocks of an interval in one launch
        self.launches_intervals = model.device.is_cuda and wp.is_conditional_graph_supported()
        self._target = wp.zeros(1, dtype=wp.float64, device=device)
        self._running = wp.zeros(1, dtype=wp.int32, device=device)
        self._block_count = wp.zeros(1, dtype=wp.int32, device=device)
        # recorded when first wanted: for each number of threads a list of graphs per thread
        self._block_graphs: dict[int, list[list[wp.Graph]]] = {}
        self._interval_graph: wp.Graph | None = None
        # how each thread treated subnormal numbers before a replay
        self._modes = wp.zeros(self._choice.counts[-1], dtype=wp.int32, device=device)
        self._load_modules()
        self.step_count = 0
        self.refresh_step()
        # velocities live at half steps, the initial ones at time zero: the first change is that of half a step
        clock = state.clock.numpy()
        clock[ClockEntry.mean_step] = 0.5 * clock[ClockEntry.step]
        state.clock.assign(clock)
        self._ahead: tuple[State, DeviceTools, wp.array] | None = None
        self._ahead_graph: wp.Graph | None = None

    # --- the launches of one thread ----------------------------------------------------------------------------------

    def evaluate(self, first: int = 0, count: int | None = None, state: State | None = None) -> None:
        """Element forces of the current state (or of a copy), in the blocks of lanes from ``first``."""
        model, state = self.model, state or self.state
        count = model.element_count // model.lane_count if count is None else count
        own = (state.cell_unknowns, state.cell_report, state.slip)
        wp.launch(
            self._element_forces,
            dim=count,
            inputs=[first, model.elements, model.cell, model.laws, state.motion],
            outputs=[
                *(lanes_view(array, model.lane_count) for array in own),
                model.corners.view(state.corner_force),
            ],
            device=model.device,
        )

    def _advance_nodes(self, first: int, count: int, state: State | None = None) -> None:
        model, state = self.model, state or self.state
        wp.launch(
            self._node_motion,
            dim=count,
            inputs=[
                first, model.nodes, model.motion_laws, self._tool_set, self.supports.struct, state.clock,
                state.corner_force,
            ],
            outputs=[
                model.motion_layout.view(state.motion), self._touching(state),
                lanes_view(state.node_report, model.lane_count),
            ],
            device=model.device,
        )  # fmt: skip

    def _touching(self, state: State):
        """What the nodes keep of the tools, as their kernel takes it."""
        touch = touch_struct(self.model.real, self.model.lane_count)()
        touch.friction = self.model.friction_layout.view(state.friction)
        touch.gap, touch.reaction = state.gap, state.reaction
        return touch

    def _advance_supports(self, clock: wp.array | None = None, displacement: wp.array | None = None) -> None:
        supports = self.supports
        if supports.drive_count:
            wp.launch(
                self._support_motion,
                dim=1,
                inputs=[
                    supports.first_piece,
                    supports.start,
                    supports.piece,
                    self.state.clock if clock is None else clock,
                ],
                outputs=[supports.displacement if displacement is None else displacement, supports.struct.increment],
                device=self.model.device,
            )

    def _advance_tools(self, state: State | None = None, tools: DeviceTools | None = None) -> None:
        model, state, tools = self.model, state or self.state, tools or self.tools
        sums = self._sums if self._sums is not self.state.reaction else state.reaction
        if sums is not state.reaction:
            wp.launch(
                self._partial_sums,
                dim=sums.shape,
                inputs=[GROUP_SIZE, state.reaction],
                outputs=[sums],
                device=model.device,
            )
        wp.launch(
            self._tool_motion,
            dim=1,
            inputs=[tools.drive, tools.axis, tools.curve_times, tools.curve_values, sums],
            outputs=[state.clock, tools.displacement, tools.velocity, tools.total_reaction, tools.work],
            device=model.device,
        )

    def _refresh_frequencies(self, first: int, count: int) -> None:
        model, state, lane_count = self.model, self.state, self._frequency_lane_count
        elements = model.elements_single if lane_count == 1 else model.elements
        wp.launch(
            self._frequencies,
            dim=count,
            inputs=[
                first, elements, model.cell, model.laws, model.step_bounds, state.motion,
                lanes_view(state.cell_unknowns, lane_count), lanes_view(model.step_inertia, lane_count), state.clock,
            ],
            outputs=[lanes_view(self._squared_frequency, lane_count)],
            device=model.device,
        )  # fmt: skip

    def _refresh_step(self) -> None:
        wp.launch(
            self._partial_maximum,
            dim=self._maxima.shape[0],
            inputs=[GROUP_SIZE, lanes_view(self._squared_frequency, 1)],
            outputs=[self._maxima],
            device=self.model.device,
        )
        wp.launch(
            self._set_step,
            dim=1,
            inputs=[self._maxima, self.step_safety, self.largest_step],
            outputs=[self.state.clock],
            device=self.model.device,
        )

    # --- recording and replay ----------------------------------------------------------------------------------------

    def _wait(self, thread_count: int) -> None:
        if thread_count > 1:
            wp.launch(barrier, dim=1, inputs=[self._counter, thread_count], device=self.model.device)

    def _refresh(self, thread_count: int, thread: int) -> None:
        self._refresh_frequencies(*chunks(self.model.element_count // self._frequency_lane_count, thread_count)[thread])
        self._wait(thread_count)
        if thread == 0:
            self._refresh_step()
        self._wait(thread_count)

    def _step(self, parts: Sequence[Part], thread: int) -> None:
        part, wait = parts[thread], partial(self._wait, len(parts))
        if self.supports.drive_count:
            if thread == 0:
                self._advance_supports()
            wait()
        for elements, nodes in part.tiles:
            self.evaluate(*elements)
            if nodes[1]:
                self._advance_nodes(*nodes)
        wait()
        for nodes in part.shared:
            self._advance_nodes(*nodes)
        wait()
        if thread == 0:
            self._advance_tools()
        wait()

    def _block(self, parts: Sequence[Part], thread: int) -> None:
        for _ in range(REFRESH_INTERVAL):
            self._step(parts, thread)
        self._refresh(len(parts), thread)

    def _look_at_clock(self, done: int) -> None:
        wp.launch(
            look_at_clock,
            dim=1,
            inputs=[done, LARGEST_INTERVAL, self._target, self.state.clock],
            outputs=[self._block_count, self._running],
            device=self.model.device,
        )

    def _interval(self) -> None:
        """All blocks up to ``_target``, for a GPU to do without the host."""
        parts = self._parts(1)

        def body() -> None:
            self._block(parts, 0)
            self._look_at_clock(1)

        self._look_at_clock(0)
        wp.capture_while(self._running, body)

    @property
    def kernels(self) -> list[wp.Kernel]:
        """All that is launched."""
        kernels = [
            self._element_forces, self._node_motion, self._tool_motion, self._partial_sums, self._frequencies,
            self._partial_maximum, self._set_step,
        ]  # fmt: skip
        if self.supports.drive_count:
            kernels.append(self._support_motion)
        if self.model.device.is_cpu:
            kernels += [flush_subnormals, restore_subnormals]
        if self._choice.counts[-1] > 1:
            kernels.append(barrier)
        if self.launches_intervals:
            kernels.append(look_at_clock)
        return kernels

    @property
    def kernel_set(self) -> KernelSet:
        """What decides the kernels of this run, its ledger's included."""
        model = self.model
        return KernelSet(
            model.fabric.unit_cell, (model.sheet_traits,), (self.node_traits,), model.precision, str(model.device),
            model.lane_count, tools=self.tools.count > 0, driven=self.supports.drive_count > 0,
            threaded=self._choice.counts[-1] > 1,
        )  # fmt: skip

    def _load_modules(self) -> None:
        """Compile what is not cached, before anything is recorded."""
        started = time.perf_counter()
        compile_missing(self.kernel_set)
        for kernel in self.kernels:
            load_kernel(kernel, self.model.device)
        self.loading_time = time.perf_counter() - started

    def _parts(self, thread_count: int) -> list[Part]:
        # a GPU runs whole launches, not tiles
        tile_size = TILE_SIZE if self.model.device.is_cpu else self.model.element_count
        return divide_step(self.model.element_nodes, self.model.lane_count, thread_count, tile_size)

    def _record(self, launch: Callable[[], None], thread: int = 0) -> wp.Graph:
        flushes = self.model.device.is_cpu
        before = self._modes[thread : thread + 1]
        wp.capture_begin(device=self.model.device)
        try:
            if flushes:
                wp.launch(flush_subnormals, dim=1, outputs=[before], device=self.model.device)
            launch()
            if flushes:
                wp.launch(restore_subnormals, dim=1, inputs=[before], device=self.model.device)
        finally:
            graph = wp.capture_end(device=self.model.device)
        return graph

    def _recorded_blocks(self, thread_count: int) -> list[list[wp.Graph]]:
        """For each thread the graphs that make a block."""
        if thread_count not in self._block_graphs:
            parts = self._parts(thread_count)
            if max(len(part.tiles) for part in parts) > LARGEST_RECORDED_TILE_COUNT:
                graphs = [
                    [self._record(partial(self._step, parts, thread), thread)] * REFRESH_INTERVAL
                    + [self._record(partial(self._refresh, thread_count, thread), thread)]
                    for thread in range(thread_count)
                ]
            else:
                graphs = [[self._record(partial(self._block, parts, thread), thread)] for thread in range(thread_count)]
            self._block_graphs[thread_count] = graphs
        return self._block_graphs[thread_count]

    def _replay(self, graphs: Sequence[Sequence[wp.Graph]], times: int) -> None:
        """Launch each thread's graphs one after the other, ``times`` over."""

        def replay(own: Sequence[wp.Graph]) -> None:
            for _ in range(times):
                for graph in own:
                    wp.capture_launch(graph)

        if len(graphs) > 1:
            self._counter.zero_()
        others = [threading.Thread(target=replay, args=(own,)) for own in graphs[1:]]
        for thread in others:
            thread.start()
        replay(graphs[0])
        for thread in others:
            thread.join()

    def _take_turn(self, largest_block_count: int) -> int:
        """Do blocks on as many threads as are fastest, until it is time to think about that again; how many."""
        graphs = self._recorded_blocks(self._choice.count)
        block_count = min(largest_block_count, self._choice.block_count())
        started = time.perf_counter()
        self._replay(graphs, block_count)
        self._choice.report(block_count, time.perf_counter() - started)
        self.step_count += block_count * REFRESH_INTERVAL
        return block_count

    def _launch_interval(self, target: float) -> None:
        if self._interval_graph is None:
            self._interval_graph = self._record(self._interval)
        self._target.fill_(target)
        self._block_count.zero_()
        wp.capture_launch(self._interval_graph)
        self.step_count += int(self._block_count.numpy()[0]) * REFRESH_INTERVAL

    # --- what others use ---------------------------------------------------------------------------------------------

    @property
    def thread_count(self) -> int:
        """The number of threads that most steps were done on."""
        return self._choice.most_used

    def refresh_step(self) -> None:
        """Take the stable step from the present state."""
        self._refresh(1, 0)

    def look_ahead(self) -> Ahead:
        """The next step, done on a copy: the state stays as it is. Support forces become those of the present."""
        if self._ahead is None:
            names = ("motion", "node_report", "cell_unknowns", "cell_report", "slip")
            names += ("friction", "gap", "reaction", "clock")
            state = replace(self.state, **{name: wp.clone(getattr(self.state, name)) for name in names})
            names = ("displacement", "velocity", "total_reaction", "work")
            tools = replace(self.tools, **{name: wp.clone(getattr(self.tools, name)) for name in names})
            self._ahead = state, tools, wp.clone(self.supports.displacement)
        if self._ahead_graph is None:
            self._ahead_graph = self._record(self._step_ahead)
        wp.capture_launch(self._ahead_graph)
        state, tools, _ = self._ahead
        return Ahead(
            state.motion, state.node_report, state.cell_unknowns, state.cell_report, state.slip, state.friction,
            tools.velocity, tools.work,
        )  # fmt: skip

    def _step_ahead(self, phase_count: int = 3) -> None:
        """Copy what a step changes, and do the step there, or its first phases."""
        state, tools, drive_displacement = self._ahead
        for source, target in ((self.state, state), (self.tools, tools)):
            for field in fields(source):
                here, there = getattr(source, field.name), getattr(target, field.name)
                if here is not there:
                    wp.copy(there, here)
        wp.copy(drive_displacement, self.supports.displacement)
        if phase_count > 0:
            self.evaluate(state=state)
        if phase_count > 1:
            self._advance_supports(state.clock, drive_displacement)
            self._advance_nodes(0, self.model.node_count // self.model.lane_count, state)
        if phase_count > 2:
            self._advance_tools(state, tools)

    def set_damping(self, damping: float, director_damping: float) -> None:
        """Change the rates of ``Dynamics`` from the next step on [1/s]."""
        self.model.motion_laws.damping = damping
        self.model.motion_laws.director_damping = director_damping
        self._block_graphs.clear()
        self._interval_graph = self._ahead_graph = None

    def corner_rows(self) -> np.ndarray:
        """What the elements wrote at the last evaluation, (corner, row of CornerRow, element); waits for the device."""
        rows = self.model.corners.read(self.state.corner_force)[:, : self.model.blank.element_count]
        return rows.reshape(4, ROWS_PER_CORNER, -1)

    def nodal_forces(self) -> np.ndarray:
        """Forces of the elements on the nodes at the last evaluation, (node_count, 3) [N]; waits for the device."""
        blank = self.model.blank
        corners = self.corner_rows()[:, CornerRow.force.span].astype(np.float64)
        result = np.zeros((blank.node_count, 3))
        for corner in range(4):
            np.add.at(result, blank.quads[:, corner], corners[corner].T)
        return result

    def stable_step(self) -> float:
        """Stable step of the present state, safety included [s]; waits for the device."""
        largest = float(self._maxima.numpy().max())
        return self.step_safety * 2.0 / np.sqrt(largest)

    def advance(self, block_count: int = 1) -> None:
        """Do ``block_count`` times ``REFRESH_INTERVAL`` steps."""
        while block_count > 0:
            block_count -= self._take_turn(block_count)

    def advance_to(self, target: float, stop: Callable[[], bool] = lambda: False) -> None:
        """Do blocks up to the first end of one at or after ``target`` [s].

        Earlier ends are that ``stop()`` is true, and that the step is no longer positive and finite, which any number
        of the state that is not finite leads to within a block. The host looks at both between turns of about a
        twentieth of a second, a block at least; where ``launches_intervals`` is true, only at the end of all blocks.
        """
        while not stop():
            clock = self.state.clock.numpy()
            remaining, step = target - float(clock[ClockEntry.time]), float(clock[ClockEntry.step])
            if not (remaining > 0.0 and 0.0 < step < math.inf):
                return
            if self.launches_intervals:
                self._launch_interval(target)
            else:
                self._take_turn(min(safe_block_count(remaining, step), LARGEST_REPLAY))

    def phases(self, repeat_count: int) -> dict[str, Callable[[], None]]:
        """Phases of a step, to be timed on one thread: each call does ``repeat_count`` times what it is called after.

        The first three begin with a copy of the state, so that they start from the same one and leave it as it is: the
        first only copies, each of the next does one more phase of the step behind it. The others are alone.
        """
        self.look_ahead()
        state, tools, _ = self._ahead
        launches = {
            name: partial(self._step_ahead, phase_count)
            for phase_count, name in enumerate(("copy", "elements", "nodes and contact"))
        }
        launches["tools"] = partial(self._advance_tools, state, tools)
        launches["stable step (every 20th)"] = partial(
            self._refresh_frequencies, 0, self.model.element_count // self._frequency_lane_count
        )

        # recorded, as in a run: a launch from Python alone costs more than a small sheet
        def repeat(launch: Callable[[], None]) -> None:
            for _ in range(repeat_count):
                launch()

        graphs = {name: self._record(partial(repeat, launch)) for name, launch in launches.items()}
        return {name: partial(wp.capture_launch, graph) for name, graph in graphs.items()}

    def arrays(self) -> list[wp.array]:
        """All that constants and state of elements and nodes are kept in, each allocation once."""
        model, found = self.model, {}
        for thing in (self.state, model.elements, model.nodes, model.step_inertia, self._squared_frequency):
            for array in _arrays_in(thing):
                if array.ptr and (array.ptr not in found or found[array.ptr].capacity < array.capacity):
                    found[array.ptr] = array
        return list(found.values())


def _arrays_in(thing: object) -> Iterator[wp.array]:
    """Arrays of a dataclass or a Warp struct, and of the structs in it."""
    if isinstance(thing, wp.array):
        yield thing
    elif is_dataclass(thing):
        for field in fields(thing):
            yield from _arrays_in(getattr(thing, field.name))
    elif hasattr(thing, "_cls"):
        for name in thing._cls.vars:
            yield from _arrays_in(getattr(thing, name))
