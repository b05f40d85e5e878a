"""Elements and nodes of many worlds in one launch: thread k works on block k % n of world k / n, if that still runs.

Worlds are alike: they have the same kernels and as many blocks. Each is computed by the functions that a kernel of its
own calls, so that it gets the numbers that it gets alone.
"""

from functools import cache
from typing import Any

import warp as wp

from ..cell.law import CellLaw
from ..lane_types import step_options
from ..loads.grippers import grip_function
from ..shell.extremes import element_extremes_function
from ..shell.force import element_force_function
from ..shell.frequency import element_frequency_function
from ..shell.laws import SheetTraits
from ..stepping.node import node_motion_function
from ..stepping.node_data import NodeTraits
from ..stepping.step import fold_works_function
from ..stepping.surface_contact import surface_contact_function
from .arguments import (
    force_arguments,
    frequency_arguments,
    grip_arguments,
    node_arguments,
    record_arguments,
    sample_arguments,
)


def over_worlds(name: str, arguments: Any, work: wp.Function, options: dict[str, Any] | None = None) -> wp.Kernel:
    """Kernel (blocks of each world, whether each runs, arguments of each) that does ``work`` on every block.

    Args:
        name: of the kernel, in profiles and in the cache.
        arguments: struct of what one world gives.
        work: wp.func (block, arguments).
        options: of the module.
    """

    def over_blocks(block_count: wp.int32, running: wp.array(dtype=wp.int32), worlds: wp.array(dtype=arguments)):
        world = wp.tid() / block_count
        if running[world] != 0:
            work(wp.tid() - world * block_count, worlds[world])

    over_blocks.__name__ = over_blocks.__qualname__ = name
    return wp.kernel(over_blocks, module="unique", enable_backward=False, module_options=options)


@cache
def world_forces_kernel(real: type, lane_count: int, cell: CellLaw, traits: SheetTraits):
    """Kernel, launched once per step: forces of all elements; see ``element_force_kernel``."""
    Arguments = force_arguments(real, lane_count, cell, traits)
    forces_of_block = element_force_function(real, lane_count, cell, traits)

    @wp.func
    def forces(block: int, a: Arguments):
        forces_of_block(block, a.sheet, a.motion, a.clock, a.cell_unknowns, a.cell_report, a.slip, a.corner_force)

    return over_worlds("world_forces", Arguments, forces, step_options(real))


@cache
def world_nodes_kernel(real: type, lane_count: int, traits: NodeTraits):
    """Kernel, launched once per step: motion of all nodes; see ``node_motion_kernel``."""
    Arguments, move_block = node_arguments(real, lane_count), node_motion_function(real, lane_count, traits)

    @wp.func
    def nodes(block: int, a: Arguments):
        move_block(block, a.nodes, a.laws, a.around, a.corners, a.motion, a.touch, a.works)

    return over_worlds("world_nodes", Arguments, nodes, step_options(real))


@cache
def world_samples_kernel(real: type, lane_count: int, traits: NodeTraits):
    """Kernel, launched once per step before the nodes: contact between them; see ``surface_contact_kernel``."""
    Arguments = sample_arguments(real, lane_count)
    contact_of_block = surface_contact_function(real, lane_count, traits)

    @wp.func
    def samples(block: int, a: Arguments):
        contact_of_block(block, a.samples, a.laws, a.around, a.moved, a.motion, a.corner_force, a.sampled)

    return over_worlds("world_samples", Arguments, samples, step_options(real, inlined=True))


@cache
def world_frequencies_kernel(real: type, lane_count: int, cell: CellLaw, traits: SheetTraits):
    """Kernel, launched once per block of steps: highest frequencies; see ``element_frequency_kernel``."""
    Arguments = frequency_arguments(real, lane_count, cell, traits)
    frequencies_of_block = element_frequency_function(real, lane_count, cell, traits)

    @wp.func
    def frequencies(block: int, a: Arguments):
        frequencies_of_block(
            block, a.sheet, a.bounds, a.motion, a.cell_unknowns, a.inertia, a.clock, a.squared_frequency
        )

    return over_worlds("world_frequencies", Arguments, frequencies)


@cache
def world_extremes_kernel(real: type, lane_count: int, flat: bool):
    """Kernel, launched once per block of steps: extremes so far; see ``element_extremes_kernel``."""
    Arguments = record_arguments(real, lane_count)
    extremes_of_block = element_extremes_function(real, lane_count, flat)

    @wp.func
    def extremes(block: int, a: Arguments):
        extremes_of_block(block, a.elements, a.motion, a.extremes)

    return over_worlds("world_extremes", Arguments, extremes)


@cache
def world_grips_kernel(real: type):
    """Kernel, launched once per step after the elements: springs of gripped nodes; see ``grip_kernel``."""
    Arguments, pull_node = grip_arguments(real), grip_function(real)

    @wp.func
    def grips(node: int, a: Arguments):
        pull_node(node, a.grips, a.motion, a.clock, a.corner_force, a.kept)

    return over_worlds("world_grips", Arguments, grips)


@cache
def world_works_kernel(real: type, lane_count: int):
    """Kernel, launched once per block of steps: works of the last steps; see ``fold_works_kernel``."""
    Arguments, fold_works_of_block = record_arguments(real, lane_count), fold_works_function(real, lane_count)

    @wp.func
    def works(block: int, a: Arguments):
        fold_works_of_block(block, a.works, a.sums)

    return over_worlds("world_works", Arguments, works)
