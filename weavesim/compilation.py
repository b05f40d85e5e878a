"""Compile the kernels of a run ahead of it, side by side in processes."""

from __future__ import annotations

import multiprocessing
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import warp as wp

from .device import Precision, available_threads, initialise, load_kernel, resolve_device
from .errors import InputError
from .fabric import UNIT_CELLS
from .kernels.barrier import barrier
from .kernels.distance import DOME_OPENING, DOME_PUNCH, SPHERE, sample_distance_kernel
from .kernels.element import element_force_kernel
from .kernels.interval import look_at_clock
from .kernels.lanes import CPU_LANE_COUNT, GPU_LANE_COUNT
from .kernels.ledger import element_ledger_kernel
from .kernels.mesh_distance import fill_tiles_kernel, mesh_distance_kernel, volume_distance_kernel
from .kernels.node import NodeTraits, node_motion_kernel
from .kernels.sheet import SheetTraits
from .kernels.subnormals import flush_subnormals, restore_subnormals
from .kernels.support_motion import support_motion_kernel
from .kernels.time_step import (
    element_frequency_kernel,
    frequency_lane_count,
    partial_maximum_kernel,
    set_step_kernel,
)
from .kernels.tool_motion import partial_sum_kernel, tool_motion_kernel

# What the default set-ups of the scenes are; others are compiled when they run.
SCENE_TRAITS: dict[str, tuple[SheetTraits, NodeTraits]] = {
    "double-dome": (SheetTraits(), NodeTraits(shape_kinds=(int(DOME_PUNCH), int(DOME_OPENING)), rotated=True)),
    "hemisphere": (SheetTraits(), NodeTraits(shape_kinds=(int(SPHERE),))),
    "picture-frame": (SheetTraits(), NodeTraits(supported=True)),
    "bias-extension": (SheetTraits(), NodeTraits(supported=True)),
    "cantilever": (SheetTraits(), NodeTraits(supported=True)),
}


@dataclass(frozen=True)
class KernelSet:
    """What decides which kernels a run takes.

    Attributes:
        precision: of the run.
        device: where it computes.
        unit_cell: a name of ``weavesim.fabric.UNIT_CELLS``.
        scene: a name of ``SCENE_TRAITS``; None means all of them.
    """

    precision: Precision = Precision.SINGLE
    device: str = "cpu"
    unit_cell: str = "plain-weave"
    scene: str | None = None

    def kernels(self) -> list[wp.Kernel]:
        """All kernels that the scene takes, roughly those first that take long to compile.

        Raises:
            InputError: no such unit cell, scene or device.
        """
        for what, name, known in (("unit cell", self.unit_cell, UNIT_CELLS), ("scene", self.scene, SCENE_TRAITS)):
            if name is not None and name not in known:
                raise InputError(f"{what} {name!r} is unknown: choose one of {', '.join(known)}")
        is_cpu = resolve_device(self.device).is_cpu
        real, law = self.precision.real, UNIT_CELLS[self.unit_cell]().law()
        lane_count = CPU_LANE_COUNT if is_cpu else GPU_LANE_COUNT
        traits = [SCENE_TRAITS[self.scene]] if self.scene else list(SCENE_TRAITS.values())
        sheets, nodes = (list(dict.fromkeys(kind)) for kind in zip(*traits, strict=True))
        return [
            *(element_force_kernel(real, lane_count, law, sheet) for sheet in sheets),
            *(element_frequency_kernel(real, frequency_lane_count(lane_count, law), law, sheet) for sheet in sheets),
            *(node_motion_kernel(real, lane_count, node) for node in nodes),
            *(element_ledger_kernel(real, law, sheet) for sheet in sheets),
            sample_distance_kernel(real, 1),
            mesh_distance_kernel,
            volume_distance_kernel,
            fill_tiles_kernel,
            tool_motion_kernel(real),
            support_motion_kernel(real),
            partial_sum_kernel(real),
            partial_maximum_kernel(real),
            set_step_kernel(real),
            *([barrier, flush_subnormals, restore_subnormals] if is_cpu else [look_at_clock]),
        ]


def compile_kernels(kernel_set: KernelSet, process_count: int | None = None) -> float:
    """Compile what is not in the cache yet.

    Args:
        kernel_set: what for.
        process_count: that compile side by side; None takes one per core.

    Returns:
        Seconds that it took.

    Raises:
        InputError: no such unit cell, scene or device.
    """
    started = time.perf_counter()
    initialise()
    count = len(kernel_set.kernels())
    process_count = min(process_count or available_threads(), count)
    if process_count == 1:
        for index in range(count):
            _load(kernel_set, index)
    else:
        # a fresh interpreter each: a forked Warp would share its compiler with the others
        with ProcessPoolExecutor(
            process_count,
            mp_context=multiprocessing.get_context("spawn"),
            initializer=_keep_cache_in,
            initargs=(_cache_folder(),),
        ) as processes:
            for done in [processes.submit(_load, kernel_set, index) for index in range(count)]:
                done.result()
    return time.perf_counter() - started


def _cache_folder() -> str:
    """The folder that Warp was given for its cache: it has added its version."""
    folder = Path(wp.config.kernel_cache_dir)
    return str(folder.parent if folder.name == wp.config.version else folder)


def _keep_cache_in(folder: str) -> None:
    wp.config.kernel_cache_dir = folder


def _load(kernel_set: KernelSet, index: int) -> None:
    initialise()
    load_kernel(kernel_set.kernels()[index], resolve_device(kernel_set.device))
