"""A device function is hashed once for all kernels of a run, with the hashes of Warp (``weavesim.kernel_cache``)."""

import threading
from collections import Counter

import warp as wp
from warp._src import context

from weavesim import kernel_cache
from weavesim.app.command_line import SCENES, default_setups
from weavesim.engine.compilation import KernelSet
from weavesim.kernel_cache import hashed_once


def hash_of(*kernels):
    """Of a module of these kernels, as Warp computes it where nothing is remembered, or within ``hashed_once``."""
    # with its options: hashing also notes in a kernel whether its next build has a grid-stride loop
    return context.ModuleHasher(list(kernels), kernels[0].module.resolve_options(wp.config)).get_hash()


def test_a_kernel_that_was_hashed_is_built_as_before():
    kernel = next(iter(KernelSet.of_setups(default_setups(["double-dome"])).kernels()))
    hash_of(kernel)
    assert kernel.grid_stride is wp.config.default_grid_stride


def test_kernels_have_the_hashes_of_warp_and_no_function_is_hashed_twice(monkeypatch):
    hashed, plain = Counter(), context.ModuleHasher.hash_adjoint

    def counted(self, adjoint):
        hashed[adjoint] += 1
        return plain(self, adjoint)

    monkeypatch.setattr(context.ModuleHasher, "hash_adjoint", counted)
    every = KernelSet.of_setups(default_setups(SCENES)).kernels()
    expected = [hash_of(kernel) for kernel in every]
    assert max(hashed.values()) > 10
    hashed.clear()
    with hashed_once():
        assert [hash_of(kernel) for kernel in every] == expected
    assert len(hashed) > 100 and set(hashed.values()) == {1}
    assert [hash_of(kernel) for kernel in every[:3]] == expected[:3] and max(hashed.values()) > 1


def test_a_further_overload_changes_the_hash_of_what_calls_it_at_once():
    @wp.func
    def doubled(x: float):
        return 2.0 * x

    @wp.func
    def through(x: float):
        return doubled(x)

    @wp.kernel
    def calls(x: wp.array(dtype=float)):
        x[0] = through(x[0])

    with hashed_once():
        before = hash_of(calls)

        @wp.func
        def doubled(x: int):
            return 2 * x

        after = hash_of(calls)
    assert before != after == hash_of(calls)


@wp.func
def _first(x: float):
    return _second(x)


@wp.func
def _second(x: float):
    return _first(x)


@wp.kernel
def _calls_first(x: wp.array(dtype=float)):
    x[0] = _first(x[0])


@wp.kernel
def _calls_second(x: wp.array(dtype=float)):
    x[0] = _second(x[0])


def test_functions_that_call_each_other_are_hashed_with_both():
    kernels = (_calls_first, _calls_second)
    expected = [hash_of(kernel) for kernel in kernels]
    with hashed_once():
        assert [hash_of(kernel) for kernel in kernels] == expected
        assert [hash_of(kernel) for kernel in reversed(kernels)] == expected[::-1]


@wp.func
def _third(x: float):
    return 3.0 * x


@wp.kernel
def _calls_third(x: wp.array(dtype=float)):
    x[0] = _third(x[0])


def test_another_thread_is_left_alone():
    found = []

    def elsewhere():
        # what it remembers of Warp's own, so that nothing of this thread is there
        found.append(getattr(kernel_cache._hashing, "known", None))
        found.append(hash_of(_calls_third))

    with hashed_once():
        hash_of(_calls_third)
        thread = threading.Thread(target=elsewhere)
        thread.start()
        thread.join()
        assert kernel_cache._hashing.known
    assert found == [None, hash_of(_calls_third)]


def test_threads_that_hash_once_may_end_in_any_order_and_all_hear_of_an_overload():
    plain, add_overload = context.ModuleHasher, context.Function.add_overload
    knows, changed, ends = (threading.Event() for _ in range(3))
    found = []

    @wp.func
    def halved(x: float):
        return 0.5 * x

    @wp.kernel
    def calls_halved(x: wp.array(dtype=float)):
        x[0] = halved(x[0])

    def elsewhere():
        with hashed_once():
            found.append(hash_of(calls_halved))
            knows.set()
            assert changed.wait(30.0)
            found.append(hash_of(calls_halved))
            assert ends.wait(30.0)

    thread = threading.Thread(target=elsewhere)
    with hashed_once():
        thread.start()
        assert knows.wait(30.0)

        @wp.func
        def halved(x: int):
            return x // 2

        changed.set()
    assert context.ModuleHasher is not plain
    ends.set()
    thread.join()
    assert (context.ModuleHasher, context.Function.add_overload) == (plain, add_overload)
    assert found[0] != found[1] == hash_of(calls_halved)
