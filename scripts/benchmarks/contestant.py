"""A case that steps on demand, in a separate process and with the version of weavesim on PYTHONPATH.

    PYTHONPATH=CHECKOUT python scripts/benchmarks/contestant.py CASE PRECISION THREADS

First writes the number of elements; then reads numbers of blocks, and replies to each with nanoseconds per element and
step. On one thread this is processor time, which excludes other programs.
"""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def main(case: str, precision: str, threads: str) -> None:
    """Reply to standard input, line by line, until it ends."""
    import weavesim  # before this checkout, which has its own, is searched

    checkout = Path(os.environ["PYTHONPATH"]).resolve()
    if not Path(weavesim.__file__).resolve().is_relative_to(checkout):
        raise SystemExit(f"{weavesim.__file__} was imported, which is not in {checkout}")
    sys.path[0] = str(ROOT)
    from scripts.benchmarks.cases import CASES, element_count, warm_up

    clock = time.process_time if threads == "1" else time.perf_counter
    simulation = CASES[case](precision=precision, threads=int(threads))
    stepper, count = simulation.stepper, element_count(simulation)
    warm_up(simulation)
    print(count, flush=True)
    for line in sys.stdin:
        first, started = stepper.step_count, clock()
        stepper.advance(int(line))
        print(1e9 * (clock() - started) / (stepper.step_count - first) / count, flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
