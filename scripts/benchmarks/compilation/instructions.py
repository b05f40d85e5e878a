"""Machine instructions of the kernels of a step on a CPU: a cost that is the same on every machine."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import typer

from ...shared.report import table

if TYPE_CHECKING:
    import warp as wp

# Processors with AVX-512, all of whose features a compiler may use without asking this one.
PROCESSOR = "x86-64-v4"


@contextmanager
def compiled_for(kernel: wp.Kernel, processor: str) -> Iterator[None]:
    """Let the module of ``kernel`` be compiled for a processor, not for this one."""
    import warp as wp

    options = kernel.module.options
    before = options.get("cpu_compiler_flags")
    flags = before or wp.config.cpu_compiler_flags
    options["cpu_compiler_flags"] = flags.replace("-march=native", f"-target-cpu {processor}")
    try:
        yield
    finally:
        options["cpu_compiler_flags"] = before


def instruction_count(kernel: wp.Kernel, processor: str = PROCESSOR) -> int:
    """Instructions of a kernel and of all that it calls, whether they are executed or not; see instruction_names."""
    return len(instruction_names(kernel, processor))


def instruction_names(kernel: wp.Kernel, processor: str = PROCESSOR) -> list[str]:
    """Names of the instructions of a kernel and of all that it calls, without padding.

    Takes the packages capstone and pyelftools (extra ``test``), on Linux with an x86 processor of any kind.
    """
    import warp as wp
    from capstone import CS_ARCH_X86, CS_MODE_64, Cs
    from elftools.elf.constants import SH_FLAGS
    from elftools.elf.elffile import ELFFile

    with TemporaryDirectory() as folder, compiled_for(kernel, processor):
        wp.compile_aot_module(kernel.module, device="cpu", module_dir=folder)
        (path,) = Path(folder).glob("*.o")
        with path.open("rb") as file:
            sections = ELFFile(file).iter_sections()
            codes = [part.data() for part in sections if part.header["sh_flags"] & SH_FLAGS.SHF_EXECINSTR]
    decoder = Cs(CS_ARCH_X86, CS_MODE_64)
    decoder.skipdata = True
    names = [name for code in codes for _, _, name, _ in decoder.disasm_lite(code, 0)]
    return [name for name in names if not name.startswith(("nop", ".byte", "int3"))]


def step_kernels(precision: str) -> dict[str, wp.Kernel]:
    """Kernels of the forces, the nodes and the stable step of the default double dome in sixteen lanes, by name."""
    from weavesim import Simulation
    from weavesim.app.command_line import default_setups
    from weavesim.engine.launches import SheetKernels
    from weavesim.engine.setup import Solver
    from weavesim.kernels.lane_types import CPU_LANE_COUNT

    (setup,) = default_setups(["double-dome"], precision=precision)
    solver = Solver(precision=precision, device="cpu", lane_count=CPU_LANE_COUNT, threads=1)
    kernels = SheetKernels.of(Simulation(setup.model_copy(update={"solver": solver})).model.sheet)
    return {"forces": kernels.forces, "nodes": kernels.nodes, "stable step": kernels.frequencies}


def instructions() -> None:
    """Machine instructions of the kernels of a step of the default double dome, for processors with AVX-512."""
    counts = {
        precision: {name: instruction_count(kernel) for name, kernel in step_kernels(precision).items()}
        for precision in ("float32", "float64")
    }
    rows = [[name, *(str(of[name]) for of in counts.values())] for name in counts["float32"]]
    typer.echo(table([f"kernel, {PROCESSOR}", *counts], rows, right=True))
