"""Program that reads one file with meshio, within bounds of memory and time, and writes what it found as ``.npz``.

    python meshio_process.py PATH FORMAT BYTES SECONDS

meshio takes memory for what a damaged header promises, ends the program, and prints; a process of its own holds that.
Exit codes: 0 done, 1 the file cannot be read, 3 not enough memory. Nothing else of weavesim is imported here.
"""

from __future__ import annotations

import contextlib
import io
import os
import sys
from pathlib import Path

import numpy as np


def bound(memory: int, seconds: int) -> None:
    """Limit what this process takes from now on, where the system can."""
    try:
        import resource
    except ImportError:  # not on Windows
        return
    try:
        present = int(Path("/proc/self/statm").read_text().split()[0]) * os.sysconf("SC_PAGE_SIZE")
    except (OSError, ValueError):
        present = 2**32
    for kind, limit in ((resource.RLIMIT_AS, present + memory), (resource.RLIMIT_CPU, seconds)):
        _, hard = resource.getrlimit(kind)
        soft = limit if hard == resource.RLIM_INFINITY else min(limit, hard)
        with contextlib.suppress(ValueError, OSError):
            resource.setrlimit(kind, (soft, hard))


def found_in(path: str, file_format: str) -> bytes:
    """Points, and the nodes of every block of cells with the name of its kind."""
    import meshio

    mesh = meshio.read(path, file_format)
    arrays = {f"nodes_{k}": np.asarray(block.data) for k, block in enumerate(mesh.cells)}
    kinds = np.array([block.type for block in mesh.cells], dtype="U40")
    content = io.BytesIO()
    np.savez(content, allow_pickle=False, points=np.asarray(mesh.points), kinds=kinds, **arrays)
    return content.getvalue()


def main() -> int:
    path, file_format, memory, seconds = sys.argv[1:]
    bound(int(memory), int(seconds))
    result = os.dup(1)
    silent = os.open(os.devnull, os.O_WRONLY)
    os.dup2(silent, 1)
    os.dup2(silent, 2)
    try:
        content = found_in(path, file_format)
    except MemoryError:
        return 3
    except (Exception, SystemExit):  # whatever a damaged file makes of it
        return 1
    with open(result, "wb") as out:
        out.write(content)
    return 0


if __name__ == "__main__":
    sys.exit(main())
