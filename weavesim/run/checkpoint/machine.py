"""What computed a checkpoint: a run goes on with the same bits only where all of it is the same."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Iterator, Mapping
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np

from ...device import cpu_features
from ...kernels import rows
from ...version import __version__

# What a reader calls the entries of ``machine``.
_CALLED = {
    "weavesim": "version of weavesim",
    "sources": "source text of weavesim",
    "warp": "version of Warp",
    "numpy": "version of NumPy",
    "processor": "processor",
    "device": "device",
}


def machine(device: str) -> dict[str, str]:
    """Everything here that the bits of a result may depend on.

    Args:
        device: name of the device that computes.
    """
    try:
        warp = version("warp-lang")
    except PackageNotFoundError:  # not installed by a package manager
        warp = "unknown"
    processor = f"{platform.machine()} {cpu_features()}".strip()
    return {
        "weavesim": __version__, "sources": _sources(), "warp": warp, "numpy": np.__version__,
        "processor": processor, "device": device,
    }  # fmt: skip


@cache
def _sources() -> str:
    """Digest of the modules that compute: two states of a checkout may have one version."""
    digest = hashlib.sha256()
    for root in (Path(__file__).parents[2], Path(rows.__file__).parent):
        for path in sorted(root.rglob("*.py")):
            digest.update(path.relative_to(root).as_posix().encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def differences(before: Mapping[str, str], now: Mapping[str, str]) -> Iterator[str]:
    """What is different, in words."""
    for name, called in _CALLED.items():
        if before.get(name) != now.get(name):
            long = max(len(str(before.get(name))), len(str(now.get(name)))) > 40 or name == "sources"
            yield called if long else f"{called} ({now.get(name)} instead of {before.get(name)})"
