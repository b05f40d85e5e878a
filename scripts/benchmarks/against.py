"""A case in another checkout and in this one, in alternating turns."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from ..shared.checkouts import ROOT, environment
from .cases import CASES
from .ratios import ratio_table

CONTESTANT = Path(__file__).with_name("contestant.py").resolve()


class Contestant:
    """A case that steps in a separate process, in one checkout."""

    def __init__(self, checkout: Path, case: str, precision: str, threads: int) -> None:
        self._process = subprocess.Popen(
            [sys.executable, str(CONTESTANT), case, precision, str(threads)],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=checkout,
            env=environment(checkout),
        )  # fmt: skip
        self.element_count = int(self._answer())

    def _answer(self) -> str:
        line = self._process.stdout.readline()
        if not line:
            raise SystemExit("a contestant failed; its message is above")
        return line

    def turn(self, block_count: int) -> float:
        """Nanoseconds per element and step."""
        self._process.stdin.write(f"{block_count}\n")
        self._process.stdin.flush()
        return float(self._answer())

    def close(self) -> None:
        """End its process."""
        self._process.stdin.close()
        self._process.wait()


def against(
    checkout: Annotated[Path, typer.Argument(exists=True, file_okay=False, help="folder of another version")],
    case: Annotated[str, typer.Option(help=f"one of {', '.join(CASES)}")] = "double_dome_10mm",
    turns: Annotated[int, typer.Option(help="turns per checkout")] = 20,
    blocks: Annotated[int, typer.Option(help="blocks of 20 steps per turn")] = 50,
    precision: Annotated[str, typer.Option(help="float32 or float64")] = "float32",
    threads: Annotated[int, typer.Option(help="CPU threads; with one, processor time is measured, else wall time")] = 1,
) -> None:
    """Time a case in another checkout (git worktree add) and in this one, in alternating turns."""
    if case not in CASES:
        raise typer.BadParameter(f"{case}: choose from {', '.join(CASES)}", param_hint="--case")
    contestants = [Contestant(folder.resolve(), case, precision, threads) for folder in (checkout, ROOT)]
    times = np.array([[contestant.turn(blocks) for contestant in contestants] for _ in range(turns)])
    for contestant in contestants:
        contestant.close()
    typer.echo(
        f"{case}, {contestants[0].element_count} elements, {precision}, {threads} threads, {turns} turns of "
        f"{20 * blocks} steps"
    )
    typer.echo(ratio_table(["the other checkout", "this checkout"], times))
