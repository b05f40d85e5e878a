"""What unit cells cost: time per element and step of each, and this checkout against another one.

    python scripts/benchmark_unit_cells.py [--turns 10] [--mesh-size 0.01] [--precision float32]
    python scripts/benchmark_unit_cells.py --against ../weavesim-before

Turns of all contestants alternate, so that a machine whose speed drifts treats them alike: what counts are the ratios
of paired turns, given as median and quartiles. ``--against`` takes a checkout of another version (``git worktree add``)
and compares the default fabric, for example a plug against code that knows one cell only.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

# Steps on demand: reads the number of blocks, answers with microseconds per element and step.
CONTESTANT = """
import sys, time
from weavesim.fabric import glass_polypropylene
from weavesim.scenes.double_dome import DoubleDomeParameters, double_dome
name, mesh_size, precision = sys.argv[1:]
parameters = DoubleDomeParameters(mesh_size=float(mesh_size), precision=precision, threads=1)
if name == "default":
    simulation = double_dome(parameters)
else:
    from weavesim.fabric import UNIT_CELLS
    fabric = glass_polypropylene()
    shear = fabric.shear.model_copy(update={"locking_stiffness": 0.0})
    laws = {"unit_cell": UNIT_CELLS[name](), "shear": shear}
    simulation = double_dome(parameters, fabric.model_copy(update=laws))
stepper, count = simulation.stepper, simulation.blank.element_count
stepper.advance(100)
print(count, flush=True)
for line in sys.stdin:
    first, started = stepper.step_count, time.perf_counter()
    stepper.advance(int(line))
    elapsed = time.perf_counter() - started
    print(1e6 * elapsed / (stepper.step_count - first) / count, flush=True)
"""


class Contestant:
    """A double dome that steps in a process of its own."""

    def __init__(self, checkout: Path, name: str, mesh_size: float, precision: str) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-c", CONTESTANT, name, str(mesh_size), precision],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=checkout,
            env=os.environ | {"PYTHONPATH": str(checkout)},
        )  # fmt: skip
        self.element_count = int(self._answer())

    def _answer(self) -> str:
        line = self._process.stdout.readline()
        if not line:
            raise SystemExit("a contestant broke off; its message is above")
        return line

    def turn(self, block_count: int) -> float:
        """Microseconds per element and step."""
        self._process.stdin.write(f"{block_count}\n")
        self._process.stdin.flush()
        return float(self._answer())

    def close(self) -> None:
        self._process.stdin.close()
        self._process.wait()


def main(
    against: Annotated[Path | None, typer.Option(help="checkout of another version to compare with")] = None,
    turns: Annotated[int, typer.Option(help="turns of each contestant")] = 10,
    blocks: Annotated[int, typer.Option(help="blocks of 20 steps in a turn")] = 50,
    mesh_size: Annotated[float, typer.Option(help="[m]")] = 0.01,
    precision: Annotated[str, typer.Option(help="float32 or float64")] = "float32",
) -> None:
    here = Path(__file__).resolve().parent.parent
    if against is not None:
        entries = [("the other checkout", against.resolve(), "default"), ("this checkout", here, "default")]
    else:
        from weavesim.fabric import UNIT_CELLS

        entries = [(name, here, name) for name in UNIT_CELLS]
    contestants = [Contestant(checkout, name, mesh_size, precision) for _, checkout, name in entries]
    times = np.array([[contestant.turn(blocks) for contestant in contestants] for _ in range(turns)])
    for contestant in contestants:
        contestant.close()
    print(f"{contestants[0].element_count} elements, {precision}, one thread, {turns} turns of {20 * blocks} steps")
    print(f"| | ns per element and step | ratio to {entries[0][0]}: median | quartiles |")
    print("|---|---|---|---|")
    for (label, _, _), column in zip(entries, times.T, strict=True):
        low, middle, high = np.quantile(column / times[:, 0], [0.25, 0.5, 0.75])
        print(f"| {label} | {1e3 * np.median(column):.0f} | {middle:.3f} | {low:.3f} to {high:.3f} |")


if __name__ == "__main__":
    typer.run(main)
