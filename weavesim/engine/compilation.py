"""Compile the kernels of a run in advance, in parallel processes."""

from __future__ import annotations

import logging
import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Protocol, Self

import warp as wp

from ..device import Precision, available_threads, initialise, is_compiled, is_cpu, load_kernel, resolve_device
from ..fabric.cell import UnitCell
from ..kernel_cache import ensure_room
from ..kernels.carried.motion import carried_motion_kernel
from ..kernels.contact.fill_samples import sampled_distance_kernel
from ..kernels.contact.tool_distance import sample_distance_kernel
from ..kernels.contact.tool_shapes import further_kinds
from ..kernels.loads.grippers import grip_kernel
from ..kernels.loads.pressure import element_pressure_kernel
from ..kernels.machine import barrier, count_rounds, flush_subnormals, restore_subnormals
from ..kernels.shell.energy import element_ledger_kernel
from ..kernels.shell.extremes import element_extremes_kernel
from ..kernels.shell.force import element_force_kernel
from ..kernels.shell.frequency import element_frequency_kernel, frequency_lane_count
from ..kernels.shell.laws import SheetTraits
from ..kernels.stepping.node import node_motion_kernel
from ..kernels.stepping.node_data import NodeTraits
from ..kernels.stepping.step import (
    MAXIMUM_GROUP,
    check_clock,
    fold_works_kernel,
    group_maximum_kernel,
    partial_maximum_kernel,
    set_step_kernel,
)
from ..kernels.stepping.supports import support_motion_kernel
from ..kernels.stepping.surface_contact import surface_contact_kernel
from ..kernels.stepping.tool_contact import tool_push_kernel
from ..kernels.stepping.tools import partial_sum_kernel, tool_motion_kernel
from ..sheet.geometry import ElementGeometry
from ..tools.sampling import SAMPLING_KERNELS
from .plies.ply_kernels import mirror_kernels, own_contact_kernels, ply_kernels
from .setup import Setup
from .traits import as_in_stages, node_traits, sheet_traits, waiting

logger = logging.getLogger(__name__)


class Kernels(Protocol):
    """Kernels for one device, as a value that can be sent to another process."""

    @property
    def device(self) -> str: ...

    def kernels(self) -> list[wp.Kernel]: ...


