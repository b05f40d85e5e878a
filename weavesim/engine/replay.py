"""Launches recorded once and replayed: per thread on a CPU, as a graph on a GPU."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from functools import partial

import warp as wp

from ..device import exclusive, giving_way
from ..kernels.machine import barrier, count_rounds, flush_subnormals, restore_subnormals
from ..kernels.stepping.step import check_clock

# Of the counts of a thread, each a line of the cache away from those of the others.
_COUNTS = 32


class Replay:
    """Records launches and replays them on parallel threads.

    On a CPU recorded loops go round without Python, whose lock other threads want: one that imports libraries holds it
    for half a millisecond at a time.

    Args:
        device: of the launches.
        largest_thread_count: upper limit of the threads used.
    """

    def __init__(self, device: wp.Device, largest_thread_count: int) -> None:
        self._device = device
        self._largest_thread_count = largest_thread_count
        self._side = wp.Stream(device) if device.is_cuda else None
        self._forked = False
        self._counter = wp.zeros(1, dtype=wp.int32, device=device)
        # how each thread treats subnormal numbers outside a replay
        self._modes = wp.zeros(largest_thread_count, dtype=wp.int32, device=device)
        # rounds that each thread has left: of ``run``, and of ``repeat``
        self._left = wp.zeros((largest_thread_count, _COUNTS), dtype=wp.int32, device=device)
        self._rounds = self._left.numpy()[:, 0] if device.is_cpu else None

    @property
    def kernels(self) -> list[wp.Kernel]:
        """All kernels launched here."""
        kernels = [flush_subnormals, restore_subnormals, count_rounds] if self._device.is_cpu else []
        return kernels + ([barrier] if self._largest_thread_count > 1 else [])

    def wait(self, thread_count: int) -> None:
        """Launch a barrier for ``thread_count`` threads."""
        if thread_count > 1:
            wp.launch(barrier, dim=1, inputs=[self._counter, thread_count], device=self._device)

    @contextmanager
    def beside(self) -> Iterator[None]:
        """Launches in this context run beside those after it, up to the next ``join``: on a GPU, else before them."""
        if self._side is None:
            yield
            return
        self._side.wait_stream(self._device.stream)
        self._forked = True
        with wp.ScopedStream(self._side, sync_enter=False):
            yield

    def join(self) -> None:
        """Let the next launches wait for those of ``beside``; a recording must end with this."""
        # a recording may not wait for launches from before it
        if self._side is not None and self._forked:
            self._device.stream.wait_stream(self._side)
            self._forked = False

    @exclusive()
    def record(self, launch: Callable[[], None], thread: int = 0) -> wp.Graph:
        """Record the launches of ``launch``, for replay on one thread; subnormal numbers are flushed to zero."""
        flushes = self._device.is_cpu
        before = self._modes[thread : thread + 1]
        wp.capture_begin(device=self._device)
        try:
            if flushes:
                wp.launch(flush_subnormals, dim=1, outputs=[before], device=self._device)
            launch()
            if flushes:
                wp.launch(restore_subnormals, dim=1, inputs=[before], device=self._device)
        finally:
            graph = wp.capture_end(device=self._device)
        return graph

    def repeat(self, launch: Callable[[], None], times: int, thread: int = 0) -> None:
        """Launch ``times`` times; within a recording on a CPU, ``launch`` is called once."""
        if not self._device.is_cpu:
            for _ in range(times):
                launch()
            return
        left = self._left[thread, 1:2]
        wp.launch(count_rounds, dim=1, inputs=[0, times], outputs=[left], device=self._device)
        self._loop(launch, left)

    def _loop(self, launch: Callable[[], None], left: wp.array) -> None:
        def body() -> None:
            launch()
            wp.launch(count_rounds, dim=1, inputs=[1, -1], outputs=[left], device=self._device)

        wp.capture_while(left, body)

    def record_rounds(self, launch: Callable[[], None], thread: int = 0) -> wp.Graph:
        """Record launches for ``run``, which says how often they are done."""
        if not self._device.is_cpu:
            return self.record(launch)
        return self.record(partial(self._loop, launch, self._left[thread, :1]), thread)

    def run(self, graphs: Sequence[wp.Graph], times: int = 1) -> None:
        """Do each thread's rounds ``times`` times; on a CPU, others may compute meanwhile."""

        def replay(graph: wp.Graph) -> None:
            for _ in range(times if self._rounds is None else 1):
                wp.capture_launch(graph)

        if self._rounds is not None:
            self._rounds[:] = times
        if len(graphs) > 1:
            self._counter.zero_()
        others = [threading.Thread(target=replay, args=(own,)) for own in graphs[1:]]
        with giving_way() if self._device.is_cpu else nullcontext():
            for thread in others:
                thread.start()
            replay(graphs[0])
            for thread in others:
                thread.join()


class IntervalEnd:
    """Lets a GPU do all blocks of an output interval without the host: it checks the clock itself.

    Args:
        device: of the run.
        clock: of the state.
        largest_block_count: maximum number of blocks in one interval.
    """

    kernel = check_clock

    def __init__(self, device: wp.Device, clock: wp.array, largest_block_count: int) -> None:
        self._device, self._clock, self._largest = device, clock, largest_block_count
        self._target = wp.zeros(1, dtype=wp.float64, device=device)
        self._block_count = wp.zeros(1, dtype=wp.int32, device=device)
        self.running = wp.zeros(1, dtype=wp.int32, device=device)

    def begin(self, target: float) -> None:
        """Set the end of the interval to ``target`` [s], and the count to zero."""
        self._target.fill_(target)
        self._block_count.zero_()

    def check(self, done: int) -> None:
        """Launch the check after ``done`` more blocks; it sets ``running``."""
        wp.launch(
            check_clock,
            dim=1,
            inputs=[done, self._largest, self._target, self._clock],
            outputs=[self._block_count, self.running],
            device=self._device,
        )

    @property
    def block_count(self) -> int:
        """Blocks done since ``begin``; waits for the device."""
        return int(self._block_count.numpy()[0])
