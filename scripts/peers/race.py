"""One contestant in its own process: run with its name, files of the problem and of the result, device and limit."""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

if __name__ == "__main__":
    # the checkout comes first for weavesim, as in the other scripts; Newton's interpreter needs nothing from it
    sys.path[0] = str(Path(__file__).resolve().parents[2])

from scripts.peers.contestants import OURS, PEERS, isotropic
from scripts.peers.newton_run import NewtonRun
from scripts.peers.problem import Problem
from scripts.peers.weavesim_run import WeavesimRun


def race(problem: Problem, contestant: str, device: str, limit: float) -> tuple[dict[str, Any], np.ndarray, np.ndarray]:
    """Run one contestant to the end, to ``limit`` seconds of stepping, or until it is no longer finite.

    On the CPU, processor time is measured, which excludes other programs: all contestants run on one thread.

    Returns:
        Measurements, and the last positions and velocities. The first block of steps compiles and is not timed.
    """
    clock = time.process_time if device == "cpu" else time.perf_counter
    started = clock()
    if contestant in OURS:
        run: WeavesimRun | NewtonRun = WeavesimRun(problem, OURS[contestant], device)
    else:
        run = NewtonRun(problem, PEERS[contestant], device)
    run.advance()
    run.state()
    setup = clock() - started
    first_step, first_time, started = run.step_count, run.time, clock()
    elapsed, looked = 0.0, 0.0
    while True:
        run.advance()
        elapsed = clock() - started
        if run.time >= problem.duration * (1.0 - 1.0e-6) or elapsed >= limit:
            break
        if elapsed - looked > 2.0:
            looked = elapsed
            if not np.isfinite(run.state()[0]).all():
                break
    steps, simulated = run.step_count - first_step, run.time - first_time
    row = {
        "contestant": contestant,
        "device": device,
        "fabric": problem.fabric,
        "elements": run.element_count,
        "element": run.element,
        "membrane": problem.membrane,
        "shear": 0.5 * problem.membrane if isotropic(contestant) else problem.shear,
        "bending": problem.bending,
        "step_us": 1e6 * simulated / steps,
        "iterations": run.iterations,
        "rate": run.element_count * steps / elapsed,
        "seconds_per_simulated": elapsed / simulated,
        "simulated_s": run.time,
        "setup_s": setup,
    }
    return row, *run.state()


def main(contestant: str, problem_file: str, result_file: str, device: str, limit: str) -> None:
    """Worker: reads a problem, writes final positions and velocities to a file, and prints a line of JSON."""
    row, position, velocity = race(Problem.load(Path(problem_file)), contestant, device, float(limit))
    np.savez(result_file, position=position, velocity=velocity)
    print(json.dumps(row), flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
