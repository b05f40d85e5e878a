"""Cost of several sheets in one run compared with one, and of the contact between plies."""

from __future__ import annotations

import time
from typing import Annotated, Any

import numpy as np
import typer

from ..shared.machine import machine
from ..shared.report import line_about
from .cases import element_count
from .measures import seconds_per_step
from .ratios import ratio_table

# Blocks of steps before the clock starts.
WARM_UP_BLOCK_COUNT = 100
PLY_WARM_UP_BLOCK_COUNT = 20
# Pressure that holds a stack of plies together [Pa]; half side of their squares [m].
PRESSURE = 1.0e3
HALF_SIDE = 0.05


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

    setup = double_dome(
        DoubleDomeParameters(mesh_size=mesh_size, precision=precision, threads=1, contact_samples="nodes")
    )
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


def plies(
    count: Annotated[int, typer.Option(help="number of plies")] = 2,
    turns: Annotated[int, typer.Option(help="turns per case")] = 9,
    seconds: Annotated[float, typer.Option(help="length of a turn")] = 0.3,
    mesh_size: Annotated[float, typer.Option(help="mesh size of the plies [m]")] = 0.0025,
    precision: Annotated[str, typer.Option(help="float32 or float64")] = "float32",
    device: Annotated[str, typer.Option(help='"cpu", on one thread, or "cuda:0", ...')] = "cpu",
    speed: Annotated[float, typer.Option(help="of waves across single plies at the start [m/s]")] = 0.0,
) -> None:
    """Time per element and step of flat squares, every second one turned by 30 degrees; on a CPU, processor time."""
    where, clock = ("one thread", time.process_time) if device == "cpu" else (device, time.perf_counter)
    solver = {"precision": precision, "device": device, "threads": 1 if device == "cpu" else None}
    cases = {
        "one ply": stack(1, mesh_size, solver, speed=speed),
        "one ply with self-contact, nothing near": stack(1, mesh_size, solver, self_contact=True, speed=speed),
        f"{count} plies that pass through each other": stack(count, mesh_size, solver, interfaces=False),
        f"{count} plies in contact, both passes": stack(count, mesh_size, solver),
        f"{count} plies in contact, one pass": stack(count, mesh_size, solver, passes="one"),
        f"{count} plies far apart, without interfaces": stack(count, mesh_size, solver, interfaces=False, gap=0.05),
        f"{count} plies far apart": stack(count, mesh_size, solver, gap=0.05),
    }
    for simulation in cases.values():
        simulation.stepper.advance(PLY_WARM_UP_BLOCK_COUNT)
    simulations = list(cases.values())
    times = np.array(
        [[seconds_per_step(s, seconds, clock=clock) / element_count(s) for s in simulations] for _ in range(turns)]
    )
    typer.echo(line_about(machine()))
    typer.echo(f"{mesh_size * 1e3:g} mm, {precision}, {where}\n")
    typer.echo(ratio_table(list(cases), 1e9 * times))


def stack(
    count: int,
    mesh_size: float,
    solver: dict[str, Any],
    *,
    interfaces: bool = True,
    passes: str = "both",
    gap: float = 0.0,
    self_contact: bool = False,
    speed: float = 0.0,
):
    """Squares that a dead pressure on the outermost ones holds together, or apart by ``gap`` [m] and free.

    At the start they move up and down in a wave across each, at most at ``speed`` [m/s].
    """
    from weavesim import Blank, Coulomb, Interface, NodalLoads, SelfContact, Setup, Sheet, Simulation, Solver
    from weavesim.fabric import glass_polypropylene

    fabric = glass_polypropylene()
    sheets = []
    for k in range(count):
        flat = Blank.rectangle((-HALF_SIDE, -HALF_SIDE), (HALF_SIDE, HALF_SIDE), mesh_size)
        turn = np.radians(30.0 * (k % 2))
        rotation = np.array([[np.cos(turn), np.sin(turn), 0.0], [-np.sin(turn), np.cos(turn), 0.0], [0.0, 0.0, 1.0]])
        position = flat.node_position @ rotation + (0.0, 0.0, k * (fabric.thickness + gap))
        blank = Blank.from_mesh(position, flat.quads)
        outside = (k == 0) - (k == count - 1)
        force = np.zeros((blank.node_count, 3))
        force[:, 2] = PRESSURE * mesh_size**2 * outside * (gap == 0.0)
        velocity = np.zeros((blank.node_count, 3))
        velocity[:, 2] = speed * np.sin(np.pi * flat.node_position[:, 0] / HALF_SIDE)
        own = SelfContact() if self_contact else None
        sheets.append(
            Sheet(
                blank,
                fabric,
                name=f"ply {k}",
                loads=NodalLoads(force=force),
                self_contact=own,
                initial_velocity=velocity,
            )  # fmt: skip
        )
    pairs = zip(sheets[:-1], sheets[1:], strict=True)
    joined = tuple(Interface(a.name, b.name, Coulomb(0.2), passes=passes) for a, b in pairs) if interfaces else ()
    return Simulation(
        Setup(name="plies", sheets=tuple(sheets), interfaces=joined, duration=1.0, solver=Solver(**solver))
    )