@dataclass(frozen=True)
class KernelSet:
    """What determines which kernels are needed; unlike kernels, it can be sent to another process.

    Attributes:
        unit_cell: of the fabric; kernels depend on its law, not on its numbers.
        sheets, nodes: traits of one run, or of several.
        precision: of the runs.
        device: of the runs.
        lane_count: elements per kernel thread.
        tools: whether there are any.
        driven: whether supports move.
        waiting: whether strokes have a largest force; both where some stages may have them.
        pressed: whether there is pressure on a sheet.
        gripped: whether there are grippers.
        threaded: whether a CPU may use several threads.
        meshes: whether the distance to a triangle mesh is sampled.
        plies: whether sheets touch each other, or themselves.
        own_contact: whether they touch themselves.
        mirrored: whether they touch their mirror images.
        others: of sheets whose unit cells are of other kinds.
    """

    unit_cell: UnitCell
    sheets: tuple[SheetTraits, ...]
    nodes: tuple[NodeTraits, ...]
    precision: Precision
    device: str
    lane_count: int
    tools: bool = True
    driven: bool = True
    waiting: tuple[bool, ...] = (False,)
    pressed: bool = False
    gripped: bool = False
    threaded: bool = True
    meshes: bool = False
    plies: bool = False
    own_contact: bool = False
    mirrored: bool = False
    others: tuple[KernelSet, ...] = ()

    @classmethod
    def of_setups(cls, setups: Iterable[Setup], unit_cell: UnitCell | None = None) -> Self:
        """What a group of runs needs, for any number of threads and of triangle meshes.

        Args:
            setups: of runs in one precision and on one device; at least one.
            unit_cell: replaces those of all sheets.
        """
        sets = [kernel_set for setup in setups for kernel_set in kernel_sets(setup)]
        kinds = dict.fromkeys(type(unit_cell or one.unit_cell) for one in sets)
        first, *others = ([one for one in sets if unit_cell or type(one.unit_cell) is kind] for kind in kinds)
        return replace(cls._of_sets(first, unit_cell), others=tuple(cls._of_sets(each, unit_cell) for each in others))

    @classmethod
    def _of_sets(cls, sets: Sequence[KernelSet], unit_cell: UnitCell | None) -> Self:
        """All of several sets of unit cells of one kind."""
        return cls(
            unit_cell or sets[0].unit_cell,
            tuple(dict.fromkeys(traits for one in sets for traits in one.sheets)),
            tuple(dict.fromkeys(traits for one in sets for traits in one.nodes)),
            sets[0].precision,
            sets[0].device,
            sets[0].lane_count,
            tools=any(one.tools for one in sets),
            driven=any(one.driven for one in sets),
            waiting=tuple(dict.fromkeys(waits for one in sets for waits in one.waiting)),
            pressed=any(one.pressed for one in sets),
            gripped=any(one.gripped for one in sets),
            meshes=True,
            plies=any(one.plies for one in sets),
            own_contact=any(one.own_contact for one in sets),
            mirrored=any(one.mirrored for one in sets),
        )

    @classmethod
    def of_sheet(cls, setup: Setup, unit_cell: UnitCell, sheet: SheetTraits, nodes: NodeTraits) -> Self:
        """What one sheet of a set-up needs, from its traits."""
        solver = setup.solver
        on_cpu = is_cpu(solver.device)
        return cls(
            unit_cell,
            (sheet,),
            (nodes,),
            solver.precision,
            solver.device,
            solver.lanes(is_cpu=on_cpu),
            tools=bool(setup.tools),
            driven=any(support.drives for support in setup.supports),
            waiting=waiting(setup),
            pressed=any(sheet.pressures for sheet in setup.sheets) or any(stage.pressures for stage in setup.stages),
            gripped=bool(setup.grippers),
            threaded=on_cpu and (solver.threads or available_threads()) > 1,
            plies=nodes.touched,
            own_contact=any(sheet.self_contact is not None for sheet in setup.sheets),
            mirrored=any(
                sheet.self_contact is not None and world.symmetry.planes
                for world in setup.worlds
                for sheet in world.sheets
            ),
        )

    def kernels(self) -> list[wp.Kernel]:
        """All kernels, roughly in order of decreasing compile time; whether there is such a device is not asked."""
        on_cpu = is_cpu(self.device)
        real, law, lane_count = self.precision.real, self.unit_cell.law(), self.lane_count
        summed, carried = real if on_cpu or not self.tools else wp.float64, [node.carried for node in self.nodes]
        further = dict.fromkeys(further_kinds(node.shape_kinds) for node in self.nodes)
        own = [
            *(element_force_kernel(real, lane_count, law, sheet) for sheet in self.sheets),
            *(
                element_frequency_kernel(real, frequency_lane_count(lane_count, law), law, sheet)
                for sheet in self.sheets
            ),
            *(node_motion_kernel(real, lane_count, node) for node in self.nodes),
            *(surface_contact_kernel(real, lane_count, node) for node in self.nodes if node.sampled),
            *(element_ledger_kernel(real, law, sheet) for sheet in self.sheets),
            *(
                element_extremes_kernel(real, lane_count, flat)
                for flat in dict.fromkeys(sheet.flat for sheet in self.sheets)
            ),
            *(sample_distance_kernel(real, lane_count, kinds) for kinds in further if self.tools),
            *(
                tool_push_kernel(real, laws)
                for laws in dict.fromkeys(node.friction_laws for node in self.nodes if self.tools)
            ),
            *(mesh_kernels() if self.meshes else []),
            *(ply_kernels(real, lane_count) if self.plies else []),
            *(own_contact_kernels(real, lane_count) if self.own_contact else []),
            *(mirror_kernels(real, lane_count) if self.mirrored else []),
            *([carried_motion_kernel(summed)] if any(carried) else []),
            *(tool_motion_kernel(summed, waits) for waits in self.waiting if not all(carried)),
            *([] if on_cpu or not self.tools else map(partial_sum_kernel, dict.fromkeys((real, wp.float64)))),
            *([support_motion_kernel(real)] if self.driven else []),
            *([element_pressure_kernel(real, lane_count)] if self.pressed else []),
            *([grip_kernel(real)] if self.gripped else []),
            group_maximum_kernel(real, MAXIMUM_GROUP) if on_cpu else partial_maximum_kernel(real),
            set_step_kernel(real),
            fold_works_kernel(real, lane_count),
            *([flush_subnormals, restore_subnormals, count_rounds] if on_cpu else [check_clock]),
            *([barrier] if on_cpu and self.threaded else []),
        ]
        return list(dict.fromkeys([*own, *(kernel for each in self.others for kernel in each.kernels())]))


def kernel_sets(setup: Setup) -> list[KernelSet]:
    """What a run needs, from its set-up alone."""
    sets = []
    for world in setup.worlds:
        for sheet in world.sheets:
            geometry = ElementGeometry.of(world.symmetry.upright(sheet.oriented_blank))
            traits = (
                sheet_traits(sheet.fabric, geometry, world.dynamics),
                node_traits(sheet, as_in_stages(setup, world)),
            )
            sets.append(KernelSet.of_sheet(setup, sheet.fabric.unit_cell, *traits))
    return sets


