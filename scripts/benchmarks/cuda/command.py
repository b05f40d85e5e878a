"""The command that records what kernels need on CUDA devices, and shows it."""

from __future__ import annotations

import multiprocessing
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from typing import TYPE_CHECKING, Annotated

import typer

from .record import RECORD, Record, renewed
from .resources import Resources, resources
from .tables import comparison_table, prediction_table, register_table

if TYPE_CHECKING:
    import warp as wp

PRECISIONS = ("float32", "float64")


def cuda(
    record: Annotated[bool, typer.Option(help="build what has changed since the record, and write it anew")] = False,
    anew: Annotated[bool, typer.Option(help="with --record: build all")] = False,
    processes: Annotated[int, typer.Option(min=1, help="with --record: that build side by side")] = 2,
) -> None:
    """Registers, stack and instructions of every kernel on CUDA devices, without one, from the record."""
    if not record:
        typer.echo(register_table(Record.read()))
        return
    import warp as wp

    from weavesim.device import initialise
    from weavesim.kernel_cache import hashed_once

    initialise()
    before = Record("") if anew or not RECORD.exists() else Record.read()
    kernels = _kernels()
    with hashed_once():
        new, grown = renewed(
            before, kernels, wp.config.version, lambda wanted: _built(kernels, wanted, processes), Record.write
        )
    new.write()
    for line in grown:
        typer.echo(line)
    typer.echo(f"{RECORD.name}: {len(new.entries)} kernels; {len(grown)} numbers exceed the record before")


def predict() -> None:
    """A step on an H100, and on an H200 beside what was measured there; takes neither."""
    record = Record.read()
    typer.echo(prediction_table(record))
    typer.echo()
    typer.echo(comparison_table(record))


def _kernels() -> dict[str, dict[wp.Kernel, list[str]]]:
    from .users import kernels_by_user

    return {precision: kernels_by_user(precision) for precision in PRECISIONS}


def _built(
    kernels: dict[str, dict[wp.Kernel, list[str]]], wanted: list[tuple[wp.Kernel, int]], processes: int
) -> Iterator[Resources]:
    """What each of ``wanted`` needs; other processes are told its place among all kernels, which they make anew."""
    places = {kernel: place for place, kernel in enumerate(_in_order(kernels))}
    with ProcessPoolExecutor(processes, mp_context=multiprocessing.get_context("spawn")) as pool:
        yield from pool.map(_build, [(places[kernel], architecture) for kernel, architecture in wanted])


def _in_order(kernels: dict[str, dict[wp.Kernel, list[str]]]) -> list[wp.Kernel]:
    return [kernel for of in kernels.values() for kernel in of]


_own: list[wp.Kernel] = []


def _build(job: tuple[int, int]) -> Resources:
    if not _own:
        from weavesim.device import initialise

        initialise()
        _own.extend(_in_order(_kernels()))
    place, architecture = job
    return resources(_own[place], architecture)
