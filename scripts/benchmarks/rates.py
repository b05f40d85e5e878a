"""Element-steps per second of whole steps, and the phases of a step."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from ..shared.machine import machine
from ..shared.report import line_about, table, write_json
from .cases import CASES, DEFAULT_CASES, element_count, warm_up
from .measures import moved_bytes, moved_parts, phases, seconds_per_step, state_bytes

SCRIPT = Path(__file__).resolve().parents[1] / "benchmark.py"


def worker(case: str, precisions: str, threads: str, device: str, seconds: float, turns: int, avx512: bool) -> None:
    """One case in a separate process: a line of JSON per precision and number of threads."""
    import resource

    import weavesim.device as settings

    if not avx512:
        settings.X86_COMPILER_FLAGS = "-target-feature -avx512f"
    rows = []
    for precision in precisions.split(","):
        variants = []
        for thread_count in (int(count) for count in threads.split(",")):
            started = time.perf_counter()
            simulation = CASES[case](precision=precision, threads=thread_count, device=device)
            setup = time.perf_counter() - started - simulation.stepper.loading_time
            warm_up(simulation)
            variants.append((thread_count, simulation, setup, []))
        for _ in range(turns):
            for _, simulation, _, times in variants:
                times.append(seconds_per_step(simulation, seconds))
        for thread_count, simulation, setup, times in variants:
            count, step = element_count(simulation), min(times)
            rows.append(
                {
                    "case": case, "elements": count, "nodes": simulation.setup.sheet.blank.node_count,
                    "precision": precision,
                    "threads": thread_count, "device": device, "avx512": avx512,
                    "lanes": simulation.stepper.model.lane_count,
                    "setup_s": setup,
                    "kernels_s": simulation.stepper.loading_time,
                    "step_us": 1e6 * step, "median_step_us": 1e6 * float(np.median(times)),
                    "rate": count / step, "moved_bytes": moved_bytes(simulation),
                    "state_bytes": state_bytes(simulation), "turn_steps_us": [1e6 * t for t in times],
                }
            )  # fmt: skip
        rows[-len(variants)]["phases_us"] = {
            name: 1e6 * value for name, value in phases(variants[0][1], 0.3 * seconds).items()
        }
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)
    for row in rows:
        row["peak_memory_mb"] = peak / 2**20
        print(json.dumps(row), flush=True)


def rates(
    case: Annotated[list[str] | None, typer.Option(help=f"one of {', '.join(CASES)}; may be repeated")] = None,
    precision: Annotated[str, typer.Option(help="float32, float64, or both, comma-separated")] = "float32,float64",
    threads: Annotated[str | None, typer.Option(help="CPU thread counts, comma-separated [default: 1, all]")] = None,
    device: Annotated[str, typer.Option(help='"cpu", "cuda:0", ...')] = "cpu",
    seconds: Annotated[float, typer.Option(help="length of a turn")] = 1.0,
    turns: Annotated[int, typer.Option(help="turns per variant")] = 3,
    avx512: Annotated[bool, typer.Option(help="compile for AVX-512 where the processor has it")] = True,
    json_file: Annotated[Path | None, typer.Option("--json", help="write all numbers to this file")] = None,
    compare: Annotated[Path | None, typer.Option(help="an earlier --json file to compare with")] = None,
) -> None:
    """Element-steps per second of whole steps: cell, laws, gather, contact, update; without output."""
    from weavesim.device import available_threads

    names = case or list(DEFAULT_CASES)
    unknown = sorted(set(names) - set(CASES))
    if unknown:
        raise typer.BadParameter(f"{', '.join(unknown)}: choose from {', '.join(CASES)}", param_hint="--case")
    old = json.loads(compare.read_text()) if compare else None
    thread_list = threads or ",".join(map(str, sorted({1, available_threads()} if device == "cpu" else {1})))
    about = machine()
    rows = []
    for name in names:
        command = [sys.executable, str(SCRIPT), "worker", name, precision, thread_list, device]
        command += [str(seconds), str(turns), str(avx512)]
        done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False)
        if done.returncode:
            raise SystemExit(f"{name}: failed with exit code {done.returncode}; its message is above")
        rows += [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]
        typer.echo(f"{name}: done", err=True)
    result = {"machine": about, "rows": rows}
    if json_file is not None:
        write_json(json_file, result)
    typer.echo(report(result, old))


def report(result: dict[str, Any], old: dict[str, Any] | None = None) -> str:
    """Markdown tables of ``rates``, compared with an earlier result if given."""
    about, rows = result["machine"], result["rows"]
    before = {_key(row): row["rate"] for row in old["rows"]} if old else {}
    lines = [line_about(about), ""]
    head = ["case", "elements", "precision", "device", "threads", "step [us]", "M element-steps/s", "GB/s moved"]
    head += ["state [bytes/element]", "kernels [s]", "set-up [s]", "peak [MB]"] + (["ratio to before"] if old else [])
    table_rows = []
    for row in rows:
        cells = [
            row["case"], row["elements"], row["precision"], row["device"], row["threads"], f"{row['step_us']:.1f}",
            f"{row['rate'] / 1e6:.2f}", f"{row['rate'] * row['moved_bytes'] / 1e9:.1f}", f"{row['state_bytes']:.0f}",
            f"{row['kernels_s']:.1f}", f"{row['setup_s']:.2f}", f"{row['peak_memory_mb']:.0f}",
        ]  # fmt: skip
        if old:
            cells.append(f"{row['rate'] / before[_key(row)]:.2f}" if _key(row) in before else "new")
        table_rows.append(cells)
    names = next((list(row["phases_us"]) for row in rows if "phases_us" in row), [])
    phase_rows = [
        [row["case"], row["precision"], *(f"{value:.1f}" for value in row["phases_us"].values())]
        for row in rows
        if "phases_us" in row
    ]
    lines += [table(head, table_rows), "", "Phases on one thread, microseconds per launch:", ""]
    lines.append(table(["case", "precision", *names], phase_rows))
    return "\n".join(lines)


def _key(row: dict[str, Any]) -> tuple[Any, ...]:
    return tuple(row.get(name, True) for name in ("case", "precision", "device", "threads", "avx512"))


def counts(
    case: Annotated[list[str] | None, typer.Option(help=f"one of {', '.join(CASES)}; may be repeated")] = None,
    precision: Annotated[list[str] | None, typer.Option(help="float32, float64 [default: both]")] = None,
) -> None:
    """Bytes per element that a step reads and writes, and that a run keeps, by its arrays; nothing is timed."""
    columns, names = {}, case or ["patch_10k", "double_dome_2.5mm", "double_dome_10mm"]
    for one in precision or ["float32", "float64"]:
        for name in names:
            simulation = CASES[name](precision=one, threads=1)
            parts = moved_parts(simulation)
            columns[f"{name}, {one}"] = parts | {"sum": sum(parts.values()), "state": state_bytes(simulation)}
    rows = [[part, *(f"{column[part]:.0f}" for column in columns.values())] for part in next(iter(columns.values()))]
    typer.echo(table(["bytes per element and step", *columns], rows, right=True))
