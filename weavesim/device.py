"""Where a run is computed: precision, device, threads, and the Warp settings for them.

Warp and NumPy are imported inside the functions, so that the command line can list these options without loading them.
"""

from __future__ import annotations

import hashlib
import logging
import os
import platform
import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from enum import StrEnum
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import kernel_cache
from .errors import InputError

if TYPE_CHECKING:
    import numpy as np
    import warp as wp

# Inlining and full-width vectors turn the lanes of kernels/ into SIMD code, see docs/performance.md; what is not moved
# behind a loop is not spilled before it (decision 70).
CPU_COMPILER_FLAGS = "-march=native -mllvm=-inline-threshold=4000 -mllvm=-instcombine-code-sinking=false"
X86_COMPILER_FLAGS = "-mprefer-vector-width=512"

LARGEST_THREAD_COUNT = 256
# Parts of a launch for each core, since they take unequal times.
PARTS_PER_THREAD = 8

logger = logging.getLogger(__name__)


class Precision(StrEnum):
    """Scalar type of all state and all kernels."""

    SINGLE = "float32"
    DOUBLE = "float64"

    @property
    def real(self) -> type:
        """Warp's scalar type."""
        import warp as wp

        return wp.float32 if self is Precision.SINGLE else wp.float64

    @property
    def numpy(self) -> np.dtype[Any]:
        """NumPy's scalar type."""
        import numpy as np

        return np.dtype(self.value)


def resolve_precision(name: str | Precision) -> Precision:
    """The precision called ``name``.

    Raises:
        InputError: for any other name than "float32" and "float64".
    """
    try:
        return Precision(name)
    except ValueError:
        raise InputError(f"Precision {name!r} is unknown: choose float32 or float64.") from None


@cache
def cpu_features() -> str:
    """Processor features as reported by the operating system; part of the kernel cache's name."""
    try:
        # Linux: x86 has "flags", ARM has "Features"; every core repeats them.
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith(("flags", "Features")):
                return " ".join(sorted(line.partition(":")[2].split()))
    except OSError:
        pass
    return platform.processor()


def user_cache_folder() -> Path:
    """This system's folder for files that programs can recreate."""
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local")
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")


def kernel_cache_base() -> Path:
    """Folder of the compiled kernels of all kinds of processors."""
    base = os.environ.get("WARP_CACHE_PATH")
    return Path(base) if base else user_cache_folder() / "weavesim"


def kernel_cache_folder() -> Path:
    """Folder of the compiled kernels, one per kind of processor.

    Kernels are compiled for the current processor, so code from one machine may not run on another that shares the
    home folder. The environment variable ``WARP_CACHE_PATH`` moves the whole cache.
    """
    identity = "\n".join((sys.platform, platform.machine(), cpu_features()))
    key = hashlib.sha256(identity.encode()).hexdigest()[:12]
    return kernel_cache_base() / key


@contextmanager
def _quiet_native_code() -> Iterator[None]:
    """Silence native code on standard error: it warns of a missing CUDA driver on every CPU-only machine."""
    with suppress(AttributeError, OSError, ValueError):  # it may be None, or closed
        sys.stderr.flush()
    try:
        kept = os.dup(2)
    except OSError:  # there is nothing to silence
        yield
        return
    try:
        with open(os.devnull, "wb") as nowhere:
            os.dup2(nowhere.fileno(), 2)
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)


@cache
def initialise() -> None:
    """Set up Warp once: quiet, with flags for the CPU's vector units and a kernel cache for this processor.

    A folder set in ``warp.config.kernel_cache_dir`` beforehand is kept, and so is a Warp that is already in use.

    Raises:
        InputError: if the kernel cache cannot be written.
    """
    import warp as wp

    wp.config.log_level = wp.LOG_WARNING
    x86 = platform.machine().lower() in ("x86_64", "amd64")
    wp.config.cpu_compiler_flags = f"{CPU_COMPILER_FLAGS} {X86_COMPILER_FLAGS}" if x86 else CPU_COMPILER_FLAGS
    folder = wp.config.kernel_cache_dir
    if folder is None:
        folder = wp.config.kernel_cache_dir = str(kernel_cache_folder())
        if "WARP_CACHE_PATH" not in os.environ:
            try:
                Path(folder).mkdir(parents=True, exist_ok=True)
            except OSError as error:
                kernel_cache.use_temporary(error)
    try:
        with _quiet_native_code():
            wp.init()
    except OSError as error:
        raise InputError(
            f"Compiled kernels cannot be stored in {folder}: {error.strerror or error}. "
            "Make that folder writable or set another one in the environment variable WARP_CACHE_PATH."
        ) from error


_one_at_a_time = threading.RLock()
_turn = threading.local()  # depth: contexts of ``exclusive`` that this thread is in


@contextmanager
def exclusive(*, announced: bool = True) -> Iterator[None]:
    """Let one thread of this process compute: Warp records the launches of all threads into one graph.

    Args:
        announced: log that this thread has to wait.
    """
    if not _one_at_a_time.acquire(blocking=False):
        if announced:
            logger.info("another thread of this program computes; this one waits until that is done")
        _one_at_a_time.acquire()
    _turn.depth = getattr(_turn, "depth", 0) + 1
    try:
        yield
    finally:
        _turn.depth -= 1
        _one_at_a_time.release()


@contextmanager
def giving_way() -> Iterator[None]:
    """Within ``exclusive``, let other threads compute while this one only replays on a CPU what it has recorded."""
    depth = getattr(_turn, "depth", 0)
    for _ in range(depth):
        _one_at_a_time.release()
    try:
        yield
    finally:
        for _ in range(depth):
            _one_at_a_time.acquire()


