"""A damaged cache of kernels heals, a full one is left aside, and both are said."""

import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pytest
import warp as wp

from tests.support.processes import environment
from weavesim import kernel_cache
from weavesim.kernel_cache import SEAL_NAME, damage, modules, own_folders, remove_unused

SLOW = pytest.mark.slow
LAUNCH = """
import sys
import warp as wp
from weavesim.device import initialise, load_kernel
from weavesim.kernels import machine
initialise()
for name in sys.argv[1:]:
    load_kernel(getattr(machine, name), wp.get_device("cpu"))
counts = wp.zeros(1, dtype=wp.int32, device="cpu")
if "barrier" in sys.argv:
    wp.launch(machine.barrier, dim=1, inputs=[counts, 1], device="cpu")
if "flush_subnormals" in sys.argv:
    wp.launch(machine.flush_subnormals, dim=1, inputs=[counts], device="cpu")
    wp.launch(machine.restore_subnormals, dim=1, inputs=[counts], device="cpu")
print(wp.config.kernel_cache_dir)
"""
# Each of these has a module of its own.
KERNELS = ("barrier", "flush_subnormals", "restore_subnormals")


def launch(cache, *names, **given):
    """Launch kernels, by default one, in a process of its own."""
    return subprocess.run(
        [sys.executable, "-c", LAUNCH, *(names or KERNELS[:1])], env=environment(WARP_CACHE_PATH=str(cache)),
        capture_output=True, text=True, check=False, **given,
    )  # fmt: skip


@pytest.fixture(scope="module")
def several(tmp_path_factory):
    """A cache with some kernels."""
    cache = tmp_path_factory.mktemp("several")
    done = launch(cache, *KERNELS)
    assert done.returncode == 0 and done.stderr == ""
    return cache


@pytest.fixture(scope="module")
def whole(several, tmp_path_factory):
    """A cache with one of them."""
    cache = shutil.copytree(several, tmp_path_factory.mktemp("one") / "cache")
    for name in KERNELS[1:]:
        shutil.rmtree(folder_of(cache, name))
    return cache


def folder_of(cache, name):
    """Of the kernel with this name."""
    return next(path for path in cache.rglob(f"wp_{name}*") if path.is_dir())


def parts(cache):
    """Object file, description and seal of the kernel."""
    return [next(cache.rglob(pattern)) for pattern in ("*.o", "*.meta", SEAL_NAME)]


def into_folder(file):
    file.unlink()
    file.mkdir()


def flipped(file):
    content = bytearray(file.read_bytes())
    content[len(content) // 2] ^= 1
    file.write_bytes(content)


DAMAGES = {
    "object is empty": (0, lambda file: file.write_bytes(b"")),
    "object is cut": (0, lambda file: file.write_bytes(file.read_bytes()[:-10])),
    "object is half": (0, lambda file: file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])),
    "object is zero": (0, lambda file: file.write_bytes(bytes(file.stat().st_size))),
    "object is text": (0, lambda file: file.write_text("no object")),
    "a bit has flipped": (0, flipped),
    "object is a folder": (0, into_folder),
    "description is empty": (1, lambda file: file.write_bytes(b"")),
    "description is garbage": (1, lambda file: file.write_text("{ garbage")),
    "description is binary": (1, lambda file: file.write_bytes(b"\xff\xfe\0")),
    "description is a list": (1, lambda file: file.write_text("[]")),
    "seal is garbage": (2, lambda file: file.write_text("{ garbage")),
}


@pytest.mark.parametrize("name", DAMAGES)
def test_damage_is_found(whole, tmp_path, name):
    cache = shutil.copytree(whole, tmp_path / "cache")
    folder = parts(cache)[0].parent
    assert damage(folder) == ""
    place, break_it = DAMAGES[name]
    break_it(parts(cache)[place])
    assert damage(folder) != ""


def broken(several, tmp_path, names):
    """A copy of the cache in which one kernel after the other is damaged in these ways."""
    cache = shutil.copytree(several, tmp_path / "cache")
    for kernel, name in zip(KERNELS, names, strict=True):
        place, break_it = DAMAGES[name]
        break_it(parts(folder_of(cache, kernel))[place])
    return cache


