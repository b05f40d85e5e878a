"""The cache of compiled kernels heals itself: what is damaged is compiled again, what cannot be written goes elsewhere.

It does not grow for ever either: what no run has used for long is removed.

Warp keeps every module of kernels in a folder of its own. A seal beside its files, their SHA-256, tells damage that
would otherwise crash, or compute something else.
"""

from __future__ import annotations

import atexit
import hashlib
import json
import logging
import os
import re
import shutil
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .errors import InputError

if TYPE_CHECKING:
    import warp as wp

SEAL_NAME = "weavesim.seal"
# What Warp loads: object files of a CPU, binaries of a GPU, and what it knows about a module; and samples of tools.
LOADED = (".o", ".ptx", ".cubin", ".meta", ".npy")
# Begins the names of folders with samples of tools, which are modules in all but that Warp does not load them.
SAMPLES = "samples_"
# A kernel of a run takes up to this much.
PROBE_SIZE = 1 << 20

# Beyond this size [bytes] modules that no run has loaded for this long [s] are removed.
LARGEST_SIZE = 1 << 30
UNUSED_AGE = 24.0 * 3600.0
# So much of samples of tools is kept [bytes], whenever they were used: who tries many tools makes gigabytes an hour.
LARGEST_SAMPLES_SIZE = 1 << 29

# Our folders in the cache, one per kind of processor; others may keep theirs beside them.
OWN_FOLDER = re.compile(r"[0-9a-f]{12}")
# Folders in which Warp compiles, and an age at which no compiler is still at work in one [s].
LEFTOVER = re.compile(r"_p(\d+)_t\d+$")
LEFTOVER_AGE = 24.0 * 3600.0

logger = logging.getLogger(__name__)


def folder_of(kernel: wp.Kernel, block_size: int | None) -> Path:
    """Folder of the compiled module of a kernel."""
    import warp as wp

    return Path(str(wp.config.kernel_cache_dir)) / kernel.module.get_module_identifier(block_size)


def damage(folder: Path) -> str:
    """Why a compiled module cannot be used; "" if nothing speaks against it, or if there is none."""
    try:
        files = list(_loaded_files(folder))
        for file in files:
            if file.stat().st_size == 0:
                return f"{file.name} is empty"
            if file.suffix == ".meta" and not isinstance(json.loads(file.read_bytes()), dict):
                return f"{file.name} is damaged"
        seal = _seal(folder)
        sealed = (file for file in files if file.name in seal)
        return next((f"{file.name} has changed" for file in sealed if seal[file.name] != _hash(file)), "")
    except OSError as error:
        return f"it cannot be read ({error.strerror or error})"
    except ValueError:
        return "its description is damaged"


def seal(folder: Path) -> None:
    """Note the hashes of a module that was loaded, unless they are known; a folder that is read-only stays unsealed."""
    with suppress(OSError, ValueError):
        os.utime(folder)  # when it was used last
        files = list(_loaded_files(folder))
        if {file.name for file in files} - set(_seal(folder)):
            temporary = Path(tempfile.mkstemp(dir=folder, prefix=".seal")[1])
            temporary.write_text(json.dumps({file.name: _hash(file) for file in files}), encoding="utf-8")
            temporary.replace(folder / SEAL_NAME)


def discard(folder: Path, reason: str) -> None:
    """Remove a damaged module, which then is compiled again; where it cannot be removed, use another cache."""
    logger.warning("the compiled kernel in %s is damaged (%s) and is compiled again", folder, reason)
    try:
        shutil.rmtree(folder)
    except OSError as error:
        use_temporary(error)


def ensure_room() -> None:
    """Check that kernels can be written to the cache; if not, use a temporary one for this process.

    Raises:
        InputError: that cannot be written either.
    """
    import warp as wp

    folder = Path(str(wp.config.kernel_cache_dir))
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=folder, prefix=".probe") as probe:
            probe.write(bytes(PROBE_SIZE))
            probe.flush()
        _remove_leftovers(folder)
        remove_unused(folder)
    except OSError as error:
        use_temporary(error)


