"""Newton's cloth solvers and weavesim on the same drape: the command."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from ..shared.machine import machine
from ..shared.report import line_about, write_json
from .competition import compete, newton_versions
from .contestants import CONTESTANTS, PEERS
from .problem import FABRICS, make_problem
from .report import report


def peers(
    contestant: Annotated[list[str] | None, typer.Option(help="one of the table's names; may be repeated")] = None,
    fabric: Annotated[list[str] | None, typer.Option(help="cloth, glass, glass-straight; may be repeated")] = None,
    quads: Annotated[int, typer.Option(min=2, help="elements along a side of weavesim's sheet")] = 50,
    seconds_simulated: Annotated[float, typer.Option(min=1e-3, help="length of the drape [s]")] = 0.3,
    limit: Annotated[float, typer.Option(min=0.0, help="time limit for the steps of a contestant [s]")] = 60.0,
    device: Annotated[str, typer.Option(help='"cpu", "cuda:0", ...')] = "cpu",
    newton_python: Annotated[
        str, typer.Option(help="Python interpreter of an environment with newton [default: this one]")
    ] = sys.executable,
    json_file: Annotated[Path | None, typer.Option("--json", help="write all numbers to this file")] = None,
) -> None:
    """Newton's cloth solvers and weavesim on the same drape: stiffness, rate and accuracy."""
    names, fabrics = contestant or list(CONTESTANTS), fabric or list(FABRICS)
    for given, known, option in ((names, CONTESTANTS, "contestant"), (fabrics, FABRICS, "fabric")):
        if unknown := sorted(set(given) - set(known)):
            raise typer.BadParameter(f"{', '.join(unknown)}: choose from {', '.join(known)}", param_hint=f"--{option}")
    about: dict[str, Any] = {}
    if set(names) & set(PEERS):
        versions = newton_versions(newton_python)
        if versions is None:
            raise typer.BadParameter(
                f"{newton_python} has no Newton: install it with '{newton_python} -m pip install \"newton>=1.8\"', "
                "or specify the interpreter of an environment that has it",
                param_hint="--newton-python",
            )
        about = versions
    about = machine() | about
    rows = []
    for name in fabrics:
        problem = make_problem(name, quads, seconds_simulated)
        for row in compete(problem, names, device, limit, newton_python):
            rows.append(row)
            typer.echo(f"{name}, {row['contestant']}: {row.get('error', 'done')}", err=True)
    if json_file is not None:
        write_json(json_file, {"machine": about, "rows": rows})
    typer.echo(line_about(about))
    typer.echo(f"\n{quads} x {quads} quadrilaterals, {seconds_simulated} s simulated, on {device}\n")
    typer.echo(report(rows))
