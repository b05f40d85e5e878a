"""``weavesim view``: what a run found, and its report in a browser."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from ...errors import InputError
from ..terminal import say
from .folders import read_record, read_summary

# Numbers that are shown, where a run has them.
SHOWN = (
    "max_shear_angle_deg", "draw_in_long_axis_mm", "draw_in_short_axis_mm", "min_thickness_mm", "max_thickness_mm",
    "min_fibre_volume_fraction", "max_fibre_volume_fraction", "fold_count", "wrinkle_amplitude_mm",
    "self_intersections", "kinetic_energy_ratio", "energy_balance_error", "wall_time_s",
)  # fmt: skip


def view_command(
    out: Annotated[Path, typer.Argument(help="folder of a run", metavar="OUT")],
    open_: Annotated[
        bool, typer.Option("--open/--no-open", help="open the report in a browser, or only say where it is")
    ] = True,
    live: Annotated[
        bool, typer.Option("--live", help="keep up with a run in progress, until Ctrl-C; the run may begin later")
    ] = False,
    port: Annotated[
        int, typer.Option(min=0, max=65535, help="of --live, on this machine only; 0 takes a free one")
    ] = 0,
) -> None:
    """Show what a run found: its verdict, its main numbers and files; and open its report."""
    if live:
        from ..results.live import show_live

        show_live(out, port, open_)
        return
    if port:
        raise InputError("--port: has no effect without --live; leave it out")
    record, summary = read_record(out), read_summary(out)
    for line in description(out, record, summary):
        say(line)
    report = out / "report.html"
    if report.is_file():
        import webbrowser

        say(f"Report: {report}")
        if open_ and not webbrowser.open(report.absolute().as_uri()):
            say("No browser could be opened here: open that file yourself.")


def description(out: Path, record: Mapping[str, Any], summary: Mapping[str, Any]) -> Iterator[str]:
    """A run in a few lines.

    Args:
        out: its folder.
        record: ``run.json``.
        summary: ``summary.json``; {} if the run has none.
    """
    outcome = record.get("outcome") or "running, or ended without a trace"
    yield f"{record.get('name', 'run')}: {outcome}, started {record.get('started', 'at an unknown time')}"
    if "verdict" in summary:
        yield f"verdict: {summary['verdict']}"
    for key in SHOWN:
        value = summary.get(key)
        if isinstance(value, int | float):
            yield f"  {key.replace('_', ' '):<32} {value:.4g}"
    for name, force in (summary.get("peak_tool_force_n") or {}).items():
        yield f"  {f'peak force of {name} n':<32} {force:.4g}"
    warnings = list(summary.get("warnings") or ())
    for warning in warnings:
        yield f"warning: {warning}"
    files = sorted(name for name in record.get("files", {}) if (out / name).is_file())
    pictures = [name for name in files if name.endswith((".png", ".svg"))]
    if pictures:
        yield f"pictures: {', '.join(pictures)}"
    others = [name for name in files if name not in pictures and not name.startswith("paraview/")]
    if any(name.startswith("paraview/") for name in files):
        others.append("paraview/")
    yield f"files: {', '.join(others)}"
