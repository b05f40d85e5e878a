"""The kernels that step many worlds, from what determines those of one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import warp as wp

from ...device import is_cpu
from ...kernels.machine import flush_subnormals, restore_subnormals
from ...kernels.stepping.tools import partial_sum_kernel
from ...kernels.worlds.clocks import (
    check_worlds,
    world_drives_kernel,
    world_maxima_kernel,
    world_steps_kernel,
    world_tile_maxima_kernel,
    world_tools_kernel,
)
from ...kernels.worlds.sheets import (
    world_extremes_kernel,
    world_forces_kernel,
    world_frequencies_kernel,
    world_grips_kernel,
    world_nodes_kernel,
    world_samples_kernel,
    world_works_kernel,
)
from ..compilation import KernelSet, kernel_sets
from ..setup import Setup


@dataclass(frozen=True)
class WorldKernelSet:
    """What determines the kernels of worlds that are alike; see ``KernelSet``.

    Attributes:
        own: of one of them, which has one sheet.
        device: that computes the steps.
    """

    own: KernelSet
    device: str

    @classmethod
    def of(cls, setup: Setup, device: str) -> Self:
        """Of worlds like that of ``setup``, which is a run on the host."""
        (own,) = kernel_sets(setup)
        return cls(own, device)

    @property
    def real(self) -> type:
        return self.own.precision.real

    @property
    def on_gpu(self) -> bool:
        return not is_cpu(self.device)

    @property
    def forces(self) -> wp.Kernel:
        return world_forces_kernel(self.real, self.own.lane_count, self.own.unit_cell.law(), self.own.sheets[0])

    @property
    def frequencies(self) -> wp.Kernel:
        return world_frequencies_kernel(self.real, self.own.lane_count, self.own.unit_cell.law(), self.own.sheets[0])

    @property
    def nodes(self) -> wp.Kernel:
        return world_nodes_kernel(self.real, self.own.lane_count, self.own.nodes[0])

    @property
    def samples(self) -> wp.Kernel | None:
        """None where only nodes meet tools."""
        traits = self.own.nodes[0]
        return world_samples_kernel(self.real, self.own.lane_count, traits) if traits.sampled else None

    @property
    def extremes(self) -> wp.Kernel:
        return world_extremes_kernel(self.real, self.own.lane_count, self.own.sheets[0].flat)

    @property
    def works(self) -> wp.Kernel:
        return world_works_kernel(self.real, self.own.lane_count)

    @property
    def tools(self) -> wp.Kernel:
        """On a GPU from sums in double precision, if there are tools."""
        return world_tools_kernel(wp.float64 if self.on_gpu and self.own.tools else self.real)

    @property
    def partial_sums(self) -> wp.Kernel | None:
        """None where one thread sums all reactions."""
        return partial_sum_kernel(self.real) if self.on_gpu and self.own.tools else None

    @property
    def maxima(self) -> wp.Kernel:
        """In tiles on a GPU."""
        return (world_tile_maxima_kernel if self.on_gpu else world_maxima_kernel)(self.real)

    @property
    def steps(self) -> wp.Kernel:
        return world_steps_kernel(self.real)

    @property
    def drives(self) -> wp.Kernel | None:
        """None without any."""
        return world_drives_kernel(self.real) if self.own.driven else None

    @property
    def grips(self) -> wp.Kernel | None:
        """None without grippers."""
        return world_grips_kernel(self.real) if self.own.gripped else None

    def kernels(self) -> list[wp.Kernel]:
        """All kernels, roughly in order of decreasing compile time."""
        found = [
            self.forces, self.frequencies, self.nodes, self.extremes, self.tools, self.works, self.maxima, self.steps,
            self.partial_sums, self.drives, self.grips, self.samples, check_worlds,
        ]  # fmt: skip
        of_cpu = [] if self.on_gpu else [flush_subnormals, restore_subnormals]
        return [kernel for kernel in found if kernel is not None] + of_cpu
