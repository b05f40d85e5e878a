"""Elements and nodes of many worlds in one launch: thread k works on block k % n of world k / n, if that still runs.

Worlds are alike: they have the same kernels and as many blocks. Each is computed by the functions that a kernel of its
own calls, so that it gets the numbers that it gets alone.
"""

from functools import cache

import warp as wp

from ..cell.law import CellLaw
from ..lanes import step_options
from ..loads.grippers import grip_function
from ..shell.extremes import element_extremes_function
from ..shell.force import element_force_function
from ..shell.frequency import element_frequency_function
from ..shell.laws import SheetTraits
from ..stepping.node import node_motion_function
from ..stepping.node_data import NodeTraits
from ..stepping.step import fold_works_function
from .arguments import force_arguments, frequency_arguments, grip_arguments, node_arguments, record_arguments


@cache
def world_forces_kernel(real: type, lane_count: int, cell: CellLaw, traits: SheetTraits):
    """Kernel, launched once per step: forces of all elements; see ``element_force_kernel``."""
    Arguments = force_arguments(real, lane_count, cell, traits)
    forces_of_block = element_force_function(real, lane_count, cell, traits)

    @wp.kernel(module="unique", enable_backward=False, module_options=step_options(real))
    def world_forces(
        block_count: wp.int32,
        running: wp.array(dtype=wp.int32),
        worlds: wp.array(dtype=Arguments),
    ):
        world = wp.tid() / block_count
        block = wp.tid() - world * block_count
        if running[world] != 0:
            a = worlds[world]
            forces_of_block(block, a.sheet, a.motion, a.clock, a.cell_unknowns, a.cell_report, a.slip, a.corner_force)

    return world_forces


@cache
def world_nodes_kernel(real: type, lane_count: int, traits: NodeTraits):
    """Kernel, launched once per step: motion of all nodes; see ``node_motion_kernel``."""
    Arguments, move_block = node_arguments(real, lane_count), node_motion_function(real, lane_count, traits)

    @wp.kernel(module="unique", enable_backward=False, module_options=step_options(real))
    def world_nodes(
        block_count: wp.int32,
        running: wp.array(dtype=wp.int32),
        worlds: wp.array(dtype=Arguments),
    ):
        world = wp.tid() / block_count
        block = wp.tid() - world * block_count
        if running[world] != 0:
            a = worlds[world]
            move_block(block, a.nodes, a.laws, a.around, a.corners, a.motion, a.touch, a.works)

    return world_nodes


@cache
def world_frequencies_kernel(real: type, lane_count: int, cell: CellLaw, traits: SheetTraits):
    """Kernel, launched once per block of steps: highest frequencies; see ``element_frequency_kernel``."""
    Arguments = frequency_arguments(real, lane_count, cell, traits)
    frequencies_of_block = element_frequency_function(real, lane_count, cell, traits)

    @wp.kernel(module="unique", enable_backward=False)
    def world_frequencies(
        block_count: wp.int32,
        running: wp.array(dtype=wp.int32),
        worlds: wp.array(dtype=Arguments),
    ):
        world = wp.tid() / block_count
        block = wp.tid() - world * block_count
        if running[world] != 0:
            a = worlds[world]
            frequencies_of_block(
                block, a.sheet, a.bounds, a.motion, a.cell_unknowns, a.inertia, a.clock, a.squared_frequency
            )

    return world_frequencies


@cache
def world_extremes_kernel(real: type, lane_count: int, flat: bool):
    """Kernel, launched once per block of steps: extremes so far; see ``element_extremes_kernel``."""
    Arguments = record_arguments(real, lane_count)
    extremes_of_block = element_extremes_function(real, lane_count, flat)

    @wp.kernel(module="unique", enable_backward=False)
    def world_extremes(
        block_count: wp.int32,
        running: wp.array(dtype=wp.int32),
        worlds: wp.array(dtype=Arguments),
    ):
        world = wp.tid() / block_count
        block = wp.tid() - world * block_count
        if running[world] != 0:
            a = worlds[world]
            extremes_of_block(block, a.elements, a.motion, a.extremes)

    return world_extremes


@cache
def world_grips_kernel(real: type):
    """Kernel, launched once per step after the elements: springs of gripped nodes; see ``grip_kernel``."""
    Arguments, pull_node = grip_arguments(real), grip_function(real)

    @wp.kernel(module="unique", enable_backward=False)
    def world_grips(
        block_count: wp.int32,  # gripped nodes of each world
        running: wp.array(dtype=wp.int32),
        worlds: wp.array(dtype=Arguments),
    ):
        world = wp.tid() / block_count
        k = wp.tid() - world * block_count
        if running[world] != 0:
            a = worlds[world]
            pull_node(k, a.grips, a.motion, a.clock, a.corner_force, a.kept)

    return world_grips


@cache
def world_works_kernel(real: type, lane_count: int):
    """Kernel, launched once per block of steps: works of the last steps; see ``fold_works_kernel``."""
    Arguments, fold_works_of_block = record_arguments(real, lane_count), fold_works_function(real, lane_count)

    @wp.kernel(module="unique", enable_backward=False)
    def world_works(
        block_count: wp.int32,
        running: wp.array(dtype=wp.int32),
        worlds: wp.array(dtype=Arguments),
    ):
        world = wp.tid() / block_count
        block = wp.tid() - world * block_count
        if running[world] != 0:
            a = worlds[world]
            fold_works_of_block(block, a.works, a.sums)

    return world_works
