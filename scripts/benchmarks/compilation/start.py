"""Time from the command to the first step of a run, with compiled kernels."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, NamedTuple

import numpy as np
import typer

from ...shared.checkouts import ROOT, environment
from ...shared.machine import machine
from ...shared.report import line_about, table

DEFAULT = ("double-dome",)
# The progress of a run begins with it, once everything is prepared: ten milliseconds before the first step.
BEGIN = b" 0%"


class Start(NamedTuple):
    """Of a command, up to its first step: wall time and processor time [s]."""

    wall: float
    processor: float


def start_of(checkout: Path, arguments: Sequence[str]) -> Start:
    """Start the command of a checkout, and end it when its run begins."""
    # bytecode is kept, as for an installed package
    variables = {name: value for name, value in environment(checkout).items() if name != "PYTHONDONTWRITEBYTECODE"}
    with TemporaryDirectory() as folder:
        command = [sys.executable, "-P", "-m", "weavesim", *arguments, "--out", str(Path(folder, "out"))]
        started, said = time.perf_counter(), []
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, env=variables)
        for line in process.stderr:
            said.append(line)
            if BEGIN in line:
                break
        wall = time.perf_counter() - started
        # not process.kill(), which would wait for one that has ended, and its usage would be lost
        os.kill(process.pid, signal.SIGKILL)
        _, _, usage = os.wait4(process.pid, 0)
        process.returncode = 0
        process.stderr.close()
    if BEGIN not in said[-1]:
        raise SystemExit(f"{checkout}: no run has begun: {b''.join(said).decode()}")
    return Start(wall, usage.ru_utime + usage.ru_stime)


def start(
    arguments: Annotated[
        list[str] | None, typer.Argument(help="of the command, after -- where there are options [default: double-dome]")
    ] = None,
    against: Annotated[Path | None, typer.Option(exists=True, file_okay=False, help="another version's folder")] = None,
    turns: Annotated[int, typer.Option(min=1, help="starts of each version")] = 5,
) -> None:
    """Time from the command to the first step; a first start of each version, which may compile, is not counted."""
    checkouts = {"this checkout": ROOT} if against is None else {"the other one": against.resolve(), "this one": ROOT}
    given = tuple(arguments or DEFAULT)
    every = [[start_of(checkout, given) for checkout in checkouts.values()] for _ in range(turns + 1)]
    wall, processor = np.array(every[1:]).transpose(2, 0, 1)
    rows = [
        [name, *(f"{value:.2f}" for of in (wall, processor) for value in (of[:, k].min(), np.median(of[:, k]))),
         f"{np.median(processor[:, k] / processor[:, 0]):.2f}"]
        for k, name in enumerate(checkouts)
    ]  # fmt: skip
    typer.echo(f"weavesim {' '.join(given)}: s to the first step, {turns} turns; {line_about(machine())}")
    head = ["", "wall time, least", "median", "processor time, least", "median", "ratio of processor time"]
    typer.echo(table(head, rows, right=True))
