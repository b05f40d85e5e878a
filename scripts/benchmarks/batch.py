"""Many variants in one batch, compared with single runs: their results, and what each costs."""

from __future__ import annotations

import logging
import multiprocessing
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer

from ..shared.machine import machine
from ..shared.report import line_about, table

if TYPE_CHECKING:
    from weavesim.engine.setup import Setup
    from weavesim.run.batch.batch_run import BatchRun

# Strokes of the variants [m]: what is checked of tools before a run is the same for equal ones.
STROKES = (0.050, 0.055, 0.060)


@dataclass(frozen=True)
class Cost:
    """Of one variant [s]."""

    wall: float
    processor: float


def variant(number: int, mesh_size: float, device: str, share: float) -> Setup:
    """A quarter of the double dome with its own friction, holder force, stroke, areal density and stiffness."""
    from weavesim.scenes.double_dome import DoubleDomeParameters, double_dome

    rng = np.random.default_rng(number)
    options = DoubleDomeParameters(
        mesh_size=mesh_size,
        device=device,
        friction=float(rng.uniform(0.05, 0.4)),
        blank_holder_force=float(rng.uniform(500.0, 5000.0)),
        stroke=STROKES[number % len(STROKES)],
        frame_count=1,
        contact_samples="nodes",
    )
    setup = double_dome(options)
    (world,), fabric = setup.worlds, setup.sheet.fabric
    own = {
        "areal_density": fabric.areal_density * rng.uniform(0.9, 1.1),
        "in_plane_bending_stiffness": fabric.in_plane_bending_stiffness * rng.uniform(0.8, 1.2),
    }
    sheet = setup.sheet.model_copy(update={"fabric": fabric.model_copy(update=own)})
    given = {"worlds": (world.model_copy(update={"sheets": (sheet,)}),), "duration": setup.duration * share}
    return setup.model_copy(update={**given, "name": f"variant {number}"})


def run_part(numbers: Sequence[int], mesh_size: float, device: str, share: float, watch_count: int) -> list[BatchRun]:
    """Variants in one batch."""
    from weavesim import run_batch

    logging.disable(logging.CRITICAL)  # in a process of its own too
    return run_batch([variant(number, mesh_size, device, share) for number in numbers], watch_count=watch_count)


def batch(
    device: Annotated[str, typer.Option(help="of the steps")] = "cpu",
    count: Annotated[int | None, typer.Option(help="variants [default: 8 on a CPU, 1000 on a GPU]")] = None,
    checked: Annotated[int, typer.Option(help="of them, run alone too")] = 3,
    mesh_size: Annotated[float, typer.Option(help="mesh size of the double domes [m]")] = 0.01,
    share: Annotated[float, typer.Option(help="of the duration of each run that is computed")] = 1.0,
    looks: Annotated[int, typer.Option(help="states of each run that the guards look at")] = 100,
    processes: Annotated[int, typer.Option(help="that share the variants, and the device")] = 1,
) -> None:
    """Quarters of the double dome that differ in friction, forces, strokes and fabric, together and alone."""
    logging.disable(logging.CRITICAL)  # doubts about coarse domes
    count = count or (8 if device == "cpu" else 1000)
    typer.echo(line_about(machine()))
    typer.echo(f"kernels ready after {_compile(variant(0, mesh_size, device, share), device):.0f} s")
    chosen = np.linspace(0, count - 1, min(checked, count)).round().astype(int).tolist()
    alone = {}
    # once more before the clock starts: the first run of a process is slower
    _run_alone(variant(chosen[0], mesh_size, device, 0.02 * share), looks)
    for number in chosen:
        alone[number] = _run_alone(variant(number, mesh_size, device, share), looks)
    started, processor = time.perf_counter(), time.process_time()
    parts = [list(range(first, count, processes)) for first in range(processes)]
    given = (mesh_size, device, share, looks)
    if processes == 1:
        runs = dict(zip(parts[0], run_part(parts[0], *given), strict=True))
    else:
        with ProcessPoolExecutor(processes, mp_context=multiprocessing.get_context("spawn")) as pool:
            found = [pool.submit(run_part, part, *given) for part in parts]
            runs = {
                number: run
                for part, done in zip(parts, found, strict=True)
                for number, run in zip(part, done.result(), strict=True)
            }
    wall, processor = time.perf_counter() - started, time.process_time() - processor
    _report(count, runs, alone, Cost(wall / count, processor / count), processes)


