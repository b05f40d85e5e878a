"""How long a step should take on a device, from registers, instructions and bytes: what a measurement can contradict.

Three numbers were read off measurements on an H200 (docs/gpu.md): ``CYCLES`` from the kernel of the elements at 5,041
elements in float32, ``BANDWIDTH_SHARE`` from the free patch of a million in float32, ``SHORTEST`` from kernels that do
next to nothing. All else follows from data sheets and from the record of the kernels.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from .record import Record

WARP = 32
BLOCK_WARPS = 2  # blocks of 64 threads
REGISTERS = 65_536  # of a multiprocessor (compute capability 8.0 and 9.0, CUDA C++ Programming Guide, table of limits)
LARGEST_WARPS, LARGEST_BLOCKS = 64, 32  # likewise
GRAIN = 8  # registers of a thread are given out in eights
SCHEDULERS = 4  # each issues an instruction a cycle
LANES = 128  # for float32 in a multiprocessor: two operations each in a cycle

# Cycles from one instruction of a warp to its next, for each that is in the binary, executed or not: 7.7 us.
CYCLES = 5.5
BANDWIDTH_SHARE = 0.59  # of that to memory, which a step reaches
SHORTEST = 2.0e-6  # of a kernel in a graph [s]
REFRESH = 20  # steps


@dataclass(frozen=True)
class Device:
    """From a data sheet: multiprocessors, operations a second in float32, double over single, bytes a second."""

    name: str
    multiprocessors: int
    peak: float
    double_share: float
    bandwidth: float

    @property
    def clock(self) -> float:
        """[1/s]"""
        return self.peak / (2 * LANES * self.multiprocessors)


# NVIDIA H100 and H200 Tensor Core GPU data sheets (SXM): 67 and 34 TFLOPS, 3.35 and 4.8 TB/s. The number of
# multiprocessors is that of the white paper "NVIDIA H100 Tensor Core GPU Architecture".
H100 = Device("H100 SXM", 132, 67e12, 0.5, 3.35e12)
H200 = Device("H200 SXM", 132, 67e12, 0.5, 4.8e12)


@dataclass(frozen=True)
class Work:
    """A kernel: what a thread needs, and whether it computes in double precision."""

    registers: int
    instructions: int
    double: bool = False


def resident_warps(registers: int) -> int:
    """Warps that a multiprocessor holds at once."""
    of_block = BLOCK_WARPS * WARP * GRAIN * math.ceil(registers / GRAIN)
    return BLOCK_WARPS * min(LARGEST_BLOCKS, LARGEST_WARPS // BLOCK_WARPS, REGISTERS // of_block)


def kernel_time(work: Work, count: int, device: Device) -> float:
    """Of one thread per element [s], were memory no limit.

    The instructions of a thread follow one another; what does not fit at once waits for a place. Schedulers issue no
    faster than one instruction a cycle, in double precision a part of that.
    """
    warps = math.ceil(count / WARP) / device.multiprocessors
    alone = work.instructions * CYCLES / device.clock
    rounds = max(1.0, warps / resident_warps(work.registers))
    issue = work.instructions * warps / SCHEDULERS / device.clock / (device.double_share if work.double else 1.0)
    return max(SHORTEST, rounds * alone, issue)


@dataclass(frozen=True)
class Predicted:
    """A step [s], and which of its bounds it is."""

    case: str
    count: int
    precision: str
    step: float
    bound: str


def step_time(
    every_step: Sequence[Work], refresh: Sequence[Work], moved_bytes: float, count: int, device: Device
) -> tuple[float, str]:
    """Time of a step [s] and what bounds it.

    Args:
        every_step: kernels of a step, one after the other.
        refresh: further ones every ``REFRESH`` steps.
        moved_bytes: per element and step.
        count: of the elements.
        device: of the run.
    """
    kernels = sum(kernel_time(work, count, device) for work in every_step)
    kernels += sum(kernel_time(work, count, device) for work in refresh) / REFRESH
    memory = moved_bytes * count / (BANDWIDTH_SHARE * device.bandwidth)
    if memory > kernels:
        return memory, "memory"
    places = device.multiprocessors * min(resident_warps(work.registers) for work in every_step)
    return kernels, "registers" if count > WARP * places else "latency"


# Kernels of a step and of its refresh.
EVERY_STEP = ("element_forces", "node_motion")
REFRESHED = ("element_frequencies", "partial_maximum", "set_step")
# Bytes per element that a step moves, by who asks for its kernels in the record (scripts/benchmark.py counts).
MOVED = {
    "free patch": {"float32": 701.0, "float64": 1366.0},
    "double-dome": {"float32": 778.0, "float64": 1519.0},
}
SIZES = (5_000, 100_000, 1_000_000, 10_000_000)
# On an H200 on 26 November 2026, commit 0e2b230 and, where it was repeated on another one, b4d5f99 [us]. The double
# dome meets its tools at nodes only.
MEASURED: dict[tuple[str, int, str], tuple[float, ...]] = {
    ("free patch", 1_024, "float32"): (12.2,),
    ("free patch", 5_041, "float32"): (12.5, 12.4),
    ("free patch", 10_000, "float32"): (12.8,),
    ("free patch", 99_856, "float32"): (25.3, 30.1),
    ("free patch", 1_000_000, "float32"): (222.0, 245.0),
    ("free patch", 9_998_244, "float32"): (2060.0,),
    ("free patch", 5_041, "float64"): (17.8, 18.5),
    ("free patch", 1_000_000, "float64"): (470.0, 555.0),
    ("double-dome", 5_076, "float32"): (19.5, 20.3),
    ("double-dome", 5_076, "float64"): (23.2, 21.9),
}


def predicted(record: Record, device: Device, case: str, count: int, precision: str) -> Predicted:
    """A step of a case, with the kernels of the record for compute capability 9.0.

    Raises:
        ValueError: one of them is not in the record.
    """
    double = precision == "float64"

    def works(names: Sequence[str]) -> Iterator[Work]:
        for name in names:
            needs = record.bound(name, precision, [case], 90)
            if needs is None:
                raise ValueError(f"{name} of the {case} in {precision} is not in the record")
            yield Work(needs.registers, needs.instructions, double)

    time, bound = step_time([*works(EVERY_STEP)], [*works(REFRESHED)], MOVED[case][precision], count, device)
    return Predicted(case, count, precision, time, bound)
