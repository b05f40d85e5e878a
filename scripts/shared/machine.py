"""What the numbers and bits of a run depend on in addition to the code."""

from __future__ import annotations

import datetime
import platform
import subprocess
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]


def processor_name() -> str:
    """Processor of this machine, as precisely as the system reports it."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        return next(line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or platform.machine()


def machine() -> dict[str, Any]:
    """Description of the machine."""
    import warp as wp

    from weavesim import __version__
    from weavesim.device import available_threads, cpu_features, device_names

    revision = subprocess.run(["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True, cwd=ROOT)
    return {
        "date": datetime.date.today().isoformat(),
        "processor": processor_name(),
        "cores": available_threads(),
        "avx512": "avx512f" in cpu_features(),
        "devices": [wp.get_device(name).name for name in device_names()],
        "warp": wp.config.version,
        "python": platform.python_version(),
        "weavesim": __version__,
        "revision": revision.stdout.strip() or None,
    }
