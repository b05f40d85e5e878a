"""Warp types of lanes, and the compiler options of kernels that compute in them."""

import platform
from dataclasses import dataclass
from functools import cache
from typing import Any

import warp as wp

CPU_LANE_COUNT = 16
GPU_LANE_COUNT = 1

# Threads of a block on a GPU: few, so that a small sheet occupies every multiprocessor.
STEP_THREAD_COUNT = 64

# Sixteen scalars of single precision are read sooner one by one than by an AVX gather; eight of double are not.
NO_GATHER_FLAGS = "-target-feature +prefer-no-gather"
# As large as it takes: copies of structs at calls made up half of a pass between plies.
INLINING_FLAGS = "-mllvm -inline-threshold=200000"


@dataclass(frozen=True)
class LaneTypes:
    """Warp types of one precision and lane count."""

    real: type
    lane_count: int
    lanes: type
    lanes3: type
    lanes4: type
    indices: type
    vec3: type
    vec4: type


@cache
def lane_types(real: type, lane_count: int) -> LaneTypes:
    """Types for ``real`` (wp.float32 or wp.float64) and ``lane_count`` (1 or 16)."""
    return LaneTypes(
        real=real,
        lane_count=lane_count,
        lanes=wp.types.vector(lane_count, real),
        lanes3=wp.types.matrix((3, lane_count), real),
        lanes4=wp.types.matrix((4, lane_count), real),
        indices=wp.types.vector(lane_count, wp.int32),
        vec3=wp.types.vector(3, real),
        vec4=wp.types.vector(4, real),
    )


ALL_LANE_TYPES = tuple(
    lane_types(real, lane_count) for real in (wp.float32, wp.float64) for lane_count in (GPU_LANE_COUNT, CPU_LANE_COUNT)
)


def step_options(real: type, inlined: bool = False) -> dict[str, Any]:
    """Options of the modules of the kernels of a step: small blocks on a GPU; on x86, single precision without gathers.

    The flags of a module replace those of Warp's configuration, which are set before a kernel is made. ``inlined`` is
    for kernels of large functions whose structs would be copied at every call.
    """
    flags = wp.config.cpu_compiler_flags
    if flags and inlined:
        flags = f"{flags} {INLINING_FLAGS}"
    if real is wp.float64 or not flags or platform.machine().lower() not in ("x86_64", "amd64"):
        return {"block_dim": STEP_THREAD_COUNT} | ({"cpu_compiler_flags": flags} if flags and inlined else {})
    return {"block_dim": STEP_THREAD_COUNT, "cpu_compiler_flags": f"{flags} {NO_GATHER_FLAGS}"}
