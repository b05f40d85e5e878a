"""Which source code runs, and on which processor."""

from __future__ import annotations

import json
import platform
import subprocess
from contextlib import suppress
from functools import cache
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

# Of Git [s]: a slow disk must not hold up a run.
_PATIENCE = 5.0


@cache
def source_commit() -> str | None:
    """Commit of the checkout that this package runs from, "with changes" if files differ from it.

    Of an installed package it is the commit that it was installed from, if pip knows it; else None.
    """
    root = Path(__file__).resolve().parents[3]
    if (root / ".git").exists():
        commit = _git(root, "rev-parse", "HEAD")
        if commit:
            changed = _git(root, "status", "--porcelain", "--untracked-files=no", "--", "weavesim", "kernels", "scenes")
            return f"{commit}, with changes" if changed else commit
    with suppress(PackageNotFoundError, OSError, ValueError):
        text = distribution("weavesim").read_text("direct_url.json")
        return (json.loads(text).get("vcs_info") or {}).get("commit_id") if text else None
    return None


def _git(root: Path, *words: str) -> str:
    """What Git answers; nothing where it cannot be asked."""
    with suppress(OSError, subprocess.SubprocessError):
        done = subprocess.run(["git", *words], cwd=root, capture_output=True, text=True, timeout=_PATIENCE, check=True)
        return done.stdout.strip()
    return ""


@cache
def processor_name() -> str:
    """Name of the processor, as the system knows it; "" if it does not."""
    with suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor()
