"""Other versions of weavesim: a commit in a separate folder, and the environment of a process that runs it."""

from __future__ import annotations

import os
import subprocess
import tarfile
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory

ROOT = Path(__file__).resolve().parents[2]


def environment(checkout: Path) -> dict[str, str]:
    """Environment variables of a process that imports weavesim from ``checkout``, whichever version is installed."""
    return os.environ | {"PYTHONPATH": str(checkout)}


def full_name(commit: str) -> str:
    """Full 40-digit hash of a commit of this repository, given by any name."""
    answer = _git("rev-parse", "--verify", f"{commit}^{{commit}}")
    return answer.decode().strip()


@contextmanager
def checked_out(commit: str) -> Iterator[Path]:
    """Yield a temporary folder with the files of a commit."""
    with TemporaryDirectory(prefix="weavesim-") as folder:
        with tarfile.open(fileobj=BytesIO(_git("archive", "--format=tar", commit))) as archive:
            archive.extractall(folder, filter="data")
        yield Path(folder)


def _git(*arguments: str) -> bytes:
    result = subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True)
    if result.returncode:
        raise SystemExit(f"git {' '.join(arguments)}: {result.stderr.decode().strip()}")
    return result.stdout
