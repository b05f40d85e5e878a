"""What a kernel needs on a CUDA device, from a binary built without one: registers, stack, instructions."""

from __future__ import annotations

import re
import subprocess
import sysconfig
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import warp as wp

# The package nvidia-cuda-cuobjdump, part of the extra "test".
DUMP = "nvidia/*/bin/cuobjdump*"
USAGE = re.compile(r"Function (?P<name>\w+)_cuda_kernel_forward:\s*REG:(?P<registers>\d+) STACK:(?P<stack>\d+)")

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


def resources(kernel: wp.Kernel, architecture: int) -> Resources:
    """Build a kernel for an architecture, such as 90, and read what it needs.

    Raises:
        RuntimeError: it does not compile, or cuobjdump is not installed.
    """
    found = _of_module(kernel.module, architecture)
    name = kernel.get_mangled_name()
    if name not in found:
        raise RuntimeError(f"{kernel.key}: cuobjdump reports no kernel of this name, but {', '.join(found)}")
    return found[name]


@cache
def _of_module(module: wp.Module, architecture: int) -> dict[str, Resources]:
    """Of all kernels of a module, by their names in the binary."""
    import warp as wp

    program = dump_program()
    if program is None:
        raise RuntimeError("cuobjdump is not installed: pip install nvidia-cuda-cuobjdump")
    with TemporaryDirectory() as folder:
        wp.compile_aot_module(module, arch=architecture, use_ptx=False, module_dir=folder)
        (binary,) = Path(folder).glob("*.cubin")
        usage, code = (
            subprocess.run([program, option, binary], capture_output=True, text=True, check=True).stdout
            for option in ("-res-usage", "-sass")
        )
    parts = {part.split(maxsplit=1)[0]: part for part in code.split("Function : ")[1:]}
    return {
        each["name"]: Resources(
            int(each["registers"]),
            int(each["stack"]),
            len(INSTRUCTION.findall(parts[f"{each['name']}_cuda_kernel_forward"])),
        )
        for each in USAGE.finditer(usage)
    }


def short_name(kernel: wp.Kernel) -> str:
    """The name of the function that became a kernel."""
    return kernel.key.rpartition("__")[2]
