"""Time stepping as a sequence of launches: step, block of steps, interval between two outputs.

In a step, supports compute their displacement increments; elements write the forces at their corners; nodes gather the
forces, make contact with the tools and move, on a CPU tile by tile after the elements; tools move and the clock
advances. Every ``REFRESH_INTERVAL`` steps the stable step is computed again from the current tangents.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
import warp as wp

from ..device import load_kernel
from ..kernels.rows import ClockEntry
from ..kernels.stepping.step import STEP_GROWTH
from .compilation import KernelSet, compile_missing
from .launches import Launches
from .model import Model
from .replay import IntervalEnd, Replay
from .setup import STEP_SAFETY
from .sheet_model import REFRESH_INTERVAL
from .state import State
from .threads import ThreadChoice
from .tiling.division import Division
from .tiling.tiles import chunks

# Largest number of blocks before the host checks the clock, and on a GPU that checks the clock itself.
LARGEST_REPLAY = 50
LARGEST_INTERVAL = 10_000


def safe_block_count(remaining: float, step: float) -> int:
    """Number of blocks such that only the last can reach a time ``remaining`` seconds away, however the step grows."""
    growth = float(STEP_GROWTH) - 1.0
    return max(1, int(math.log1p(growth * remaining / (REFRESH_INTERVAL * step)) / math.log1p(growth)))


class Stepper:
    """Advances a state in blocks of ``REFRESH_INTERVAL`` steps.

    Args:
        model: constants.
        state: what is advanced: ``State.initial``, followed by ``start``, or a state to continue from.
        thread_counts: numbers of CPU threads, ascending; the fastest is chosen during the run. Results are
            bit-identical for all of them.
        largest_step: upper limit of the time step [s].
        step_safety: share of the stable step 2/omega that is used.

    Attributes:
        loading_time: time to load the kernels, including compilation of those that were not cached [s].
        whole_launches: whether every kernel runs on a whole sheet at once, side by side where it can, as on a GPU; else
            in tiles.
        launches_intervals: whether all blocks up to an output are a single launch, as is possible on a GPU.
    """

    def __init__(
        self,
        model: Model,
        state: State,
        *,
        thread_counts: Sequence[int] = (1,),
        largest_step: float = np.inf,
        step_safety: float = STEP_SAFETY,
    ) -> None:
        self.model, self.state = model, state
        self.largest_step, self.step_safety = largest_step, step_safety
        self._choice = ThreadChoice(thread_counts if model.device.is_cpu else (1,))
        self._launches = Launches(model, state)
        self._replay = Replay(model.device, self._choice.counts[-1])
        self._interval_end = IntervalEnd(model.device, state.clock, LARGEST_INTERVAL)
        self.whole_launches = model.device.is_cuda
        self.launches_intervals = model.device.is_cuda and wp.is_conditional_graph_supported()
        self.loading_time = 0.0
        self._damping: float | None = None
        self._forget_recordings()
        self._ahead: Launches | None = None

    # --- start -------------------------------------------------------------------------------------------------------

    def load(self) -> None:
        """Load the kernels of the run; those that are not cached are compiled."""
        started = time.perf_counter()
        for kernel_set in self.kernel_sets:
            compile_missing(kernel_set)
        for kernel in self.kernels:
            load_kernel(kernel, self.model.device)
        self.loading_time = time.perf_counter() - started

    def start(self) -> None:
        """Compute the first stable step, for a state at time zero."""
        self.refresh_step()
        # velocities are at half steps, but the initial ones at time zero: the first update covers half a step
        clock = self.state.clock.numpy()
        clock[ClockEntry.mean_step] = 0.5 * clock[ClockEntry.step]
        self.state.clock.assign(clock)

    @property
    def kernel_sets(self) -> list[KernelSet]:
        """What determines the kernels of every sheet, including those of its ledger."""
        setup = self.model.setup
        return [
            KernelSet.of_sheet(setup, sheet.fabric.unit_cell, sheet.sheet_traits, sheet.node_traits)
            for sheet in self.model.sheets
        ]

    @property
    def kernels(self) -> list[wp.Kernel]:
        """All kernels that are launched."""
        return [
            *self._launches.kernels,
            *self._replay.kernels,
            *([self._interval_end.kernel] if self.launches_intervals else []),
        ]

    # --- step, block, interval ---------------------------------------------------------------------------------------

    def _step(self, divided: Sequence[Division], thread: int) -> None:
        """The share of ``thread`` in one step; ``divided`` is that of every sheet."""
        launches, thread_count = self._launches, len(divided[0].parts)
        wait = partial(self._replay.wait, thread_count)
        own = [(index, sheet.parts[thread], sheet.ring) for index, sheet in enumerate(divided)]
        if self.model.drives.count and thread == 0:
            launches.move_supports()
        launches.plies.find_normals(thread_count, thread)
        if self.model.drives.count or launches.plies:
            wait()
        if launches.plies:
            launches.plies.meet(thread_count, thread)
            wait()
        for index, part, ring in own:
            for tile in part.tiles:
                for elements in tile.elements:
                    launches.element_forces(index, *elements, ring)
                    launches.plies.push(index, *elements, ring)
                    launches.loads.apply(index, *elements, ring)
                    launches.meet_between_nodes(index, *elements)
                for nodes in tile.nodes:
                    launches.move_nodes(index, *nodes, ring)
        wait()
        for index, part, ring in own:
            for nodes in part.shared:
                launches.move_nodes(index, *nodes, ring)
        wait()
        if thread == 0:
            launches.move_tools()
        wait()

    def _refresh(self, thread_count: int, thread: int) -> None:
        for index in range(len(self.model.sheets)):
            own = chunks(self._launches.frequency_block_count(index), thread_count)[thread]
            self._launches.element_frequencies(index, *own)
            sheet = self.model.sheets[index]
            own = chunks(sheet.element_count // sheet.lane_count, thread_count)[thread]
            self._launches.element_extremes(index, *own)
            self._launches.fold_works(index, thread, thread_count)
        self._launches.plies.watch_speeds(thread_count, thread)
        self._replay.wait(thread_count)
        if thread == 0:
            self._launches.set_step(self.step_safety, self.largest_step)
        if self._launches.plies:
            for _ in self._launches.plies.search(thread_count, thread):
                self._replay.wait(thread_count)
        else:
            self._replay.wait(thread_count)

    def _block(self, divided: Sequence[Division], thread: int) -> None:
        # recording a launch takes about 70 us, as long as a step of a small sheet
        self._replay.repeat(partial(self._step, divided, thread), REFRESH_INTERVAL, thread)
        self._refresh(len(divided[0].parts), thread)

    def _block_of_whole_launches(self) -> None:
        """A block on a GPU: whatever does not depend on each other runs side by side."""
        launches, beside, join = self._launches, self._replay.beside, self._replay.join
        indices = range(len(self.model.sheets))
        for step_index in range(REFRESH_INTERVAL):
            if launches.plies:
                join()  # the clock, which the tools advance
                launches.plies.find_normals()
                launches.plies.meet()
            for index in indices:
                launches.element_forces(index)
                self._push_facets(launches, index)
            join()
            launches.move_supports()
            for index in indices:
                launches.loads.apply(index)
                launches.meet_between_nodes(index)
                launches.move_nodes(index)
            with beside():
                launches.move_tools()
            # The elements of the next step may run beside the tools: of the clock they need the last two steps, which
            # the tools leave as they are except after the first step, where the mean step changes.
            if step_index == 0:
                join()
        join()
        for index, sheet in enumerate(self.model.sheets):
            with beside():
                launches.element_extremes(index, 0, sheet.element_count // sheet.lane_count)
                launches.fold_works(index)
            launches.element_frequencies(index, 0, launches.frequency_block_count(index))
        launches.plies.watch_speeds()
        launches.set_step(self.step_safety, self.largest_step)
        for _ in launches.plies.search():
            pass
        join()

    def _push_facets(self, launches: Launches, index: int) -> None:
        """Reactions of other plies on all elements of a sheet."""
        sheet = self.model.sheets[index]
        launches.plies.push(index, 0, sheet.element_count // sheet.lane_count)

    def _interval(self) -> None:
        """All blocks up to the target, done by a GPU without the host."""

        def body() -> None:
            self._block_of_whole_launches()
            self._interval_end.check(1)

        self._interval_end.check(0)
        wp.capture_while(self._interval_end.running, body)

    # --- recordings --------------------------------------------------------------------------------------------------

    def _forget_recordings(self) -> None:
        # for each number of threads: the graph of a block of each thread; recorded on first use
        self._block_graphs: dict[int, list[wp.Graph]] = {}
        self._interval_graph: wp.Graph | None = None
        self._ahead_graph: wp.Graph | None = None

    def _recorded_blocks(self, thread_count: int) -> list[wp.Graph]:
        record = self._replay.record_rounds
        if thread_count not in self._block_graphs and self.whole_launches:
            self._block_graphs[thread_count] = [record(self._block_of_whole_launches)]
        elif thread_count not in self._block_graphs:
            divided = self._launches.divided(thread_count)
            blocks = [partial(self._block, divided, thread) for thread in range(thread_count)]
            self._block_graphs[thread_count] = [record(block, thread) for thread, block in enumerate(blocks)]
        return self._block_graphs[thread_count]

    def _take_turn(self, largest_block_count: int) -> int:
        """Do blocks on the chosen number of threads until the next choice; returns the number of blocks done."""
        choice = self._choice.present()
        graphs = self._recorded_blocks(choice.count)
        block_count = min(largest_block_count, choice.block_count())
        started = time.perf_counter()
        self._replay.run(graphs, block_count)
        choice.report(block_count, time.perf_counter() - started)
        self.state.step_count += block_count * REFRESH_INTERVAL
        return block_count

    def _launch_interval(self, target: float) -> None:
        if self._interval_graph is None:
            self._interval_graph = self._replay.record(self._interval)
        self._interval_end.begin(target)
        wp.capture_launch(self._interval_graph)
        self.state.step_count += self._interval_end.block_count * REFRESH_INTERVAL

    # --- public interface --------------------------------------------------------------------------------------------

    @property
    def step_count(self) -> int:
        """Steps done so far."""
        return self.state.step_count

    @property
    def thread_count(self) -> int:
        """The number of threads that did most steps."""
        return self._choice.most_used

    def evaluate(self) -> None:
        """Compute the forces of elements, pressures and grippers in the current state."""
        for index, own in enumerate(self.state.sheets):
            self._launches.element_forces(index)
            booked = [(array, wp.clone(array)) for array in (own.pressure_work, own.grip) if array.size]
            self._launches.loads.apply(index)
            for array, before in booked:  # the next step books it
                wp.copy(array, before)

    def refresh_step(self) -> None:
        """Compute the stable step from the current state."""
        self._refresh(1, 0)

    def stable_step(self) -> float:
        """Stable step at the last refresh, including the safety factor [s]; waits for the device."""
        return self.step_safety * 2.0 / np.sqrt(float(self._launches.maxima.numpy().max()))

    def look_ahead(self) -> State:
        """Do the next step on a copy and return it; the state itself does not change."""
        if self._ahead is None:
            self._ahead = Launches(self.model, self.state.clone())
            self._ahead.set_damping(self._damping)
        if self._ahead_graph is None:
            self._ahead_graph = self._replay.record(self._step_ahead)
        wp.capture_launch(self._ahead_graph)
        self._ahead.state.step_count = self.step_count + 1
        return self._ahead.state

    def _step_ahead(self, phase_count: int = 3) -> None:
        """Copy the state, and do the next step, or its first phases, on the copy."""
        assert self._ahead is not None
        ahead = self._ahead
        ahead.state.copy_from(self.state)
        indices = range(len(self.model.sheets))
        if phase_count > 0:
            ahead.plies.find_normals()
            ahead.plies.meet()
            for index in indices:
                ahead.element_forces(index)
                self._push_facets(ahead, index)
                ahead.loads.apply(index)
        if phase_count > 1:
            ahead.move_supports()
            for index in indices:
                ahead.meet_between_nodes(index)
                ahead.move_nodes(index)
        if phase_count > 2:
            ahead.move_tools()

    def set_damping(self, rate: float | None) -> None:
        """Damp all nodes and directors at one rate [1/s] from the next step on; None uses those of ``Dynamics``."""
        self._damping = rate
        for launches in (self._launches, self._ahead):
            if launches is not None:
                launches.set_damping(rate)
        self._forget_recordings()

    def advance(self, block_count: int = 1) -> None:
        """Do ``block_count`` blocks of ``REFRESH_INTERVAL`` steps."""
        while block_count > 0:
            block_count -= self._take_turn(block_count)

    def advance_to(self, target: float, stop: Callable[[], bool] = lambda: False) -> None:
        """Do blocks until one ends at or after ``target`` [s].

        Stops earlier when ``stop()`` is true, or when the step is no longer positive and finite, which happens within a
        block of any non-finite number in the state. The host checks both between turns of about a twentieth of a
        second, at least a block; where ``launches_intervals`` is true, only after all blocks.
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
        """Phases of a step, for timing on one thread: each call repeats the phase of its name ``repeat_count`` times.

        The first three begin with a copy of the state, so that they all start from it and leave it unchanged: the first
        only copies, each of the next two adds one phase of the step. The others are measured separately.
        """
        self.look_ahead()
        assert self._ahead is not None
        launches: dict[str, Callable[[], None]] = {
            name: partial(self._step_ahead, phase_count)
            for phase_count, name in enumerate(("copy", "elements", "nodes and contact"))
        }
        launches["tools"] = self._ahead.move_tools

        def frequencies() -> None:
            for index in range(len(self.model.sheets)):
                self._launches.element_frequencies(index, 0, self._launches.frequency_block_count(index))

        launches["stable step (every 20th)"] = frequencies

        # recorded, as in a run: a launch from Python costs more than the work of a small sheet
        def repeat(launch: Callable[[], None]) -> None:
            for _ in range(repeat_count):
                launch()

        graphs = {name: self._replay.record(partial(repeat, launch)) for name, launch in launches.items()}
        return {name: partial(wp.capture_launch, graph) for name, graph in graphs.items()}

    def arrays(self) -> list[wp.array]:
        """All arrays with constants and state of elements and nodes, each allocation once."""
        found: dict[int, wp.array] = {}
        own = [array for _, array in self.state.arrays()]
        for array in [*own, *self.model.arrays(), *self._launches.squared_frequency]:
            if array.ptr and (array.ptr not in found or found[array.ptr].capacity < array.capacity):
                found[array.ptr] = array
        return list(found.values())
