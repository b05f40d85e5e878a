"""Runs cases in a checkout, and keeps the results of a commit."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from importlib.metadata import version
from pathlib import Path

import numpy as np

from ..shared.checkouts import checked_out, environment, full_name
from ..shared.machine import processor_name
from .cases import CASES, Case
from .inputs import write_inputs

FINISHED_WITH_DOUBTS = 3
RECORDER = Path(__file__).with_name("recorded_run.py").resolve()

# Other names of an option of the cases, in versions before or after this one: the first that a version knows is used.
# {"--binder": ("--binder", "--holder")}
SPELLINGS: dict[str, tuple[str, ...]] = {"--binder": ("--blank-holder", "--binder")}


def run_case(case: Case, checkout: Path, inputs: Path, folder: Path, threads: int, extra: Sequence[str] = ()) -> float:
    """Run a case in ``checkout``, write its results to ``folder``, and return the time taken [s].

    Raises:
        RuntimeError: the run did not finish; with its last message.
    """
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    arguments = spelled([*case.arguments(inputs), *extra], checkout)
    arguments += ["--threads", str(threads), "--out", str(folder / "out")]
    command = [sys.executable, "-P", str(RECORDER), str(folder / "frames.npz"), *arguments]
    started = time.perf_counter()
    with open(folder / "output.txt", "w", encoding="utf-8") as output:
        result = subprocess.run(
            command, cwd=checkout, env=environment(checkout), stdout=output, stderr=subprocess.STDOUT, check=False
        )
    # doubts about a result do not change its bits
    if result.returncode not in (0, FINISHED_WITH_DOUBTS):
        lines = (folder / "output.txt").read_text(encoding="utf-8").strip().splitlines()
        raise RuntimeError(lines[-1] if lines else f"exit code {result.returncode}")
    return time.perf_counter() - started


def spelled(arguments: list[str], checkout: Path) -> list[str]:
    """``arguments`` with the option names of ``checkout``."""
    if not set(arguments) & set(SPELLINGS):
        return arguments
    command = [sys.executable, "-m", "weavesim", arguments[0], "--help"]
    shown = subprocess.run(command, cwd=checkout, env=environment(checkout), capture_output=True, text=True, check=True)
    known = set(shown.stdout.split())
    return [next((name for name in SPELLINGS.get(word, ()) if name in known), word) for word in arguments]


def bits_depend_on() -> dict[str, str]:
    """What the bits depend on in addition to the code."""
    return {"processor": processor_name(), "warp": version("warp-lang"), "numpy": np.__version__}


class Reference:
    """Results of a commit in a folder; missing ones, and those with other settings, are run and added."""

    def __init__(self, folder: Path, commit: str, threads: int, stack: ExitStack) -> None:
        self.folder, self.commit, self._threads, self._stack = folder, full_name(commit), threads, stack
        self.inputs = folder / "inputs"
        self._checkout: Path | None = None
        write_inputs(self.inputs)

    def result(self, name: str, say: Callable[[str], None]) -> Path:
        """The folder of a case's results."""
        folder, about = self.folder / name, {"commit": self.commit, "words": CASES[name].words}
        file = folder / "case.json"
        if file.exists():
            known = json.loads(file.read_text(encoding="utf-8"))
            if {key: known.get(key) for key in about} == about:
                made_with, present = known["machine"], bits_depend_on()
                if made_with != present:
                    say(f"{name}: the reference is from {made_with}, this is {present}: bits may differ")
                return folder
            if known.get("commit") != self.commit:
                raise SystemExit(f"{folder} contains results of {known.get('commit')}, not of {self.commit}")
        if self._checkout is None:
            self._checkout = self._stack.enter_context(checked_out(self.commit))
        seconds = run_case(CASES[name], self._checkout, self.inputs, folder, self._threads)
        say(f"{name}: {self.commit[:7]} took {seconds:.0f} s")
        file.write_text(json.dumps(about | {"machine": bits_depend_on(), "seconds": seconds}, indent=2) + "\n")
        return folder