class _Open(set[Any]):
    """Functions that are being hashed.

    Attributes:
        circle_count: how often one was met that was being hashed.
        circular: functions whose hash depends on which one of a circle of calls is hashed first.
    """

    def __init__(self) -> None:
        super().__init__()
        self.circle_count, self.circular = 0, set[Any]()

    def __contains__(self, function: object) -> bool:
        found = super().__contains__(function)
        self.circle_count += found
        return found


_hashing = threading.local()  # known: hashes of functions, for a thread that is in ``hashed_once``
_changing = threading.Lock()
_remembered: list[dict[Any, bytes]] = []  # what the threads that are in ``hashed_once`` know
_replaced: list[Any] = []  # what was in Warp before


@contextmanager
def hashed_once() -> Iterator[None]:
    """Have Warp hash a device function once for all kernels that this thread hashes here, not for each that calls it.

    Hashes are what they would be. What functions refer to must not change meanwhile; they may get further overloads:
    then all is hashed again. Within itself it does nothing.
    """
    if getattr(_hashing, "known", None) is not None:
        yield
        return
    known: dict[Any, bytes] = {}
    with _changing:
        if not _remembered:
            _replace_hasher()
        _remembered.append(known)
    _hashing.known = known
    try:
        yield
    finally:
        _hashing.known = None
        with _changing:
            _remembered[:] = [other for other in _remembered if other is not known]
            if not _remembered:
                context: Any = import_module("warp._src.context")
                context.ModuleHasher, context.Function.add_overload = _replaced


def _replace_hasher() -> None:
    """Have Warp use what ``hashed_once`` knows."""
    context: Any = import_module("warp._src.context")
    plain: Any = context.ModuleHasher
    add_overload = context.Function.add_overload

    class Hasher(plain):
        functions_in_progress: set[Any]

        def hash_function(self, function: Any) -> bytes:
            known: dict[Any, bytes] | None = getattr(_hashing, "known", None)
            if known is None:
                return bytes(super().hash_function(function))
            if function not in known:
                if not isinstance(self.functions_in_progress, _Open):
                    self.functions_in_progress = _Open()
                open_ones: Any = self.functions_in_progress
                before = open_ones.circle_count
                digest = bytes(super().hash_function(function))
                if open_ones.circle_count > before or function in open_ones.circular:
                    open_ones.circular.add(function)
                    open_ones.circle_count += 1  # for what calls it
                    return digest
                known[function] = digest
            return known[function]

    def add(function: Any, overload: Any) -> None:
        # a struct gives constructors to itself only, when it is made
        if function is not overload and not function.is_builtin():
            for known in tuple(_remembered):
                known.clear()
        add_overload(function, overload)

    _replaced[:] = plain, add_overload
    context.ModuleHasher, context.Function.add_overload = Hasher, add


@dataclass(frozen=True)
class Module:
    """A compiled module in the cache: its folder, its size [bytes], and when a run loaded it last [s since 1970]."""

    folder: Path
    size: int
    used: float

    @property
    def has_samples(self) -> bool:
        """Whether it has samples of tools, not kernels."""
        return self.folder.name.startswith(SAMPLES)


def modules(folder: Path) -> list[Module]:
    """What weavesim loaded from a folder of modules, told by its seal: other programs may keep theirs beside it."""
    found = []
    with suppress(FileNotFoundError):
        for path in folder.iterdir():
            with suppress(OSError):  # another process may remove it meanwhile
                if (path / SEAL_NAME).is_file():
                    size = sum(file.stat().st_size for file in path.iterdir())
                    found.append(Module(path, size, path.stat().st_mtime))
    return found


