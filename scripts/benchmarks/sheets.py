"""Cost of several sheets in one run compared with one."""

from __future__ import annotations

from typing import Annotated

import numpy as np
import typer

from ..shared.machine import machine
from ..shared.report import line_about
from .cases import element_count
from .measures import seconds_per_step
from .ratios import ratio_table

# Blocks of steps before the clock starts.
WARM_UP_BLOCK_COUNT = 100


def sheets(
    counts: Annotated[
        list[int] | None, typer.Option("--count", help="numbers of sheets [default: 1, 2, 4, 16]")
    ] = None,
    turns: Annotated[int, typer.Option(help="turns per number of sheets")] = 9,
    seconds: Annotated[float, typer.Option(help="length of a turn")] = 0.3,
    mesh_size: Annotated[float, typer.Option(help="mesh size of the double domes [m]")] = 0.01,
    precision: Annotated[str, typer.Option(help="float32 or float64")] = "float32",
) -> None:
    """Time per element and step of quarters of the double dome, each in its own world, on one thread."""
    from weavesim.run.simulation import Simulation
    from weavesim.scenes.double_dome import DoubleDomeParameters, double_dome

    setup = double_dome(DoubleDomeParameters(mesh_size=mesh_size, precision=precision, threads=1))
    (world,) = setup.worlds
    counts = counts or [1, 2, 4, 16]
    simulations = []
    for count in counts:
        copies = [(setup.sheet.model_copy(update={"name": f"sheet {k}"}),) for k in range(count)]
        worlds = tuple(world.model_copy(update={"name": f"world {k}", "sheets": copy}) for k, copy in enumerate(copies))
        simulation = Simulation(setup.model_copy(update={"worlds": worlds}))
        # the same number of steps for all, so that all sheets are in the same state
        simulation.stepper.advance(WARM_UP_BLOCK_COUNT)
        simulations.append(simulation)
    times = np.array([[seconds_per_step(s, seconds) / element_count(s) for s in simulations] for _ in range(turns)])
    typer.echo(line_about(machine()))
    typer.echo(f"{mesh_size * 1e3:g} mm, {precision}, one thread\n")
    typer.echo(ratio_table([f"{count} sheet{'s' if count > 1 else ''}" for count in counts], 1e9 * times))
