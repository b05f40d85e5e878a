"""How a step would scale to more threads than there are cores: its plan, with times measured on one thread."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
import typer

from ..shared.machine import machine
from ..shared.report import line_about, table
from .cases import CASES, warm_up
from .measures import phases

# A barrier is an atomic counter: threads add to it one after the other, then wait until they see the last [s].
BARRIER, BARRIER_PER_THREAD = 100.0e-9, 30.0e-9
BARRIERS_PER_STEP = 3


@dataclass(frozen=True)
class Times:
    """Measured on one thread [s].

    Attributes:
        element, node: of a block of lanes in a step.
        serial: of what one thread does in a step while the others wait: tools and clock.
    """

    element: float
    node: float
    serial: float


@dataclass(frozen=True)
class Step:
    """A step on several threads [s].

    Attributes:
        work: of the thread with most tiles, and of the one with most nodes that wait for others.
        serial: on one thread while the others wait.
        barriers: together.
        balance: mean work of the threads over the most.
    """

    work: float
    serial: float
    barriers: float
    balance: float

    @property
    def seconds(self) -> float:
        """All of it."""
        return self.work + self.serial + self.barriers


def blocks(runs: Sequence[tuple[int, int]]) -> int:
    """Blocks of all runs."""
    return sum(count for _, count in runs)


def step_on(parts: Sequence, times: Times, wait: float | None = None) -> Step:
    """A step as ``weavesim.engine.tiling.tiles.divide_step`` shares it out.

    Args:
        parts: one per thread.
        times: of their work.
        wait: of one barrier [s]; by default that of an atomic counter.
    """
    tiles = [
        sum(times.element * blocks(tile.elements) + times.node * blocks(tile.nodes) for tile in part.tiles)
        for part in parts
    ]
    shared = [times.node * blocks(part.shared) for part in parts]
    wait = BARRIER + BARRIER_PER_THREAD * len(parts) if wait is None else wait
    work = max(tiles) + max(shared)
    return Step(
        work,
        times.serial,
        BARRIERS_PER_STEP * wait if len(parts) > 1 else 0.0,
        float(np.mean(np.add(tiles, shared))) / work,
    )


def schedule(
    case: Annotated[list[str] | None, typer.Option(help=f"one of {', '.join(CASES)}; may be repeated")] = None,
    precision: Annotated[str, typer.Option(help="float32 or float64")] = "float32",
    threads: Annotated[str, typer.Option(help="comma-separated")] = "1,2,4,8,16,32,64",
    seconds: Annotated[float, typer.Option(help="length of a measurement")] = 0.3,
    between_nodes: Annotated[
        bool, typer.Option("--between-nodes", help="keep the windows together that contact between nodes has")
    ] = False,
) -> None:
    """A step on 1 to 64 threads, predicted from its plan: balance, nodes that wait, barriers and what is serial.

    Cores are taken to be alike, with a cache of their own and memory enough for all. Of contact between nodes only what
    it keeps together counts: its work is where the sheet touches, which the plan does not know.
    """
    from weavesim.engine.surface.order import window
    from weavesim.engine.tiling.tiles import TILE_SIZE, divide_step

    rows = []
    for name in case or ("double_dome_5mm", "double_dome_2.5mm", "double_dome_1.25mm", "patch_100k"):
        simulation = CASES[name](precision=precision, threads=1)
        warm_up(simulation)
        model, found = simulation.model.sheet, phases(simulation, seconds)
        times = Times(
            found["elements"] / (model.element_count // model.lane_count),
            found["nodes and contact"] / model.block_count,
            found["tools"],
        )
        together = window(model.blank.element_count, model.lane_count) if between_nodes else 1
        first = None
        for count in (int(one) for one in threads.split(",")):
            parts = divide_step(model.element_nodes, model.lane_count, count, TILE_SIZE, together)
            step = step_on(parts, times)
            first = first or step.seconds
            gain = first / step.seconds
            rows.append(
                [
                    name, model.blank.element_count, count, f"{1e6 * step.seconds:.1f}", f"{gain:.1f}",
                    f"{gain / count:.0%}", f"{step.balance:.0%}", f"{step.serial / step.seconds:.0%}",
                    f"{step.barriers / step.seconds:.0%}",
                ]
            )  # fmt: skip
    head = ["case", "elements", "threads", "step [us]", "speed-up", "efficiency", "balance", "serial", "barriers"]
    typer.echo(f"{line_about(machine())}\n\n{table(head, rows)}")
