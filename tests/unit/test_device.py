"""Devices, threads, and a kernel cache of each processor's own."""

import logging
import os
import subprocess
import sys

import numpy as np
import pytest
import warp as wp

from weavesim import device as device_module
from weavesim.device import (
    LARGEST_THREAD_COUNT,
    PARTS_PER_THREAD,
    cpu_features,
    initialise,
    kernel_cache_folder,
    launch_on_all_cores,
    resolve_device,
    resolve_precision,
    resolve_thread_counts,
)
from weavesim.errors import InputError
from weavesim.kernels.contact.fill_samples import mark_cells_kernel
from weavesim.kernels.contact.mesh_samples import TILE_STRIDE
from weavesim.kernels.contact.nearest_triangle import CELL_COUNT


@pytest.fixture
def features(monkeypatch):
    """Sets what the processor is said to be able to do."""

    def set_features(text: str) -> None:
        monkeypatch.setattr(device_module, "cpu_features", lambda: text)

    return set_features


def test_precision_has_matching_types(precision):
    array = wp.zeros(1, dtype=precision.real, device="cpu")
    assert array.numpy().dtype == precision.numpy == np.dtype(str(precision))


def test_unknown_precision_is_refused():
    with pytest.raises(InputError, match="float16.*choose float32 or float64"):
        resolve_precision("float16")


def test_device_is_found(device):
    assert resolve_device(device).alias == device


@pytest.mark.parametrize("name", ["cuda:99", "gpu", ""])
def test_unknown_device_is_refused_with_those_there_are(name):
    with pytest.raises(InputError, match="choose one of cpu"):
        resolve_device(name)


def test_cpu_features_are_known_and_stable():
    assert cpu_features() and cpu_features() == cpu_features()


def test_cache_folder_differs_by_cpu_features(features, monkeypatch, tmp_path):
    monkeypatch.delenv("WARP_CACHE_PATH", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    features("avx avx2")
    older = kernel_cache_folder()
    features("avx avx2 avx512f")
    newer = kernel_cache_folder()
    assert older != newer and older.parent == newer.parent
    features("avx avx2")
    assert kernel_cache_folder() == older


def test_cache_path_of_the_environment_is_kept_apart_too(features, monkeypatch, tmp_path):
    monkeypatch.setenv("WARP_CACHE_PATH", str(tmp_path))
    features("avx")
    folder = kernel_cache_folder()
    features("neon")
    assert folder.parent == tmp_path and kernel_cache_folder() not in (folder, tmp_path)


def test_initialise_twice_is_once():
    initialise()
    folder = wp.config.kernel_cache_dir
    initialise()
    assert wp.config.kernel_cache_dir == folder


def initialise_elsewhere(code: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """Start Warp in a separate process."""
    return subprocess.run(
        [sys.executable, "-c", code], env={**os.environ, **environment}, capture_output=True, text=True
    )


def test_cache_folder_set_by_the_user_is_left(tmp_path):
    code = (
        f"import warp as wp; wp.config.kernel_cache_dir = {str(tmp_path)!r};"
        "from weavesim.device import initialise; initialise(); print(wp.config.kernel_cache_dir)"
    )
    assert initialise_elsewhere(code).stdout.startswith(str(tmp_path))


def test_cache_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "file").write_text("")
    code = "from weavesim.device import initialise; initialise()"
    done = initialise_elsewhere(code, WARP_CACHE_PATH=str(tmp_path / "file"))
    assert done.returncode == 1
    assert "InputError" in done.stderr and "WARP_CACHE_PATH" in done.stderr


@pytest.mark.parametrize(
    ("cores", "counts"), [(1, (1,)), (2, (1, 2)), (3, (1, 2, 3)), (6, (1, 2, 4, 6)), (16, (1, 2, 4, 8, 16))]
)
def test_without_a_number_up_to_all_cores_may_be_taken(monkeypatch, cores, counts):
    monkeypatch.setattr(device_module, "available_threads", lambda: cores)
    assert resolve_thread_counts(None) == counts


def test_without_a_number_no_more_than_the_largest_are_taken(monkeypatch):
    monkeypatch.setattr(device_module, "available_threads", lambda: 3 * LARGEST_THREAD_COUNT)
    assert resolve_thread_counts(None)[-1] == LARGEST_THREAD_COUNT


@pytest.mark.parametrize("threads", [0, -1, LARGEST_THREAD_COUNT + 1])
def test_impossible_thread_count_is_refused(threads):
    with pytest.raises(InputError, match=f"{threads} threads .*choose 1 to {LARGEST_THREAD_COUNT}"):
        resolve_thread_counts(threads)


def test_more_threads_than_cores_are_warned_about(caplog, monkeypatch):
    monkeypatch.setattr(device_module, "available_threads", lambda: 2)
    with caplog.at_level(logging.WARNING, "weavesim"):
        assert resolve_thread_counts(2) == (2,)
        assert not caplog.messages
        assert resolve_thread_counts(3) == (3,)
    assert "3 threads share 2 cores" in caplog.messages[0]


def marked_tiles(count, launch):
    """Tiles whose cells of odd numbers are marked by ``launch`` of arguments for a part of them."""
    doubted = wp.array(np.arange(count * CELL_COUNT).reshape(count, CELL_COUNT) % 2, dtype=wp.uint8, device="cpu")
    values = wp.full(count * int(TILE_STRIDE), 6, dtype=wp.int32, device="cpu")
    launch(lambda own: [doubted[own], values[int(TILE_STRIDE) * own.start : int(TILE_STRIDE) * own.stop]])
    return values.numpy()


@pytest.mark.parametrize("count", [1, 5, 100])
@pytest.mark.parametrize("cores", [1, 3])
def test_a_launch_in_parts_does_everything_once(monkeypatch, count, cores):
    monkeypatch.setattr(device_module, "available_threads", lambda: cores)
    parts = []

    def in_parts(arguments):
        counts = (count, int(CELL_COUNT))
        launch_on_all_cores(mark_cells_kernel, counts, lambda own: parts.append(own) or arguments(own), "cpu")

    def at_once(arguments):
        wp.launch(mark_cells_kernel, (count, int(CELL_COUNT)), arguments(slice(0, count)), device="cpu")

    np.testing.assert_array_equal(marked_tiles(count, in_parts), marked_tiles(count, at_once))
    assert np.count_nonzero(marked_tiles(count, at_once) == 7) == count * CELL_COUNT // 2
    assert len(parts) == min(count, 1 if cores == 1 else 3 * PARTS_PER_THREAD)


def test_nothing_is_launched_over_nothing():
    launch_on_all_cores(mark_cells_kernel, (0, int(CELL_COUNT)), lambda own: pytest.fail("asked for"), "cpu")


def test_an_error_in_a_part_of_a_launch_is_raised(monkeypatch):
    monkeypatch.setattr(device_module, "available_threads", lambda: 2)
    monkeypatch.setattr(wp.Launch, "launch", lambda self: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        marked_tiles(4, lambda arguments: launch_on_all_cores(mark_cells_kernel, (4, 512), arguments, "cpu"))
