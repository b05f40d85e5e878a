"""All contestants in sequence, each in a separate process."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .accuracy import measures
from .contestants import OURS
from .problem import Problem

WORKER = Path(__file__).with_name("race.py").resolve()


def newton_versions(python: str) -> dict[str, str] | None:
    """Versions of Newton and its Warp in an interpreter, None if it has no Newton; imports neither."""
    code = (
        "import json; from importlib.metadata import version; "
        "print(json.dumps({'newton': version('newton'), 'warp of newton': version('warp-lang')}))"
    )
    try:
        done = subprocess.run([python, "-c", code], capture_output=True, text=True, check=False)
    except OSError:
        return None
    return json.loads(done.stdout) if done.returncode == 0 else None


def compete(
    problem: Problem, contestants: Sequence[str], device: str, limit: float, newton_python: str
) -> Iterator[dict[str, Any]]:
    """Every contestant in a separate process: its cost and ``measures``, or the error that stopped it."""
    with tempfile.TemporaryDirectory() as folder:
        problem_file, result_file = Path(folder) / "problem.npz", Path(folder) / "result.npz"
        problem.save(problem_file)
        for name in contestants:
            python = sys.executable if name in OURS else newton_python
            command = [python, str(WORKER), name, str(problem_file), str(result_file), device, str(limit)]
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            if done.returncode:
                error = (done.stderr.strip() or f"ended with {done.returncode}").splitlines()[-1]
                yield {"contestant": name, "fabric": problem.fabric, "device": device, "error": error}
                continue
            row = json.loads(done.stdout.splitlines()[-1])
            with np.load(result_file) as result:
                yield row | measures(problem, result["position"], result["velocity"])