def remove_unused(
    folder: Path, largest_size: int = LARGEST_SIZE, unused_age: float = UNUSED_AGE,
    largest_samples_size: int = LARGEST_SAMPLES_SIZE,
) -> None:  # fmt: skip
    """Remove the modules that were not used for longest until the rest is within ``largest_size`` [bytes].

    Kernels used within ``unused_age`` [s] stay: another run may be about to load them. Samples of tools have a limit
    of their own, ``largest_samples_size`` [bytes], so that many of them push no kernel out; a run that misses some
    computes them.
    """
    every, now = modules(folder), time.time()
    kernels = [module for module in every if not module.has_samples]
    samples = [module for module in every if module.has_samples]
    for kind, limit, age in ((kernels, largest_size, unused_age), (samples, largest_samples_size, 0.0)):
        excess = sum(module.size for module in kind) - limit
        for module in sorted(kind, key=lambda one: one.used):
            if excess > 0 and now - module.used >= age:
                shutil.rmtree(module.folder, ignore_errors=True)
                excess -= module.size


def own_folders(base: Path) -> list[Path]:
    """Folders of weavesim's modules in a cache, of all kinds of processors and versions of Warp."""
    if not base.is_dir():
        return []
    kinds = [path for path in base.iterdir() if OWN_FOLDER.fullmatch(path.name) and path.is_dir()]
    return sorted(path for kind in kinds for path in kind.iterdir() if path.is_dir())


def clear(base: Path) -> None:
    """Remove all of weavesim's modules from a cache, what ended compilers left, and the folders that are empty then.

    Raises:
        InputError: some cannot be removed.
    """
    for folder in own_folders(base):
        try:
            for module in modules(folder):
                shutil.rmtree(module.folder)
            _remove_leftovers(folder, of_the_ended=True)
        except OSError as error:
            raise InputError(
                f"compiled kernels in {folder} cannot be removed: {error.strerror or error}; end the runs that use "
                "them, and check who owns the folder"
            ) from None
        for emptied in (folder, folder.parent):
            with suppress(OSError):  # it is not empty
                emptied.rmdir()


def _remove_leftovers(folder: Path, of_the_ended: bool = False) -> None:
    """Remove what compilers left that were ended in the middle of a kernel: folders named by process and thread.

    Those of a day ago; or also those whose process has ended on this machine: others may share the cache.
    """
    with suppress(OSError):
        for path in folder.iterdir():
            if (found := LEFTOVER.search(path.name)) is None:
                continue
            old = time.time() - path.stat().st_mtime > LEFTOVER_AGE
            if old or (of_the_ended and not _is_alive(int(found[1]))):
                shutil.rmtree(path, ignore_errors=True)


def _is_alive(process: int) -> bool:
    """Whether a process may still be at work; it may where the system does not tell."""
    if os.name != "posix":
        return True
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (OSError, OverflowError):
        pass
    return True


def use_temporary(error: OSError) -> None:
    """Use a cache that is removed at the end of this process, because of an ``error``, and say so.

    Raises:
        InputError: it cannot be written either.
    """
    import warp as wp

    unusable = wp.config.kernel_cache_dir
    try:
        base = Path(tempfile.mkdtemp(prefix="weavesim-kernels-"))
        (base / "probe").write_bytes(bytes(PROBE_SIZE))
    except OSError as further:
        raise InputError(
            f"Compiled kernels cannot be stored in {unusable} ({error.strerror or error}), nor in "
            f"{tempfile.gettempdir()} ({further.strerror or further}): free some space, or set another folder in the "
            "environment variable WARP_CACHE_PATH"
        ) from None
    atexit.register(shutil.rmtree, base, ignore_errors=True)
    # Warp expects its version at the end of the name
    wp.config.kernel_cache_dir = str(base / str(wp.config.version))
    logger.warning(
        "compiled kernels cannot be stored in %s (%s): they go to %s for this run, and the next one compiles them "
        "again; free some space, make that folder writable, or set another one in WARP_CACHE_PATH",
        unusable, error.strerror or error, base,
    )  # fmt: skip


def _loaded_files(folder: Path) -> Iterator[Path]:
    if folder.is_dir():
        yield from sorted(file for file in folder.iterdir() if file.suffix in LOADED)


def _seal(folder: Path) -> dict[str, Any]:
    try:
        found = json.loads((folder / SEAL_NAME).read_text(encoding="utf-8"))
    except FileNotFoundError:
        return {}
    return found if isinstance(found, dict) else {}


def _hash(file: Path) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()
