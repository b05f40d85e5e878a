"""Numbers too small for a full mantissa: a CPU takes a hundred times as long for them, so kernels round them to zero.

Ahead of every wave through a sheet run tails of it that fade below 1e-38; nothing of them is left in any result. Other
processors than x86, and GPUs, lose no time with such numbers.
"""

import warp as wp


@wp.func_native("""
#if defined(__x86_64__)
    const unsigned int flush_results_and_inputs = 0x8040;
    unsigned int mode = __builtin_ia32_stmxcsr();
    const int before = mode & flush_results_and_inputs;
    mode &= ~flush_results_and_inputs;
    mode |= wanted & flush_results_and_inputs;
    __builtin_ia32_ldmxcsr(mode);
    return before;
#else
    return 0;
#endif
""")
def switch_flushing(wanted: wp.int32) -> wp.int32:
    """Set how this thread treats subnormal numbers; how it did before."""


FLUSH = wp.constant(0x8040)


@wp.kernel(module="unique", enable_backward=False)
def flush_subnormals(before: wp.array(dtype=wp.int32)):
    """From here on this thread rounds subnormal numbers to zero; a single thread."""
    before[0] = switch_flushing(FLUSH)


@wp.kernel(module="unique", enable_backward=False)
def restore_subnormals(before: wp.array(dtype=wp.int32)):
    """As it was before ``flush_subnormals``."""
    previous = switch_flushing(before[0])  # noqa: F841
