"""What the kernels of a run need on a CUDA device, from binaries built without one: registers, stack, instructions."""

from __future__ import annotations

import re
import subprocess
import sysconfig
from collections.abc import Iterator
from dataclasses import astuple, dataclass, replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Annotated

import typer

from ..shared.report import table

if TYPE_CHECKING:
    import warp as wp

    from weavesim.engine.setup import Setup

# The package nvidia-cuda-cuobjdump, part of the extra "test".
DUMP = "nvidia/*/bin/cuobjdump*"
USAGE = re.compile(r"Function (?P<name>\w+_forward):\s*REG:(?P<registers>\d+) STACK:(?P<stack>\d+)")

# An address and what is there, but not what fills the end.
INSTRUCTION = re.compile(r"/\*[0-9a-f]{4,}\*/\s+(?!NOP)\S")


@dataclass(frozen=True)
class Resources:
    """Of one thread of a kernel."""

    registers: int
    stack: int  # [bytes]
    instructions: int  # in the binary, whether executed or not


def dump_program() -> Path | None:
    """NVIDIA's cuobjdump, if it is installed."""
    return next(Path(sysconfig.get_path("purelib")).glob(DUMP), None)


@cache
def resources(kernel: wp.Kernel, architecture: int) -> Resources:
    """Build a kernel for an architecture, such as 90, and read what it needs.

    Raises:
        RuntimeError: it does not compile, or cuobjdump is not installed.
    """
    import warp as wp

    program = dump_program()
    if program is None:
        raise RuntimeError("cuobjdump is not installed: pip install nvidia-cuda-cuobjdump")
    with TemporaryDirectory() as folder:
        wp.compile_aot_module(kernel.module, arch=architecture, use_ptx=False, module_dir=folder)
        (binary,) = Path(folder).glob("*.cubin")
        usage, code = (
            subprocess.run([program, option, binary], capture_output=True, text=True, check=True).stdout
            for option in ("-res-usage", "-sass")
        )
    # a module may have several kernels
    own = f"{kernel.get_mangled_name()}_cuda_kernel_forward"
    found = next((each for each in USAGE.finditer(usage) if each["name"] == own), None)
    if found is None:
        raise RuntimeError(f"{kernel.key}: cuobjdump reports no kernel of this name:\n{usage}")
    forward = next(part for part in code.split("Function : ") if part.split(maxsplit=1)[0] == own)
    return Resources(int(found["registers"]), int(found["stack"]), len(INSTRUCTION.findall(forward)))


def kernels_on_gpu(setup: Setup, precision: str) -> Iterator[wp.Kernel]:
    """All kernels that a run of this set-up launches on a GPU, each once."""
    import warp as wp

    from weavesim import Simulation
    from weavesim.engine.setup import Solver
    from weavesim.kernels.stepping.step import (
        MAXIMUM_GROUP,
        check_clock,
        group_maximum_kernel,
        partial_maximum_kernel,
    )
    from weavesim.kernels.stepping.tools import partial_sum_kernel, tool_motion_kernel

    simulation = Simulation(setup.model_copy(update={"solver": Solver(precision=precision, lane_count=1, threads=1)}))
    real = simulation.model.real
    for kernel in dict.fromkeys(
        [
            *simulation.stepper.kernels,
            check_clock,
            partial_maximum_kernel(real),
            *(partial_sum_kernel(scalar) for scalar in (real, wp.float64)),
            tool_motion_kernel(wp.float64, waits=simulation.model.tools.waits),
        ]
    ):
        if not kernel.key.endswith("_subnormals") and kernel is not group_maximum_kernel(real, MAXIMUM_GROUP):
            yield kernel


def kernels_of_tools(precision: str) -> Iterator[tuple[str, wp.Kernel]]:
    """What tools ask for that no scene has: tools that are meshes, that are carried, that are met between nodes.

    Made from their traits, which takes neither a mesh nor a run. Each with the name of what asks for it.
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
    for name, traits in {
        "mesh": NodeTraits(shape_kinds=("volume",)),
        "carried": NodeTraits(shape_kinds=("capsule", "plane"), rotated=True, carried=True),
        "carried mesh": NodeTraits(shape_kinds=("volume",), rotated=True, carried=True, friction_laws=True),
    }.items():
        yield name, node_motion_kernel(real, 1, traits)
        yield name, surface_contact_kernel(real, 1, replace(traits, sampled=True))
    yield "carried", carried_motion_kernel(wp.float64)
    yield "waiting", tool_motion_kernel(wp.float64, waits=True)
    for kernel in mesh_kernels():
        yield "sampling of a mesh", kernel


def kernels_of_self_contact(precision: str) -> list[wp.Kernel]:
    """What contact of a sheet with itself, its creases and its mirror image ask for, which no scene has by default."""
    from weavesim.device import resolve_precision
    from weavesim.engine.plies.ply_kernels import mirror_kernels, own_contact_kernels

    real = resolve_precision(precision).real
    return [*own_contact_kernels(real, 1), *mirror_kernels(real, 1)]


def short_name(kernel: wp.Kernel) -> str:
    """The name of the function that became a kernel."""
    return kernel.key.rpartition("__")[2]


def cuda(
    scene: Annotated[list[str] | None, typer.Option(help="may be repeated [default: all, tools, self-contact]")] = None,
    precision: Annotated[str, typer.Option(help="float32, float64, or both, comma-separated")] = "float32,float64",
    arch: Annotated[str, typer.Option(help="compute capabilities, comma-separated")] = "80,90",
) -> None:
    """Registers and stack of every kernel of the scenes on CUDA devices, without one."""
    from weavesim.app.command_line import SCENES, default_setups

    found = []
    for one in precision.split(","):
        for name in scene or SCENES:
            for setup in default_setups([name], precision=one):
                found += [(setup.name, one, kernel) for kernel in kernels_on_gpu(setup, one)]
        if not scene:
            found += [(f"tools: {name}", one, kernel) for name, kernel in kernels_of_tools(one)]
            found += [("self-contact", one, kernel) for kernel in kernels_of_self_contact(one)]
    rows = [
        [name, short_name(kernel), one, architecture, *astuple(resources(kernel, int(architecture)))]
        for name, one, kernel in found
        for architecture in arch.split(",")
    ]
    typer.echo(table(["set-up", "kernel", "precision", "sm", "registers", "stack [bytes]", "instructions"], rows))
