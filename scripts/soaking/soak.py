"""What takes hours: runs that are killed a thousand times, ten thousand damaged files per reader, a million steps.

    python scripts/soaking/soak.py                            everything
    python scripts/soaking/soak.py --part kills --count 200   one part, shorter
    python scripts/soaking/soak.py --part kills --seed 2      and with other chances

Every part prints its progress, and FAILED with what is needed to repeat it. The exit code is 1 if anything failed.
docs/reliability.md has the figures.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, NamedTuple

import typer

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from scripts.soaking import cells, damage, endurance, extremes, kills  # noqa: E402


class Part(NamedTuple):
    """One part of the soak: its function, how often it repeats what it does, and what that is."""

    run: Callable[[Path, int, int], bool]
    count: int
    text: str


PARTS = {
    "kills": Part(kills.kills, 1000, "runs killed at random moments and resumed"),
    "damage": Part(damage.damage, 10_000, "damaged files for every reader"),
    "cells": Part(cells.cells, 10_000_000, "random states of unit cells"),
    "extremes": Part(extremes.extremes, 1000, "extreme but legal runs, at most"),
    "extremes-in-single": Part(extremes.extremes_in_single, 1000, "of these in single precision, at most"),
    "runs": Part(endurance.runs, 100, "runs in one process"),
    "steps": Part(endurance.steps, 1_000_000, "steps of one run"),
}


def main(
    part: Annotated[list[str] | None, typer.Option(help=f"one of {', '.join(PARTS)}; may be repeated")] = None,
    count: Annotated[int | None, typer.Option(min=1, help="repetitions [default: those of the part]")] = None,
    seed: Annotated[int, typer.Option(min=0, help="of all random choices")] = 1,
    folder: Annotated[Path | None, typer.Option(help="for files [default: a temporary one]")] = None,
) -> None:
    """Run parts of the soak."""
    if unknown := set(part or ()) - set(PARTS):
        raise typer.BadParameter(f"{', '.join(sorted(unknown))}: choose from {', '.join(PARTS)}")
    failed = []
    with tempfile.TemporaryDirectory(prefix="weavesim-soak-") as temporary:
        for name in part or PARTS:
            chosen, started = PARTS[name], time.monotonic()
            print(f"== {name}: {count or chosen.count:,} {chosen.text}, seed {seed}", flush=True)
            well = chosen.run((folder or Path(temporary)) / name, count or chosen.count, seed)
            print(f"== {name}: {'passed' if well else 'FAILED'} in {time.monotonic() - started:.0f} s", flush=True)
            failed += [] if well else [name]
    if failed:
        raise typer.Exit(1)


if __name__ == "__main__":
    typer.run(main)
