"""A barrier between CPU threads that replay recorded launches; never used on a GPU."""

import warp as wp


# Spinning answers within a microsecond while every thread has a core. Where threads share cores, the one that waits
# gives its core away after a while (a pause is up to 140 cycles): soon enough to be cheap, not so often that the
# scheduler gives whole slices to others (docs/decisions/0017).
@wp.func_native("""
    int *p = &wp::index(counter, 0);
    const int arrived = __atomic_add_fetch(p, 1, __ATOMIC_ACQ_REL);
    const int target = ((arrived + thread_count - 1) / thread_count) * thread_count;
    for (int spin = 0; __atomic_load_n(p, __ATOMIC_ACQUIRE) < target; ++spin) {
#if defined(__x86_64__)
        __builtin_ia32_pause();
#if defined(__linux__)
        if (spin > 400 && spin % 64 == 0) {
            extern int give_core_away() __asm__("sched_yield");
            give_core_away();
        }
#endif
#endif
    }
""")
def wait_for_all(counter: wp.array(dtype=wp.int32), thread_count: wp.int32): ...


@wp.kernel(module="unique", enable_backward=False)
def barrier(counter: wp.array(dtype=wp.int32), thread_count: wp.int32):
    """Launched once by each of ``thread_count`` threads; the counter starts at 0 and is reset between replays."""
    wait_for_all(counter, thread_count)