@dataclass(frozen=True)
class MeshKernelSet:
    """What sampling the distance to triangle meshes needs; see ``KernelSet``."""

    device: str

    def kernels(self) -> list[wp.Kernel]:
        return mesh_kernels()


def mesh_kernels() -> list[wp.Kernel]:
    """Kernels that sample the distance to a triangle mesh, and read it."""
    return [*SAMPLING_KERNELS, sampled_distance_kernel]


def missing(kernel_set: Kernels) -> list[int]:
    """Indices of the set's kernels that are not in the cache, found without compiling anything.

    Raises:
        InputError: no such device, or the cache cannot be written.
    """
    device = resolve_device(kernel_set.device)
    return [index for index, kernel in enumerate(kernel_set.kernels()) if not is_compiled(kernel, device)]


# Announces to the user how many kernels will be compiled; None in programs other than the command line.
_announce: ContextVar[Callable[[int], None] | None] = ContextVar("_announce", default=None)


@contextmanager
def side_by_side(announce: Callable[[int], None]) -> Iterator[None]:
    """Inside this context, runs first call ``announce`` with the number of kernels, then compile in parallel processes.

    Not for programs in general: each process imports the program again, and would execute everything that is not
    under ``if __name__ == "__main__"``.
    """
    token = _announce.set(announce)
    try:
        yield
    finally:
        _announce.reset(token)


def compile_missing(kernel_set: Kernels) -> None:
    """Before a run, log how many kernels are not in the cache, and compile them in parallel within ``side_by_side``.

    Raises:
        InputError: no such device, or the cache cannot be written.
    """
    indices, announce = missing(kernel_set), _announce.get()
    if not indices:
        return
    logger.info("%d kernels are not in the cache and are compiled first", len(indices))
    ensure_room()
    if announce:
        announce(len(indices))
        _compile(kernel_set, indices, available_threads())


def compile_kernels(kernel_set: Kernels, process_count: int | None = None) -> float:
    """Compile the kernels that are not in the cache yet.

    Args:
        kernel_set: what to compile.
        process_count: parallel processes; None uses one per core.

    Returns:
        Time taken [s].

    Raises:
        InputError: no such device, or the cache cannot be written.
    """
    started = time.perf_counter()
    indices = missing(kernel_set)
    process_count = min(process_count or available_threads(), len(indices))
    if indices:
        ensure_room()
    if process_count > 1:
        _compile(kernel_set, indices, process_count)
    for index in indices:
        _load(kernel_set, index)
    return time.perf_counter() - started


def _compile(kernel_set: Kernels, indices: list[int], process_count: int) -> None:
    """Compile in processes that end when this one ends, in whatever way, or when it is interrupted.

    What they fail to do is left to ``load_kernel``, which also says why.
    """
    # Not threads: Warp compiles one kernel at a time as long as CPU_COMPILER_FLAGS sets an option of LLVM.
    # A new interpreter each: forked processes would share one Warp compiler.
    context = multiprocessing.get_context("spawn")
    # The end of the lifeline tells them. This process holds it, and the operating system closes it for a killed one.
    watched, lifeline = context.Pipe(duplex=False)
    with lifeline, watched:
        try:
            with ProcessPoolExecutor(
                min(process_count, len(indices)),
                mp_context=context,
                initializer=_prepare_process,
                initargs=(_cache_folder(), watched),
            ) as processes:
                try:
                    for done in [processes.submit(_load, kernel_set, index) for index in indices]:
                        done.result()
                except BaseException:
                    lifeline.close()
                    raise
        except Exception as error:
            logger.info("kernels could not be compiled side by side: %s: %s", type(error).__name__, error)


def _cache_folder() -> str:
    """The cache folder as it was given to Warp, which has added its version."""
    folder = Path(str(wp.config.kernel_cache_dir))
    return str(folder.parent if folder.name == wp.config.version else folder)


def _prepare_process(cache_folder: str, watched: Connection) -> None:
    # Ctrl-C ends the process at once and silently, in the middle of a kernel
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    threading.Thread(target=_end_with, args=(watched,), daemon=True).start()
    wp.config.kernel_cache_dir = cache_folder


def _end_with(watched: Connection) -> None:
    """End this process when the other end of a pipe is closed; compiling leaves other threads free to."""
    with suppress(EOFError, OSError):
        watched.recv()
    os._exit(1)


def _load(kernel_set: Kernels, index: int) -> None:
    initialise()
    load_kernel(kernel_set.kernels()[index], resolve_device(kernel_set.device))
