"""Limits of the machine on one core."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Annotated

import numpy as np
import typer

from ..shared.machine import machine
from ..shared.report import line_about, table


def bounds(
    megabytes: Annotated[int, typer.Option(help="size of the copied arrays [MB]")] = 256,
    turns: Annotated[int, typer.Option(help="turns per measurement; the best counts")] = 5,
) -> None:
    """Limits of the machine on one core: copy bandwidth, and multiply-adds in lanes as the kernels use them."""
    rows = []
    for size in (64 * 2**10, 2**20, megabytes * 2**20):
        source = np.ones(size // 8)
        target = np.empty_like(source)
        repeats = max(1, 64 * 2**20 // size)
        best = min(_copy_seconds(source, target, repeats) for _ in range(turns))
        label = f"{size // 2**10} KB" if size < 2**20 else f"{size // 2**20} MB"
        rows.append([f"copy of {label}, read and written", f"{2e-9 * size * repeats / best:.1f} GB/s"])
    for precision in ("float32", "float64"):
        rate = multiply_add_rate(precision, turns)
        rows.append([f"multiply-adds in lanes, {precision}", f"{rate / 1e9:.1f} GFlop/s"])
    typer.echo(f"{line_about(machine())}\n\n{table(['bound, one core', ''], rows)}")


def _copy_seconds(source: np.ndarray, target: np.ndarray, repeats: int) -> float:
    started = time.perf_counter()
    for _ in range(repeats):
        np.copyto(target, source)
    return time.perf_counter() - started


def _timed(work: Callable[[], object]) -> float:
    started = time.perf_counter()
    work()
    return time.perf_counter() - started


def multiply_add_rate(precision: str, turns: int) -> float:
    """Operations per second (two per multiply-add) of eight independent chains of lanes on one core."""
    import warp as wp

    from weavesim.device import initialise, resolve_precision
    from weavesim.kernels.lane_types import CPU_LANE_COUNT, lane_types

    initialise()
    real = resolve_precision(precision).real
    lanes = lane_types(real, CPU_LANE_COUNT).lanes
    chain_count, repeat_count, thread_count = 8, 2000, 64

    @wp.kernel(module="unique", enable_backward=False)
    def chains(values: wp.array2d(dtype=lanes)):
        i = wp.tid()
        factor = lanes(real(0.999))
        one = lanes(real(0.001))
        a0 = values[i, 0] + one
        a1 = values[i, 1] + one
        a2 = values[i, 2] + one
        a3 = values[i, 3] + one
        a4 = values[i, 4] + one
        a5 = values[i, 5] + one
        a6 = values[i, 6] + one
        a7 = values[i, 7] + one
        k = wp.int32(0)
        while k < repeat_count:
            a0 = wp.cw_mul(a0, factor) + one
            a1 = wp.cw_mul(a1, factor) + one
            a2 = wp.cw_mul(a2, factor) + one
            a3 = wp.cw_mul(a3, factor) + one
            a4 = wp.cw_mul(a4, factor) + one
            a5 = wp.cw_mul(a5, factor) + one
            a6 = wp.cw_mul(a6, factor) + one
            a7 = wp.cw_mul(a7, factor) + one
            k = k + 1
        values[i, 0] = a0 + a1 + a2 + a3 + a4 + a5 + a6 + a7

    values = wp.ones((thread_count, chain_count), dtype=lanes, device="cpu")
    wp.launch(chains, dim=thread_count, inputs=[values], device="cpu")
    best = min(_timed(lambda: wp.launch(chains, dim=thread_count, inputs=[values], device="cpu")) for _ in range(turns))
    return 2.0 * CPU_LANE_COUNT * chain_count * repeat_count * thread_count / best
