"""Time from the command to the first step of a run, and of a whole run by its parts, with compiled kernels."""

from __future__ import annotations

import json
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
# What a command says of a run when its last step is done.
END = b"finished"


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


class Whole(NamedTuple):
    """Of a run [s]: wall time of its parts, which may overlap by a first frame or a last one."""

    start: float
    stepping: float
    output: float
    after: float
    all: float


def whole_run(arguments: Sequence[str]) -> Whole:
    """Run the command of this checkout to its end."""
    variables = {name: value for name, value in environment(ROOT).items() if name != "PYTHONDONTWRITEBYTECODE"}
    with TemporaryDirectory() as folder:
        out = Path(folder, "out")
        command = [sys.executable, "-P", "-m", "weavesim", *arguments, "--out", str(out)]
        began, at = time.perf_counter(), dict[bytes, float]()
        with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, env=variables) as process:
            for line in process.stderr:
                at |= {mark: time.perf_counter() for mark in (BEGIN, END) if mark in line and mark not in at}
        ended = time.perf_counter()
        # 3: finished, with doubts
        if process.returncode not in (0, 3) or len(at) != 2:
            raise SystemExit(f"{' '.join(command)}: exit code {process.returncode}")
        summary = json.loads((out / "summary.json").read_text())
    taken = (summary["stepping_time_s"], summary["output_time_s"])
    return Whole(at[BEGIN] - began, *taken, ended - at[END], ended - began)


def whole(
    arguments: Annotated[
        list[str] | None, typer.Argument(help="of the command, after -- where there are options [default: double-dome]")
    ] = None,
    turns: Annotated[int, typer.Option(min=1, help="runs")] = 3,
) -> None:
    """Wall time of whole runs, from the command to the end of its process; the first may compile kernels."""
    given = tuple(arguments or DEFAULT)
    rows = []
    for number in range(turns + 1):
        run = whole_run(given)
        share = run.output / (run.stepping + run.output)
        times = [f"{value:.2f}" for value in run]
        rows.append([number or "first", *times[:3], f"{share:.0%}", *times[3:]])
    typer.echo(f"weavesim {' '.join(given)}: s of wall time; {line_about(machine())}")
    parts = ("to the first step", "stepping", "output within the run", "share of both", "after the last step", "all")
    typer.echo(table(["run", *parts], rows, right=True))
