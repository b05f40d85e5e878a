"""The command line in processes of their own, for tests that signal, kill or starve them."""

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from tests.support.forks import Fork, fork
from tests.support.paths import ROOT

# What takes longer never ends [s]: a machine may be slow, busy, and without a compiled kernel.
ENOUGH = 300.0
# 16 elements; about half a second of stepping, or more than a minute with SLOW.
COARSE = ("picture-frame", "--mesh-size", "0.05", "--threads", "1")
SLOW = ("--speed", "0.003")
LIGHT = ("--write", "film,tables,summary")


def command(*arguments: object) -> list[str]:
    """The command line with these arguments."""
    return [sys.executable, "-P", "-m", "weavesim", *map(str, arguments)]


def environment(**more: str) -> dict[str, str]:
    """In which a process finds this checkout."""
    return {**os.environ, "PYTHONPATH": str(ROOT), **more}


def run(*arguments: object, **given: object) -> subprocess.CompletedProcess:
    """Run the command to its end, with its output as text."""
    settings = {"capture_output": True, "text": True, "timeout": ENOUGH, "env": environment()}
    return subprocess.run(command(*arguments), **(settings | given))


def start(*arguments: object, **given: object) -> subprocess.Popen:
    """Start the command."""
    settings = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, "env": environment()}
    return subprocess.Popen(command(*arguments), **(settings | given))


def forked(*arguments: object, largest_file: int | None = None) -> Fork:
    """Start the command without the time that its start takes, see ``forks.py``."""
    return fork([str(argument) for argument in arguments], environment(), largest_file)


def run_forked(*arguments: object, largest_file: int | None = None) -> subprocess.CompletedProcess:
    """The same to its end, with its output as text."""
    process = forked(*arguments, largest_file=largest_file)
    out, err = process.communicate(ENOUGH)
    return subprocess.CompletedProcess(arguments, process.wait(), out, err)


def summary(folder: Path) -> dict:
    """Of the run in a folder."""
    return json.loads((folder / "summary.json").read_text(encoding="utf-8"))


def wait_for(condition: Callable[[], object], seconds: float = ENOUGH) -> None:
    """Wait until a condition holds; what raises does not hold."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        try:
            if condition():
                return
        except (OSError, ValueError, KeyError):
            pass
        time.sleep(0.02)
    raise TimeoutError("the condition did not come true")


def started(folder: Path, *, frame_count: int = 2) -> Callable[[], bool]:
    """Whether the run in a folder has saved so many frames."""
    return lambda: summary(folder)["frame_count"] >= frame_count


def slow_run(folder: Path, *arguments: object, writers: Sequence[str] = LIGHT) -> Fork:
    """Start a coarse run that takes more than a minute, and wait until it has written a few frames."""
    process = forked(*COARSE, *SLOW, *writers, "--out", folder, *arguments)
    try:
        wait_for(started(folder))
    except TimeoutError:
        process.kill()
        raise AssertionError(process.communicate()) from None
    return process
