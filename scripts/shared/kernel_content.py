"""Whether a kernel is what it was when something was recorded about its binary."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import warp as wp


def content_of(kernel: wp.Kernel, left_out: Callable[[str], bool]) -> str:
    """Hash of the source of a kernel and of all that it calls, as Warp takes it to tell whether to compile it again.

    Args:
        kernel: whatever else is in its module does not count.
        left_out: whether an option of the module does not count.
    """
    import warp as wp

    hasher: Any = import_module("warp._src.context").ModuleHasher
    options = kernel.module.resolve_options(wp.config)
    # with its options: hashing also notes in the kernel how it is launched
    source = hasher([kernel], options).kernel_hashes[kernel]
    counted = sorted((name, value) for name, value in options.items() if not left_out(name))
    return hashlib.sha256(f"{counted}".encode() + source).hexdigest()[:16]
