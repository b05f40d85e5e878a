"""Samples of a tool that a command computed serve the next one, with the same bits, until their input changes."""

import os

import numpy as np
import pytest
import warp as wp

from weavesim import kernel_cache
from weavesim.kernel_cache import SEAL_NAME, modules, remove_unused
from weavesim.tools import sampling
from weavesim.tools.mesh_tool import MeshSurface
from weavesim.tools.samples import stored as stored_module
from weavesim.tools.samples.stored import samples_stored

# A pyramid with sharp edges, at which samples are doubted.
VERTICES = np.array([[-0.02, -0.02, 0.0], [0.02, -0.02, 0.0], [0.02, 0.02, 0.0], [-0.02, 0.02, 0.0], [0.0, 0.0, 0.03]])
FACES = np.array([[0, 2, 1], [0, 3, 2], [0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]])


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """Beside no kernels, which would be compiled again."""
    folder_of = kernel_cache.folder_of
    monkeypatch.setattr(kernel_cache, "folder_of", lambda *given: tmp_path / folder_of(*given).name)
    return tmp_path


def sampled(vertices=VERTICES, thickness=0.001):
    """As in a process of its own."""
    return sampling._sample(MeshSurface(vertices, FACES, spacing=0.002), "cpu", thickness, thickness, None)


def bits(samples):
    arrays = (samples.values, *samples.others)
    numbers = (samples.largest_error, samples.usual_error, samples.mean_error, samples.tolerance, samples.reach)
    return [array.numpy().tobytes() for array in arrays], numbers, samples.worst_points.tobytes()


@pytest.fixture
def never(monkeypatch):
    """Call it to have nothing that takes long computed any more."""

    def refuse(*arguments):
        raise AssertionError("computed again")

    def begin():
        monkeypatch.setattr(sampling, "filled_values", refuse)
        monkeypatch.setattr(sampling, "doubted_cells", refuse)
        monkeypatch.setattr("weavesim.tools.samples.candidates._lists", refuse)

    return begin


def folders(cache):
    return sorted(path.name for path in cache.iterdir())


def test_the_next_command_reads_the_same_bits(cache, never):
    expected = bits(sampled())
    assert folders(cache) == []  # only a command keeps any
    with samples_stored():
        assert bits(sampled()) == expected
        (folder,) = modules(cache)
        assert folder.has_samples and folder.size > 1000
        never()
        assert bits(sampled()) == expected
    assert folders(cache) == [folder.folder.name]
    with pytest.raises(AssertionError, match="computed again"):
        sampled()


@pytest.mark.parametrize(
    "given", [{"vertices": VERTICES * (1.0, 1.0, 1.0 + 1e-6)}, {"thickness": 0.0011}], ids=["vertex", "thickness"]
)
def test_other_input_has_other_samples(cache, given):
    with samples_stored():
        sampled()
        sampled(**given)
    assert len(folders(cache)) == 2


def test_other_code_has_other_samples(cache, monkeypatch, tmp_path_factory):
    one = tmp_path_factory.mktemp("code") / "tiles.py"
    names, inputs = [cache / "wp_fill_1234567"], (1.0, np.arange(3))
    keys = set()
    for text in ("x = 1", "x = 2"):
        one.write_text(text)
        keys.add(stored_module._digest(names, [str(one)], inputs))
    keys.add(stored_module._digest([cache / "wp_fill_7654321"], [str(one)], inputs))
    keys.add(stored_module._digest(names, [str(one)], (1.0, np.arange(3, dtype=np.int32))))
    assert len(keys) == 4
    keys.add(stored_module._digest(names, [str(one)], inputs))
    assert len(keys) == 4


@pytest.mark.parametrize("name", ["values.npy", "first.npy", SEAL_NAME])
@pytest.mark.parametrize("damage", ["cut", "flipped", "gone"])
def test_what_is_damaged_is_computed_again(cache, name, damage):
    with samples_stored():
        expected = bits(sampled())
        file = modules(cache)[0].folder / name
        content = bytearray(file.read_bytes())
        content[-1] ^= 1
        if damage == "gone":
            file.unlink()
        else:
            file.write_bytes(content if damage == "flipped" else content[: len(content) // 2])
        assert bits(sampled()) == expected
        assert bits(sampled()) == expected
    assert len(folders(cache)) == 1


def test_a_cache_that_cannot_be_written_is_left(cache, monkeypatch):
    def refuse(*arguments, **options):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "save", refuse)
    with samples_stored():
        assert bits(sampled()) == bits(sampled())
    assert folders(cache) == []


def test_large_samples_are_not_kept(cache, monkeypatch):
    monkeypatch.setattr(stored_module, "LARGEST_SIZE", 1000)
    with samples_stored():
        sampled()
    assert folders(cache) == []


def test_samples_have_a_limit_of_their_own(tmp_path):
    for name, age in (("wp_kernel_1234567", 3e5), ("samples_1", 2e5), ("samples_2", 4e3), ("samples_3", 1.0)):
        folder = tmp_path / name
        folder.mkdir()
        (folder / "values.npy").write_bytes(bytes(1000))
        (folder / SEAL_NAME).write_text("{}")
        then = folder.stat().st_mtime - age
        os.utime(folder, (then, then))
    remove_unused(tmp_path, largest_size=1100, largest_samples_size=2100)
    assert folders(tmp_path) == ["samples_2", "samples_3", "wp_kernel_1234567"]
    remove_unused(tmp_path, largest_size=1100, largest_samples_size=0)
    assert folders(tmp_path) == ["wp_kernel_1234567"]
    remove_unused(tmp_path, largest_size=0)
    assert folders(tmp_path) == []


def test_nothing_is_kept_of_another_device():
    device = type("Cuda", (), {"is_cpu": False})()
    with samples_stored():
        kept = stored_module.StoredArrays([], [], lambda: pytest.fail("copied from the device"), device)
    kept.add(values=wp.zeros(3, device="cpu"))
    kept.keep()
    assert kept.get("values") is None
