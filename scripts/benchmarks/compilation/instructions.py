"""Machine instructions of the kernels of a step on a CPU: a cost that is the same on every machine."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Annotated

import typer

from ...shared.kernel_content import content_of
from ...shared.report import table, write_json

if TYPE_CHECKING:
    import warp as wp

# Processors with AVX-512, all of whose features a compiler may use without asking this one.
PROCESSOR = "x86-64-v4"
PRECISIONS = ("float32", "float64")
RECORD = Path(__file__).resolve().parents[3] / "tests" / "data" / "instructions.json"


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
    """The kernels in sixteen lanes whose instructions are recorded, by name; nothing is compiled.

    Forces, nodes and stable step of the default double dome, its contact between nodes, forces and stable step with a
    cell that is given by its energy, and contact of plies and its search.
    """
    from weavesim.app.command_line import default_setups
    from weavesim.engine.compilation import KernelSet
    from weavesim.fabric.presets import UNIT_CELLS
    from weavesim.kernels.lane_types import CPU_LANE_COUNT

    def kernels(scene: str, cell: str | None = None, **parameters: object) -> dict[str, wp.Kernel]:
        """Of a scene with one lane of everything, by the names of their functions."""
        setups = default_setups([scene], precision=precision, **parameters)
        solver = setups[0].solver.model_copy(update={"device": "cpu", "lane_count": CPU_LANE_COUNT, "threads": 1})
        own = [setup.model_copy(update={"solver": solver}) for setup in setups[:1]]
        found = KernelSet.of_setups(own, UNIT_CELLS[cell]() if cell else None).kernels()
        return {kernel.key.rpartition("__")[2]: kernel for kernel in reversed(found)}

    dome, twill, stack = kernels("double-dome"), kernels("double-dome", "twill"), kernels("stack")
    return {
        "forces": dome["element_forces"],
        "nodes": dome["node_motion"],
        "stable step": dome["element_frequencies"],
        "contact between nodes": dome["surface_contact"],
        "forces, twill": twill["element_forces"],
        "stable step, twill": twill["element_frequencies"],
        "contact of plies": stack["meet_plies"],
        "search for feet": stack["seek_feet"],
    }


def content(kernel: wp.Kernel) -> str:
    """Hash of all that the instructions of a kernel follow from, but for Warp and its compiler."""
    with compiled_for(kernel, PROCESSOR):
        return content_of(kernel, lambda option: "cuda" in option)


@dataclass(frozen=True)
class Count:
    """Instructions of a kernel, and the content for which they were counted."""

    content: str
    instructions: int


def read_counts(path: Path = RECORD) -> tuple[str, dict[str, dict[str, Count]]]:
    """The version of Warp, and the counts by precision and name of the kernel."""
    stored = json.loads(path.read_text(encoding="utf-8"))
    counts = {precision: {name: Count(*each) for name, each in stored[precision].items()} for precision in PRECISIONS}
    return stored["warp"], counts


def instruction_table() -> str:
    """What is recorded, as Markdown."""
    _, counts = read_counts()
    names = dict.fromkeys(name for of in counts.values() for name in of)
    rows = [[name, *(f"{of[name].instructions:,}" if name in of else "" for of in counts.values())] for name in names]
    return table([f"kernel, {PROCESSOR}", *counts], rows, right=True)


def instructions(
    record: Annotated[bool, typer.Option(help="count what has changed since the record, and write it anew")] = False,
) -> None:
    """Machine instructions of the kernels of a step for processors with AVX-512, from the record."""
    if record:
        import warp as wp

        from weavesim.device import initialise

        initialise()
        before, known = read_counts() if RECORD.exists() else ("", {})
        new: dict[str, object] = {"warp": wp.config.version}
        for precision in PRECISIONS:
            counts: dict[str, tuple[str, int]] = {}
            for name, kernel in step_kernels(precision).items():
                now, was = content(kernel), known.get(precision, {}).get(name)
                same = was is not None and was.content == now and before == wp.config.version
                counts[name] = (now, was.instructions if was and same else instruction_count(kernel))
            new[precision] = counts
        write_json(RECORD, new)
    typer.echo(instruction_table())
