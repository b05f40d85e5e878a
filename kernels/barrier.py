"""A barrier between CPU threads that replay recorded launches; never used on a GPU."""

import warp as wp


@wp.func_native("""
    int *p = &wp::index(counter, 0);
    const int arrived = __atomic_add_fetch(p, 1, __ATOMIC_ACQ_REL);
    const int target = ((arrived + thread_count - 1) / thread_count) * thread_count;
    while (__atomic_load_n(p, __ATOMIC_ACQUIRE) < target) {
#if defined(__x86_64__)
        __builtin_ia32_pause();
#endif
    }
""")
def wait_for_all(counter: wp.array(dtype=wp.int32), thread_count: wp.int32): ...


@wp.kernel(module="unique", enable_backward=False)
def barrier(counter: wp.array(dtype=wp.int32), thread_count: wp.int32):
    """Launched once by each of ``thread_count`` threads; the counter starts at 0 and is reset between replays."""
    wait_for_all(counter, thread_count)