@pytest.mark.parametrize(
    "names",
    [
        ("object is cut", "object is zero", "a bit has flipped"),
        pytest.param(("description is garbage", "object is text", "object is half"), marks=SLOW),
    ],
    ids=" ".join,
)
def test_damaged_kernels_are_compiled_again_and_said(several, tmp_path, names):
    cache = broken(several, tmp_path, names)
    folders = [folder_of(cache, kernel) for kernel in KERNELS]
    done = launch(cache, *KERNELS)
    assert done.returncode == 0 and "Traceback" not in done.stderr
    for folder in folders:
        (said,) = [line for line in done.stderr.splitlines() if str(folder) in line]
        assert "is damaged" in said and "compiled again" in said
    again = launch(cache, *KERNELS)
    assert again.returncode == 0 and again.stderr == ""


@SLOW
def test_kernels_without_a_seal_heal_too(several, tmp_path):
    cache = broken(several, tmp_path, ("object is half", "object is zero", "object is text"))
    folders = [folder_of(cache, kernel) for kernel in KERNELS]
    for folder in folders:
        parts(folder)[2].unlink()
    done = launch(cache, *KERNELS)
    assert done.returncode == 0 and "Traceback" not in done.stderr
    for folder in folders:
        assert any("is damaged" in line and str(folder) in line for line in done.stderr.splitlines())


@SLOW
def test_a_kernel_without_a_seal_is_sealed(whole, tmp_path):
    cache = shutil.copytree(whole, tmp_path / "cache")
    object_file, description, seal = parts(cache)
    seal.unlink()
    assert launch(cache).stderr == ""
    assert set(json.loads(seal.read_text())) == {object_file.name, description.name}


def no_room():
    import resource

    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))


@pytest.fixture
def other_cache(monkeypatch, tmp_path):
    """Caches of this process in folders of the test."""

    monkeypatch.setattr(wp.config, "kernel_cache_dir", str(tmp_path / "no-room-here" / wp.config.version))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return wp.config


def refuse(*names):
    """Writing into folders with these names in their path fails, as on a full or read-only disk."""
    make = tempfile.NamedTemporaryFile

    def refusing(*arguments, dir=None, **given):
        if any(name in str(dir) for name in names):
            raise OSError(28, "No space left on device")
        return make(*arguments, dir=dir, **given)

    return refusing


def test_a_full_cache_is_left_for_a_temporary_one(other_cache, monkeypatch, caplog):
    monkeypatch.setattr(kernel_cache.tempfile, "NamedTemporaryFile", refuse("no-room-here"))
    before = other_cache.kernel_cache_dir
    kernel_cache.ensure_room()
    assert other_cache.kernel_cache_dir != before and os.path.isdir(os.path.dirname(other_cache.kernel_cache_dir))
    (message,) = caplog.messages
    assert before in message and "No space left on device" in message and "WARP_CACHE_PATH" in message
    kernel_cache.ensure_room()
    assert len(caplog.messages) == 1


def test_a_cache_with_room_is_kept(other_cache, caplog):
    before = other_cache.kernel_cache_dir
    kernel_cache.ensure_room()
    assert other_cache.kernel_cache_dir == before and caplog.messages == [] and os.listdir(before) == []


def test_what_ended_compilers_left_is_removed_after_a_day(other_cache):
    folder = Path(other_cache.kernel_cache_dir)
    old, new, kernel = (folder / name for name in ("wp_a_1234_p77_t140", "wp_b_1234_p78_t140", "wp_p1_t2_1234"))
    for path in (old, new, kernel):
        path.mkdir(parents=True)
        (path / "part.o").write_text("")
    for path in (old, kernel):
        os.utime(path, (0, 0))
    kernel_cache.ensure_room()
    assert not old.exists() and new.exists() and kernel.exists()


@SLOW
def test_no_room_anywhere_is_an_input_error(tmp_path):
    done = launch(tmp_path, preexec_fn=no_room)
    assert done.returncode != 0 and "InputError" in done.stderr and "free some space" in done.stderr


