"""Samples that a command computes are kept beside the compiled kernels, for the next one with the same tools."""

from __future__ import annotations

import hashlib
import logging
import os
import shutil
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ... import kernel_cache
from ...device import block_size

if TYPE_CHECKING:
    import warp as wp

logger = logging.getLogger(__name__)

# Samples of a mesh that take more are not kept [bytes].
LARGEST_SIZE = 1 << 28

Inputs = Sequence[np.ndarray | float]

_are_stored: ContextVar[bool] = ContextVar("_are_stored", default=False)


@contextmanager
def samples_stored() -> Iterator[None]:
    """Inside this context samples are looked for in the cache of kernels, and kept there.

    Not for programs in general: somebody who tries many tools would fill it.
    """
    token = _are_stored.set(True)
    try:
        yield
    finally:
        _are_stored.reset(token)


class StoredArrays:
    """Arrays by name: those that an earlier command has kept for the same inputs, and those that are to be kept.

    Args:
        kernels: that compute them: their sources are part of the key, as those of the modules in ``files``.
        files: with the other code that computes them.
        inputs: gives all that they depend on, where something may be kept.
        device: on which they are computed; of others than CPUs, which are fast, nothing is kept.
    """

    def __init__(
        self, kernels: Sequence[wp.Kernel], files: Sequence[str], inputs: Callable[[], Inputs], device: wp.Device
    ) -> None:
        self._folder: Path | None = None
        self._found: dict[str, np.ndarray] = {}
        self._is_new = False
        if _are_stored.get() and device.is_cpu:
            modules = [kernel_cache.folder_of(kernel, block_size(kernel, device)) for kernel in kernels]
            self._folder = modules[0].parent / f"{kernel_cache.SAMPLES}{_digest(modules, files, inputs())}"
            self._found = _read(self._folder)

    def get(self, *names: str) -> list[np.ndarray] | None:
        """The arrays of these names, if all were kept."""
        return [self._found[name] for name in names] if self._found.keys() >= set(names) else None

    def add(self, **arrays: np.ndarray | wp.array) -> None:
        """Keep copies of these too; ``keep`` writes them."""
        if self._folder is not None:
            for name, array in arrays.items():
                self._found[name] = np.array(array if isinstance(array, np.ndarray) else array.numpy())
            self._is_new = True

    def keep(self) -> None:
        """Write what was added; a cache that cannot be written is left as it is."""
        size = sum(values.nbytes for values in self._found.values())
        if self._folder is None or not self._is_new or size > LARGEST_SIZE:
            return
        with suppress(OSError):
            # its name ends as that of what compilers leave: what an ended command leaves is removed with theirs
            temporary = self._folder.with_name(f"{self._folder.name}_p{os.getpid()}_t{threading.get_ident()}")
            temporary.mkdir()
            try:
                for name, values in self._found.items():
                    np.save(temporary / f"{name}.npy", values, allow_pickle=False)
                kernel_cache.seal(temporary)
                # without one, which takes room too, nothing would find the samples or remove them
                if (temporary / kernel_cache.SEAL_NAME).is_file():
                    shutil.rmtree(self._folder, ignore_errors=True)
                    temporary.replace(self._folder)
            finally:
                shutil.rmtree(temporary, ignore_errors=True)
            kernel_cache.remove_unused(self._folder.parent)


def _digest(kernels: Sequence[Path], files: Sequence[str], inputs: Inputs) -> str:
    digest = hashlib.sha256(" ".join(kernel.name for kernel in kernels).encode())
    for file in files:
        digest.update(Path(file).read_bytes())
    for value in inputs:
        if isinstance(value, np.ndarray):
            digest.update(f"{value.dtype} {value.shape}".encode())
            digest.update(np.ascontiguousarray(value).tobytes())
        else:
            digest.update(f"{value!r} ".encode())
    return digest.hexdigest()[:32]


def _read(folder: Path) -> dict[str, np.ndarray]:
    """The arrays of a folder; none of one that is not there, or damaged."""
    if not (folder / kernel_cache.SEAL_NAME).is_file():
        return {}
    if reason := kernel_cache.damage(folder):
        logger.info("the samples in %s are damaged (%s) and are computed again", folder, reason)
        return {}
    with suppress(OSError, ValueError):
        found = {path.stem: np.load(path, allow_pickle=False) for path in folder.glob("*.npy")}
        kernel_cache.seal(folder)
        return found
    return {}