def _compile(setup: Setup, device: str) -> float:
    """Compile what runs alone and together need, side by side; returns the time that it took [s]."""
    from weavesim.device import resolve_device
    from weavesim.engine.compilation import KernelSet, compile_kernels
    from weavesim.engine.worlds.world_kernels import WorldKernelSet
    from weavesim.run.batch.worlds import host_setup

    spent = compile_kernels(KernelSet.of_setups([setup]))
    if not resolve_device(device).is_cpu:
        host = host_setup(setup)
        spent += compile_kernels(KernelSet.of_setups([host])) + compile_kernels(WorldKernelSet.of(host, device))
    return spent


def _run_alone(setup: Setup, looks: int) -> tuple[Any, Cost]:
    from weavesim import Simulation

    started, processor = time.perf_counter(), time.process_time()
    simulation = Simulation(setup, watch_count=looks)
    simulation.run()
    simulation.summary()
    cost = Cost(time.perf_counter() - started, time.process_time() - processor)
    return simulation, cost


def _report(
    count: int, runs: dict[int, BatchRun], alone: dict[int, tuple[Any, Cost]], cost: Cost, processes: int
) -> None:
    failed = [run.failure or str(run.outcome) for run in runs.values() if not run.finished]
    steps = sum(run.summary.get("step_count", 0) for run in runs.values())
    elements = next(iter(runs.values())).setup.sheet.blank.element_count
    stepping = sum(run.summary.get("stepping_time_s", 0.0) for run in runs.values()) / max(processes, 1)
    typer.echo(
        f"{count} variants of {elements} elements, {len(failed)} not finished, {steps} steps in all; "
        f"wall {cost.wall * count:.1f} s, of which about {stepping:.1f} s were steps\n"
    )
    for why in dict.fromkeys(failed):
        typer.echo(f"not finished: {why}")
    wall = float(np.mean([own.wall for _, own in alone.values()]))
    processor = float(np.mean([own.processor for _, own in alone.values()]))
    rows = [
        ["alone", f"{wall:.3f}", f"{processor:.3f}", "1", "1"],
        ["in the batch", f"{cost.wall:.3f}", f"{cost.processor:.3f}", f"{cost.wall / wall:.2f}",
         f"{cost.processor / processor:.2f}" if processes == 1 else ""],
    ]  # fmt: skip
    typer.echo(table(["a variant", "wall [s]", "processor [s]", "ratio", "ratio of processor time"], rows, right=True))
    rows = []
    for number, (single, _) in alone.items():
        own, other = single.frame, runs[number].frame
        if other is None:
            rows.append([number, runs[number].failure or "not run"])
            continue
        away = float(np.abs(own.position - other.position).max())
        angles = [float(np.abs(np.rad2deg(frame.fields["shear_angle"])).max()) for frame in (own, other)]
        same = own.position.tobytes() == other.position.tobytes()
        rows.append(
            [number, own.step_count, other.step_count, "same bits" if same else f"{1e6 * away:.3g} um",
             f"{angles[0]:.4f}", f"{angles[1]:.4f}"]
        )  # fmt: skip
    typer.echo("")
    head = [
        "variant",
        "steps alone",
        "in the batch",
        "positions differ by",
        "largest angle alone [deg]",
        "in the batch",
    ]
    typer.echo(table(head, rows, right=True))