def test_a_home_that_cannot_be_written_is_no_obstacle(tmp_path):
    (tmp_path / "file").write_text("")
    settings = {name: value for name, value in environment().items() if name != "WARP_CACHE_PATH"}
    done = subprocess.run(
        [sys.executable, "-c", LAUNCH, "barrier"], env={**settings, "XDG_CACHE_HOME": str(tmp_path / "file")},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0 and "they go to" in done.stderr
    assert not os.path.exists(done.stdout.strip())  # removed at the end


def made(folder, name, size, age, *, sealed=True):
    """A module that was used ``age`` seconds ago, by weavesim if it is ``sealed``."""
    (folder / name).mkdir(parents=True)
    (folder / name / "kernel.o").write_bytes(bytes(size))
    if sealed:
        (folder / name / SEAL_NAME).touch()
    used = time.time() - age
    os.utime(folder / name, (used, used))


def names(folder):
    return sorted(module.folder.name for module in modules(folder))


def test_what_was_not_used_for_longest_is_removed_first(tmp_path):
    for name, size, age in (("old", 400, 3000.0), ("older", 300, 4000.0), ("new", 500, 2000.0), ("now", 600, 10.0)):
        made(tmp_path, name, size, age)
    remove_unused(tmp_path, largest_size=1800, unused_age=1000.0)
    assert names(tmp_path) == ["new", "now", "old", "older"]
    remove_unused(tmp_path, largest_size=1600, unused_age=1000.0)
    assert names(tmp_path) == ["new", "now", "old"]
    # what was just used stays, however large it is
    remove_unused(tmp_path, largest_size=0, unused_age=1000.0)
    assert names(tmp_path) == ["now"]
    made(tmp_path, "of others", 5000, 9000.0, sealed=False)
    remove_unused(tmp_path, largest_size=0, unused_age=0.0)
    assert names(tmp_path) == [] and (tmp_path / "of others" / "kernel.o").exists()
    remove_unused(tmp_path / "none", largest_size=0, unused_age=0.0)


def test_a_run_marks_the_modules_that_it_loads(whole):
    (module,) = [one for folder in own_folders(whole) for one in modules(folder)]
    os.utime(module.folder, (1.0, 1.0))
    assert launch(whole).returncode == 0
    (again,) = modules(module.folder.parent)
    assert time.time() - again.used < 600.0 and again.size == module.size > 1000


def test_the_cache_is_shown_and_cleared(tmp_path):
    cache = tmp_path / "cache"
    made(cache / "0123456789ab" / "1.19.0", "ours", 2_000_000, 0.0)
    made(cache / "of-others", "theirs", 10, 0.0, sealed=False)
    made(cache / "fedcba987654", "of others too", 10, 0.0, sealed=False)

    def command(*given):
        done = subprocess.run(
            [sys.executable, "-m", "weavesim", "cache", *given], env=environment(WARP_CACHE_PATH=str(cache)),
            capture_output=True, text=True, check=True,
        )  # fmt: skip
        return done.stdout

    shown = f"{cache / '0123456789ab' / '1.19.0'}: 1 compiled kernels, 2 MB\n"
    assert command() == shown and command("--clear") == f"{shown}Removed.\n"
    assert command() == f"{cache}: no compiled kernels\n"
    assert sorted(path.parent.name for path in cache.rglob("kernel.o")) == ["of others too", "theirs"]


@pytest.mark.skipif(os.name != "posix", reason="the system does not tell whether a process has ended")
def test_what_ended_compilers_left_is_cleared_at_once(tmp_path):
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    folder = tmp_path / "0123456789ab" / "1.0"
    for process in (ended.pid, os.getpid()):
        (folder / f"wp_module_p{process}_t1").mkdir(parents=True)
    kernel_cache.clear(tmp_path)
    assert [path.name for path in folder.iterdir()] == [f"wp_module_p{os.getpid()}_t1"]
    os.utime(folder / f"wp_module_p{os.getpid()}_t1", (0.0, 0.0))
    kernel_cache.clear(tmp_path)
    assert list(tmp_path.iterdir()) == []
