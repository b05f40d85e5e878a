"""Element-steps per second of the double dome, by mesh size, precision and threads.

    python scripts/benchmark.py [--seconds 3]

Each row is the best of two turns, taken one after the other over all rows: on a shared machine compare rows of one run.
"""

from __future__ import annotations

import time
from typing import Annotated

import typer

from weavesim.device import available_threads
from weavesim.scenes.double_dome import DoubleDomeParameters, double_dome
from weavesim.simulation import Simulation

BLOCKS_PER_TURN = 5
TURNS = 2


def microseconds_per_step(simulation: Simulation, seconds: float) -> float:
    """Time of one step [us], contact with three tools included, output not."""
    simulation.stepper.advance(BLOCKS_PER_TURN)
    first, started = simulation.stepper.step_count, time.perf_counter()
    while (elapsed := time.perf_counter() - started) < seconds:
        simulation.stepper.advance(BLOCKS_PER_TURN)
    return 1e6 * elapsed / (simulation.stepper.step_count - first)


def main(seconds: Annotated[float, typer.Option(help="time of each turn")] = 3.0) -> None:
    thread_counts = sorted({1, available_threads()})
    cases = [
        {"mesh_size": size, "precision": precision, "threads": threads}
        for size in (0.01, 0.005, 0.0025, 0.00125)
        for precision in ("float32", "float64")
        for threads in thread_counts
    ]
    simulations = [double_dome(DoubleDomeParameters(**case)) for case in cases]
    best = [float("inf")] * len(cases)
    for _ in range(TURNS):
        for index, simulation in enumerate(simulations):
            best[index] = min(best[index], microseconds_per_step(simulation, seconds))
    print("| mesh [mm] | elements | precision | threads | step [us] | million element-steps/s |")
    print("|---|---|---|---|---|---|")
    for case, simulation, step in zip(cases, simulations, best, strict=True):
        count = simulation.blank.element_count
        print(
            f"| {1e3 * case['mesh_size']:g} | {count} | {case['precision']} | {case['threads']} | {step:.1f} "
            f"| {count / step:.1f} |"
        )


if __name__ == "__main__":
    typer.run(main)
