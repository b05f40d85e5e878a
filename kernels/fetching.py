"""Memory that is asked for before it is read, so that a kernel computes while it comes."""

import warp as wp

from .lane_types import ALL_LANE_TYPES, GPU_LANE_COUNT

# Warp's arrays may overlap for all that the compiler knows: on a GPU what is read after a write waits for the memory,
# unless it is in the cache by then.
for _types in ALL_LANE_TYPES:

    @wp.func_native("""
    #if defined(__CUDA_ARCH__)
        for (int row = first; row < first + count; ++row)
            asm volatile("prefetch.global.L1 [%0];" : : "l"(&wp::index(source, row, block)));
    #endif
    """)
    def expect_rows(source: wp.array2d(dtype=_types.lanes), first: wp.int32, count: wp.int32, block: wp.int32):
        """On a GPU, start to fetch ``count`` rows from ``first`` on, which are read later."""

    @wp.func_native("""
    #if defined(__CUDA_ARCH__)
        asm volatile("prefetch.global.L1 [%0];" : : "l"(&wp::index(source, block)));
    #endif
    """)
    def expect(source: wp.array(dtype=_types.lanes), block: wp.int32):
        """On a GPU, start to fetch what is read later."""


def _line_by_line(place: str) -> str:
    """C++ that starts to fetch the lanes at ``place``, by lines of the cache; nothing fails behind the last block."""
    return f"""
        const char *lanes = reinterpret_cast<const char *>(source.data) + {place};
        for (unsigned at = 0; at < sizeof(*source.data); at += 64)
            __builtin_prefetch(lanes + at);
    """


# A processor computes on a block of sixteen for longer than the memory takes, but looks only some hundred instructions
# ahead, and no further than a page: large sheets would wait for the memory first, then compute.
_KINDS = {kind for each in ALL_LANE_TYPES if each.lane_count > GPU_LANE_COUNT for kind in (each.lanes, each.indices)}
for _kind in _KINDS:

    @wp.func_native(f"""
    #if !defined(__CUDACC__)
        for (int row = first; row < first + count; ++row) {{
            {_line_by_line("size_t(source.strides[0]) * row + size_t(source.strides[1]) * (block + 1)")}
        }}
    #endif
    """)
    def expect_next(source: wp.array2d(dtype=_kind), first: wp.int32, count: wp.int32, block: wp.int32):
        """On a CPU, start to fetch ``count`` rows from ``first`` on of the block after this one."""

    @wp.func_native(f"""
    #if !defined(__CUDACC__)
        {_line_by_line("size_t(source.strides[0]) * (block + 1)")}
    #endif
    """)
    def expect_next(source: wp.array(dtype=_kind), block: wp.int32): ...
