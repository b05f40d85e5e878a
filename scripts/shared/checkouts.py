"""Other versions of weavesim beside this one: a commit in a folder of its own, and what a process needs to run it."""

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
    """Variables of a process that imports the weavesim of ``checkout``, whichever is installed."""
    return os.environ | {"PYTHONPATH": str(checkout)}


def full_name(commit: str) -> str:
    """All 40 digits of a commit of this repository, however it is named."""
    answer = _git("rev-parse", "--verify", f"{commit}^{{commit}}")
    return answer.decode().strip()


@contextmanager
def checked_out(commit: str) -> Iterator[Path]:
    """A temporary folder with the files of a commit."""
    with TemporaryDirectory(prefix="weavesim-") as folder:
        with tarfile.open(fileobj=BytesIO(_git("archive", "--format=tar", commit))) as archive:
            archive.extractall(folder, filter="data")
        yield Path(folder)


def _git(*arguments: str) -> bytes:
    result = subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True)
    if result.returncode:
        raise SystemExit(f"git {' '.join(arguments)}: {result.stderr.decode().strip()}")
    return result.stdout
