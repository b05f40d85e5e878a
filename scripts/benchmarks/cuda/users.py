"""Which kernels weavesim launches on a CUDA device, and what asks for each; found without one."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import warp as wp

    from weavesim.engine.setup import Setup

# Those of one sheet each that a batch may step: contact between nodes; grippers and supports.
BATCHES = ("double-dome", "grippers")


def kernels_by_user(precision: str) -> dict[wp.Kernel, list[str]]:
    """Every kernel in a precision, with the names of what asks for it: scenes first, then what no scene has."""
    found: dict[wp.Kernel, list[str]] = {}
    for user, kernel in _all(precision):
        users = found.setdefault(kernel, [])
        if user not in users:
            users.append(user)
    return found


def _all(precision: str) -> Iterator[tuple[str, wp.Kernel]]:
    from weavesim.app.command_line import SCENES, default_setups

    for name in SCENES:
        for setup in default_setups([name], precision=precision):
            for kernel in kernels_of_scene(setup):
                yield name, kernel
    for kernel in kernels_of_scene(free_patch(precision)):
        yield "free patch", kernel
    for name in BATCHES:
        for setup in default_setups([name], precision=precision):
            for kernel in kernels_of_batch(setup):
                yield f"batch: {name}", kernel
    yield from kernels_of_cells(precision)
    yield from kernels_of_tools(precision)
    for kernel in kernels_of_self_contact(precision):
        yield "self-contact", kernel


def free_patch(precision: str) -> Setup:
    """A sheet without tools and supports, as in ``cases.py``: that with which steps are measured."""
    from weavesim.engine.setup import Setup, Solver
    from weavesim.fabric.presets import glass_polypropylene
    from weavesim.sheet.blank import Blank
    from weavesim.sheet.sheet import Sheet

    sheet = Sheet(Blank.rectangle((0.0, 0.0), (0.02, 0.02), 0.005), glass_polypropylene())
    return Setup("patch", sheets=(sheet,), duration=1.0, solver=Solver(precision=precision))


def on_gpu(setup: Setup) -> Setup:
    """The same run on a GPU."""
    return setup.model_copy(update={"solver": setup.solver.model_copy(update={"device": "cuda:0", "lane_count": None})})


def kernels_of_scene(setup: Setup) -> list[wp.Kernel]:
    """Those of a run on a GPU, also between its steps."""
    from weavesim.engine.compilation import kernel_sets

    return [kernel for own in kernel_sets(on_gpu(setup)) for kernel in own.kernels()]


def kernels_of_batch(setup: Setup) -> list[wp.Kernel]:
    """Those that step many runs at once on a GPU."""
    from weavesim.engine.worlds.world_kernels import WorldKernelSet
    from weavesim.run.batch.worlds import host_setup

    return WorldKernelSet.of(host_setup(setup), "cuda:0").kernels()


def kernels_of_cells(precision: str) -> Iterator[tuple[str, wp.Kernel]]:
    """Those that depend on the unit cell, of the double dome with every cell that there is an example of."""
    from weavesim.app.command_line import default_setups
    from weavesim.engine.compilation import KernelSet
    from weavesim.fabric.presets import UNIT_CELLS

    own = KernelSet.of_setups([on_gpu(setup) for setup in default_setups(["double-dome"], precision=precision)])
    sets = {name: replace(own, unit_cell=make()).kernels() for name, make in UNIT_CELLS.items()}
    of_all = set.intersection(*(set(kernels) for kernels in sets.values()))
    for name, kernels in sets.items():
        for kernel in kernels:
            if kernel not in of_all:
                yield f"cell: {name}", kernel


def kernels_of_tools(precision: str) -> Iterator[tuple[str, wp.Kernel]]:
    """What tools ask for that no scene has: tools that are meshes, that are carried, that are met between nodes.

    Made from their traits, which takes neither a mesh nor a run.
    """
    import warp as wp

    from weavesim.device import resolve_precision
    from weavesim.engine.compilation import mesh_kernels
    from weavesim.kernels.carried.motion import carried_motion_kernel
    from weavesim.kernels.stepping.node import node_motion_kernel
    from weavesim.kernels.stepping.node_data import NodeTraits
    from weavesim.kernels.stepping.surface_contact import surface_contact_kernel
    from weavesim.kernels.stepping.tools import tool_motion_kernel

    real = resolve_precision(precision).real
    carried = NodeTraits(shape_kinds=("capsule", "plane"), rotated=True, carried=True)
    for name, traits in {
        "mesh": NodeTraits(shape_kinds=("volume",)),
        "carried": carried,
        "carried mesh": NodeTraits(shape_kinds=("volume",), rotated=True, carried=True, friction_laws=True),
        # a tool that one stage carries is carried in all of them, on a sheet that any of them may load, hold or touch
        "carried in stages": replace(carried, friction_laws=True, loaded=True, supported=True, touched=True),
    }.items():
        yield f"tools: {name}", node_motion_kernel(real, 1, traits)
        yield f"tools: {name}", surface_contact_kernel(real, 1, replace(traits, sampled=True))
    if precision == "float64":  # as in all runs on a GPU
        yield "tools: carried", carried_motion_kernel(wp.float64)
        yield "tools: waiting", tool_motion_kernel(wp.float64, waits=True)
        for kernel in mesh_kernels():
            yield "tools: samples of a mesh", kernel


def kernels_of_self_contact(precision: str) -> list[wp.Kernel]:
    """What contact of a sheet with itself, its creases and its mirror image ask for, which no scene has by default."""
    from weavesim.device import resolve_precision
    from weavesim.engine.plies.ply_kernels import mirror_kernels, own_contact_kernels

    real = resolve_precision(precision).real
    return [*own_contact_kernels(real, 1), *mirror_kernels(real, 1)]
