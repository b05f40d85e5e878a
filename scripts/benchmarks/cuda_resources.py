"""What the kernels of a run need on a CUDA device, from binaries built without one: registers, stack, instructions."""

from __future__ import annotations

import re
import subprocess
import sysconfig
from collections.abc import Iterator
from dataclasses import astuple, dataclass
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
    found = USAGE.search(usage)
    if found is None:
        raise RuntimeError(f"{kernel.key}: cuobjdump reports no kernel:\n{usage}")
    forward = next(part for part in code.split("Function : ") if part.startswith(found["name"]))
    return Resources(int(found["registers"]), int(found["stack"]), len(INSTRUCTION.findall(forward)))


def kernels_on_gpu(setup: Setup, precision: str) -> Iterator[wp.Kernel]:
    """All kernels that a run of this set-up launches on a GPU, each once."""
    import warp as wp

    from weavesim import Simulation
    from weavesim.engine.setup import Solver
    from weavesim.kernels.stepping.step import check_clock, partial_maximum_kernel
    from weavesim.kernels.stepping.tools import partial_sum_kernel, tool_motion_kernel

    simulation = Simulation(setup.model_copy(update={"solver": Solver(precision=precision, lane_count=1, threads=1)}))
    real = simulation.model.real
    for kernel in dict.fromkeys(
        [
            *simulation.stepper.kernels,
            check_clock,
            partial_maximum_kernel(real),
            *(partial_sum_kernel(scalar) for scalar in (real, wp.float64)),
            tool_motion_kernel(wp.float64),
        ]
    ):
        if not kernel.key.endswith(("_subnormals", "group_maximum")):
            yield kernel


def short_name(kernel: wp.Kernel) -> str:
    """The name of the function that became a kernel."""
    return kernel.key.rpartition("__")[2]


def cuda(
    scene: Annotated[list[str] | None, typer.Option(help="may be repeated [default: all]")] = None,
    precision: Annotated[str, typer.Option(help="float32, float64, or both, comma-separated")] = "float32,float64",
    arch: Annotated[str, typer.Option(help="compute capabilities, comma-separated")] = "80,90",
) -> None:
    """Registers and stack of every kernel of the scenes on CUDA devices, without one."""
    from weavesim.app.command_line import SCENES, default_setups

    rows = []
    for name in scene or SCENES:
        for one in precision.split(","):
            for setup in default_setups([name], precision=one):
                for kernel in kernels_on_gpu(setup, one):
                    for architecture in arch.split(","):
                        needs = resources(kernel, int(architecture))
                        rows.append([setup.name, short_name(kernel), one, architecture, *astuple(needs)])
    typer.echo(table(["set-up", "kernel", "precision", "sm", "registers", "stack [bytes]", "instructions"], rows))
