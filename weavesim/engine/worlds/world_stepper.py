"""Advances many worlds at once, each by the steps that it would take alone."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import warp as wp

from ...device import load_kernel
from ...kernels.rows import ClockEntry
from ..compilation import compile_missing
from ..replay import Replay
from ..sheet_model import REFRESH_INTERVAL
from ..stepper import Stepper
from .world_kernels import WorldKernelSet
from .world_launches import WorldLaunches


class WorldStepper:
    """Advances the states of runs that are alike, on one device; the runs themselves stay on the host.

    Every world has a clock of its own: it takes its own stable steps, and waits for the others where it has reached its
    target. Its steps are those of a single run on that device.

    Args:
        device: that computes.
        steppers: of the runs, on the host, with one lane; started.

    Attributes:
        launches_intervals: whether all blocks up to the targets are a single launch, as is possible on a GPU.
    """

    def __init__(self, device: wp.Device, steppers: Sequence[Stepper]) -> None:
        self._device, self._steppers = device, tuple(steppers)
        self._launches = WorldLaunches(
            device,
            [stepper.model for stepper in steppers],
            [stepper.state for stepper in steppers],
            [stepper.step_safety for stepper in steppers],
            [stepper.largest_step for stepper in steppers],
        )
        self._replay = Replay(device, 1)
        self._graph: wp.Graph | None = None
        self.launches_intervals = device.is_cuda and wp.is_conditional_graph_supported()

    def load(self) -> None:
        """Load the kernels; those that are not cached are compiled."""
        kernel_set = WorldKernelSet.of(self._steppers[0].model.setup, str(self._device))
        compile_missing(kernel_set)
        for kernel in kernel_set.kernels():
            load_kernel(kernel, self._device)

    def start(self) -> None:
        """Compute the first stable step of all worlds at time zero, as ``Stepper.start`` does."""
        clocks = self._launches.clocks.numpy()
        clocks[:, [ClockEntry.step, ClockEntry.mean_step]] = [
            [stepper.model.reference_step] * 2 for stepper in self._steppers
        ]
        self._launches.clocks.assign(clocks)
        self._launches.running.fill_(1)
        self._launches.refresh(self._replay.beside, self._replay.join)
        clocks = self._launches.clocks.numpy()
        clocks[:, ClockEntry.mean_step] = 0.5 * clocks[:, ClockEntry.step]
        self._launches.clocks.assign(clocks)
        self._read(range(len(self._steppers)))

    def _block(self) -> None:
        launches, beside, join = self._launches, self._replay.beside, self._replay.join
        for step_index in range(REFRESH_INTERVAL):
            launches.element_forces()
            join()
            launches.move_supports()
            launches.pull()
            launches.meet_between_nodes()
            launches.move_nodes()
            with beside():
                launches.move_tools()
            # as in a single run: of the clock, elements need what tools leave as it is, but for the first step
            if step_index == 0:
                join()
        join()
        launches.refresh(beside, join)
        launches.check(1)

    def _interval(self) -> None:
        wp.capture_while(self._launches.running_count, self._block)

    def advance_to(self, targets: np.ndarray, stop: Callable[[], bool] = lambda: False) -> None:
        """Step each world until a block ends at or after its target, (worlds,) [s]; those that are there wait.

        A world whose state is no longer finite stops. ``stop`` is asked between blocks; on a GPU between launches of
        at most ``LARGEST_INTERVAL`` blocks.
        """
        launches = self._launches
        launches.target.assign(np.asarray(targets, dtype=np.float64))
        blocks = np.zeros(len(self._steppers), dtype=np.int64)
        while True:
            launches.block_count.zero_()
            launches.check(0)
            if not launches.running_count.numpy()[0]:
                break
            if self._graph is None:
                self._graph = self._replay.record(self._interval if self.launches_intervals else self._block)
            wp.capture_launch(self._graph)
            while not self.launches_intervals and not stop() and launches.running_count.numpy()[0]:
                wp.capture_launch(self._graph)
            blocks += launches.block_count.numpy()
            if stop():
                break
        for world in np.flatnonzero(blocks):
            self._steppers[world].state.step_count += REFRESH_INTERVAL * int(blocks[world])
        self._read(np.flatnonzero(blocks).tolist())

    def _read(self, worlds: Sequence[int]) -> None:
        """Bring the states of ``worlds`` back to the host."""
        state = self._steppers[0].state
        # every step writes all corner forces before it reads any
        wanted = [array for name, array in state.arrays() if not name.endswith("corner_force")]
        self._launches.mirror.download(worlds, wanted)
