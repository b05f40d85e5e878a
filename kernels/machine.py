"""Processor control: a barrier between threads, the treatment of subnormal numbers, what a GPU has in registers."""

import warp as wp


# Spinning responds within a microsecond while every thread has a core. If threads share cores, a waiting thread yields
# its core after a while (a pause is up to 140 cycles): soon enough to be cheap, but not so often that the scheduler
# gives whole time slices to others (docs/decisions/0017). The compiler has no headers of the system: the function is
# declared by its name for the linker, which on macOS begins with a further line.
@wp.func_native("""
    int *p = &wp::index(counter, 0);
    const int arrived = __atomic_add_fetch(p, 1, __ATOMIC_ACQ_REL);
    const int target = ((arrived + thread_count - 1) / thread_count) * thread_count;
    int spin = 0;
    for (; __atomic_load_n(p, __ATOMIC_ACQUIRE) < target; ++spin) {
#if defined(__x86_64__)
        __builtin_ia32_pause();
#elif defined(__aarch64__)
        __asm__ volatile("isb");
#endif
#if defined(__unix__) || defined(__APPLE__)
        if (spin > 400 && spin % 64 == 0) {
#if defined(__APPLE__)
            extern int give_core_away() __asm__("_sched_yield");
#else
            extern int give_core_away() __asm__("sched_yield");
#endif
            give_core_away();
        }
#endif
    }
    return spin;
""")
def wait_for_all(counter: wp.array(dtype=wp.int32), thread_count: wp.int32) -> wp.int32:
    """Wait until all of ``thread_count`` threads have come here; returns how often this one has looked in vain."""


@wp.kernel(module="unique", enable_backward=False)
def barrier(counter: wp.array(dtype=wp.int32), thread_count: wp.int32):
    """Barrier, launched once by each of ``thread_count`` threads; the counter is reset to 0 between replays."""
    spins = wait_for_all(counter, thread_count)  # noqa: F841


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
    """Set how this thread treats subnormal numbers; returns the previous setting."""


FLUSH = wp.constant(0x8040)


@wp.kernel(module="unique", enable_backward=False)
def flush_subnormals(before: wp.array(dtype=wp.int32)):
    """From now on, this thread rounds subnormal numbers to zero; launched with a single thread."""
    before[0] = switch_flushing(FLUSH)


@wp.kernel(module="unique", enable_backward=False)
def restore_subnormals(before: wp.array(dtype=wp.int32)):
    """Restore the setting from before ``flush_subnormals``."""
    previous = switch_flushing(before[0])  # noqa: F841


@wp.kernel(module="unique", enable_backward=False)
def count_rounds(kept: wp.int32, more: wp.int32, count: wp.array(dtype=wp.int32)):
    """How often a recorded loop goes round: ``kept`` is 0 before its first round, and 1 at the end of each."""
    count[0] = kept * count[0] + more


@wp.func_native("""
    int result = index + 1;
#if defined(__CUDA_ARCH__)
    asm volatile("" : "+r"(result));
#endif
    return result;
""")
def following(index: wp.int32) -> wp.int32:
    """The next index of a loop. A GPU's compiler cannot count such a loop: it would have four copies of its body read
    ahead, and the registers for that are those of the whole kernel."""


@wp.func_native("""
    int result = index;
#if defined(__CUDA_ARCH__)
    asm volatile("" : "+r"(result));
#endif
    return result;
""")
def anew(index: wp.int32) -> wp.int32:
    """The same index. A GPU's compiler does not know that: what is there is read anew, where it would have been kept in
    registers since it was read before."""
