"""Processor time to compile all kernels of a scene from an empty cache, for every unit cell."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence
from tempfile import TemporaryDirectory
from typing import Annotated

import typer

from ...shared.checkouts import ROOT, environment
from ...shared.machine import machine
from ...shared.report import line_about, table


def processor_time(command: Sequence[str], variables: dict[str, str]) -> float:
    """Processor time of a process and of those that it waits for [s].

    Raises:
        CalledProcessError: it failed.
    """
    before = os.times()
    subprocess.run(command, env=variables, stdout=subprocess.DEVNULL, check=True)
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system


def seconds_to_compile(scene: str, unit_cell: str, precision: str) -> float:
    """Processor time of ``weavesim compile`` with an empty cache, start of Python included [s]."""
    options = ["--scene", scene, "--unit-cell", unit_cell, "--precision", precision, "--processes", "1"]
    with TemporaryDirectory() as folder:
        variables = environment(ROOT) | {"WARP_CACHE_PATH": folder}
        return processor_time([sys.executable, "-m", "weavesim", "compile", *options], variables)


def compiling(
    unit_cell: Annotated[list[str] | None, typer.Option(help="may be repeated [default: all]")] = None,
    precision: Annotated[list[str] | None, typer.Option(help="float32, float64 [default: both]")] = None,
    scene: Annotated[str, typer.Option(help="whose kernels")] = "double-dome",
    turns: Annotated[int, typer.Option(min=1, help="of which the least counts")] = 1,
) -> None:
    """Processor time to compile the kernels of a scene from an empty cache, for every unit cell."""
    from weavesim.fabric.presets import UNIT_CELLS

    precisions = precision or ["float32", "float64"]
    rows = []
    for name in unit_cell or UNIT_CELLS:
        times = [min(seconds_to_compile(scene, name, one) for _ in range(turns)) for one in precisions]
        rows.append([name, *(f"{seconds:.0f}" for seconds in times)])
        typer.echo(" ".join(rows[-1]), err=True)
    typer.echo(line_about(machine()))
    typer.echo(f"\n{scene}: processor time to compile [s]\n\n" + table(["unit cell", *precisions], rows, right=True))
