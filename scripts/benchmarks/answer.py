"""How long the double dome takes from the command to an answer that is within a tolerance of the converged one."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import numpy as np
import typer

from ..shared.machine import ROOT, machine
from ..shared.report import line_about, table

if TYPE_CHECKING:
    from weavesim.output.stored.file import StoredRun, StoredSheet

# Tolerances: shear angle, at this share of the elements [degrees], and every place of the border [mm].
KEPT_SHARE, ANGLE, BORDER = 0.95, 0.5, 0.5


@dataclass(frozen=True)
class Contestant:
    """A mesh and what its step is multiplied by."""

    mesh_size: float
    factor: float

    def options(self) -> list[str]:
        """Of the command."""
        given = ["--mesh-size", f"{self.mesh_size:.9g}"]
        return given if self.factor == 1.0 else [*given, "--target-step", f"{self.factor * _stable_step(self):.6g}"]


def answer(
    reference: Annotated[Path | None, typer.Option(help="folder of the finest run; made where it is missing")] = None,
    reference_size: Annotated[float, typer.Option(help="mesh size of the finest run [m]")] = 0.00125,
    mesh_size: Annotated[list[float] | None, typer.Option(help="[m]; may be repeated [default: 5 and 2.5 mm]")] = None,
    factor: Annotated[
        list[float] | None, typer.Option(help="of the step, by mass scaling; may be repeated [default: 1, 4 and 6]")
    ] = None,
    turns: Annotated[int, typer.Option(min=1, help="runs of each, of which the median counts")] = 3,
) -> None:
    """Time from the command to the summary, and the distance to the converged answer."""
    from weavesim.output.stored.file import read_results

    typer.echo(line_about(machine()))
    contestants = [Contestant(size, by) for size in mesh_size or (0.005, 0.0025) for by in factor or (1.0, 4.0, 6.0)]
    with tempfile.TemporaryDirectory(prefix="weavesim-answer-") as temporary:
        finest = reference or Path(temporary) / "reference"
        if not (finest / "results.h5").exists():
            typer.echo(f"the converged answer, elements of {1e3 * reference_size:g} mm, in {finest} ...")
            took = run(Contestant(reference_size, 1.0), finest)
            typer.echo(f"took {took.wall:.0f} s")
        converged, rows = read_results(finest), []
        for number, each in enumerate(contestants):
            out = Path(temporary) / str(number)
            times = [run(each, out) for _ in range(turns + 1)][1:]  # the first may compile kernels
            rows.append(_row(each, read_results(out), converged, times))
    typer.echo(
        table(
            ["mesh [mm]", "step", f"angle at {KEPT_SHARE:.0%} [degrees]", "largest", "border [mm]", "steps",
             "command to summary [s]", "least", "processor time [s]", f"within {ANGLE:g} degrees and {BORDER:g} mm",
             "verdict"],
            rows,
        )
    )  # fmt: skip


class Times(NamedTuple):
    """Of a command, from its start to its end [s]; where others use the cores, processor time tells more."""

    wall: float
    processor: float


def run(contestant: Contestant, folder: Path) -> Times:
    """Run the command with its summary and its results."""
    command = [sys.executable, "scripts/double_dome.py", *contestant.options(), "--out", str(folder), "--overwrite"]
    # an installed package has its modules compiled, whatever this shell asks of Python
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    started, before = time.perf_counter(), _of_children()
    ended = subprocess.run(
        [*command, "--write", "summary,results"], cwd=ROOT, env=environment, capture_output=True, text=True
    )
    took = Times(time.perf_counter() - started, _of_children() - before)
    # 3: finished, with doubts; mass scaling raises the kinetic energy, which a guard tells
    if ended.returncode not in (0, 3):
        raise SystemExit(f"{' '.join(command)}\n{ended.stdout}{ended.stderr}")
    return took


def _of_children() -> float:
    """Processor time of all processes that have ended [s]; zero where the system does not tell."""
    now = os.times()
    return now.children_user + now.children_system


def _row(contestant: Contestant, found: StoredRun, converged: StoredRun, times: list[Times]) -> list[str]:
    from weavesim.output.stored.file import recorded_summary

    sheet, other = found.sheets[0], converged.sheets[0]
    angles, border = errors(sheet, other)
    kept = float(np.quantile(angles, KEPT_SHARE))
    summary = recorded_summary(found.folder)
    return [
        f"{1e3 * contestant.mesh_size:g}", f"x {contestant.factor:g}", f"{kept:.2f}", f"{angles.max():.2f}",
        f"{border.max():.2f}", f"{summary['step_count']:,}", f"{np.median([each.wall for each in times]):.2f}",
        f"{min(each.wall for each in times):.2f}", f"{np.median([each.processor for each in times]):.2f}",
        "yes" if kept <= ANGLE and border.max() <= BORDER else "no", str(summary["verdict"]),
    ]  # fmt: skip


def errors(sheet: StoredSheet, other: StoredSheet) -> tuple[np.ndarray, np.ndarray]:
    """Differences of the elements' shear angles [degrees], and distances of the border's nodes [mm]."""
    from weavesim.measures.border import outline
    from weavesim.output.comparison.runs import compare_sheets

    comparison = compare_sheets(sheet, other, "the converged answer")
    own, there = comparison.values["shear_angle_deg"]
    distance = 1e3 * comparison.distance[outline(sheet.blank, sheet.symmetry).node]
    return np.abs(own - there)[np.isfinite(there)], distance[np.isfinite(distance)]


def _stable_step(contestant: Contestant) -> float:
    """Stable step of a mesh before anything moves [s]."""
    from weavesim.engine.model import Model
    from weavesim.scenes.double_dome import DoubleDomeParameters, double_dome

    return Model(double_dome(DoubleDomeParameters(mesh_size=contestant.mesh_size))).reference_step