def device_names() -> list[str]:
    """Names of the devices of this machine: "cpu", then "cuda:0", "cuda:1", ..."""
    import warp as wp

    initialise()
    return [device.alias for device in wp.get_devices()]


def resolve_device(name: str) -> wp.Device:
    """The Warp device called ``name``: "cpu", "cuda:0", ..., or "cuda" for the first one.

    Raises:
        InputError: if this machine has no such device.
    """
    import warp as wp

    names = device_names()
    wanted = "cuda:0" if name == "cuda" else name
    if wanted not in names:
        why = "" if wp.is_cuda_available() or not wanted.startswith("cuda") else " Warp found no usable CUDA driver."
        raise InputError(f"Device {name!r} is not on this machine: choose one of {', '.join(names)}.{why}")
    return wp.get_device(wanted)


def is_cpu(name: str) -> bool:
    """Whether a device of this name is the CPU; nobody asks whether this machine has it."""
    return not name.startswith("cuda")


def load_kernel(kernel: wp.Kernel, device: wp.Device) -> None:
    """Compile a kernel if it is not in the cache, in the form that launches on this device use.

    Warp compiles for one block size; launches on a CPU use 1, whatever the module's own is, and would compile again.
    A kernel that is damaged in the cache is compiled again, once.

    Raises:
        InputError: a kernel can be stored nowhere.
    """
    is_compiled(kernel, device)  # removes a damaged one
    size = block_size(kernel, device)
    before = kernel_cache.folder_of(kernel, size)
    was_there = before.exists()
    try:
        _load(kernel, device, size)
    except Exception as error:
        kernel.module.unload()
        if was_there:
            kernel_cache.discard(before, f"{type(error).__name__}: {error}")
        else:
            kernel_cache.ensure_room()
            if kernel_cache.folder_of(kernel, size) == before:
                raise  # there was room: it does not compile
        _load(kernel, device, size)
    kernel_cache.seal(kernel_cache.folder_of(kernel, size))


def _load(kernel: wp.Kernel, device: wp.Device, size: int) -> None:
    loaded = kernel.module.load(device, block_dim=size)
    if loaded is None or not loaded.get_kernel_hooks(kernel).forward:
        raise RuntimeError("the kernel is not in its binary")


def is_compiled(kernel: wp.Kernel, device: wp.Device) -> bool:
    """Whether ``load_kernel`` will find a kernel in the cache; ``load_kernel`` need not compute its hash again.

    A damaged one is removed.
    """
    folder = kernel_cache.folder_of(kernel, block_size(kernel, device))
    binaries = {".o"} if device.is_cpu else {".ptx", ".cubin"}
    if reason := kernel_cache.damage(folder):
        kernel_cache.discard(folder, reason)
        return False
    return any(file.suffix in binaries for file in folder.glob("*"))


def block_size(kernel: wp.Kernel, device: wp.Device) -> int:
    """Threads of a block with which a kernel is compiled, and must be launched; 1 on a CPU."""
    return 1 if device.is_cpu else kernel.module.options["block_dim"]


def available_threads() -> int:
    """Number of CPU cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def launch_on_all_cores(
    kernel: wp.Kernel, counts: tuple[int, ...], arguments: Callable[[slice], list[Any]], device: str | wp.Device
) -> None:
    """Launch a kernel whose threads write nothing that others read; on a CPU in parts, on all cores.

    Args:
        kernel: what is launched.
        counts: of its threads along each dimension.
        arguments: all arguments of a launch for a part of the first dimension, whose threads count from zero.
        device: of the launch.
    """
    import warp as wp

    device, (count, *others) = wp.get_device(device), counts
    thread_count = min(available_threads(), LARGEST_THREAD_COUNT) if device.is_cpu else 1
    part_count = min(count, PARTS_PER_THREAD * thread_count if thread_count > 1 else 1)
    parts = [slice(count * k // part_count, count * (k + 1) // part_count) for k in range(part_count)]
    launches = [
        wp.launch(kernel, (own.stop - own.start, *others), arguments(own), device=device, record_cmd=True)
        for own in parts
    ]
    if len(launches) < 2:
        for launch in launches:
            launch.launch()
        return
    with ThreadPoolExecutor(thread_count) as pool:
        for done in [pool.submit(launch.launch) for launch in launches]:
            done.result()


def available_memory() -> float | None:
    """Memory that this process can still get [bytes], of the system and within its container; None if unknown."""
    found: list[float] = []
    with suppress(OSError, ValueError, IndexError):
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
        found += [1024.0 * float(line.split()[1]) for line in lines if line.startswith("MemAvailable:")]
    with suppress(OSError, ValueError):
        folder = Path("/sys/fs/cgroup")
        limit = float((folder / "memory.max").read_text(encoding="ascii"))  # "max" is no number
        found.append(limit - float((folder / "memory.current").read_text(encoding="ascii")))
    return min(found, default=None)


def resolve_thread_counts(threads: int | None) -> tuple[int, ...]:
    """Numbers of CPU threads that a run may use: ``threads`` if given and possible, else 1, 2, 4, ... and all cores.

    Raises:
        InputError: if ``threads`` is not between 1 and ``LARGEST_THREAD_COUNT``.
    """
    available = available_threads()
    if threads is None:
        largest = min(available, LARGEST_THREAD_COUNT)
        return (*(2**power for power in range((largest - 1).bit_length())), largest)
    if not 1 <= threads <= LARGEST_THREAD_COUNT:
        raise InputError(
            f"{threads} threads were requested: choose 1 to {LARGEST_THREAD_COUNT}, preferably no more than the "
            f"{available} cores that this process may use."
        )
    if threads > available:
        logger.warning("%d threads share %d cores: the result is the same, but takes longer.", threads, available)
    return (threads,)
