"""Measurements of one simulation."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from .cases import element_count


def seconds_per_step(
    simulation: Any,
    seconds: float,
    largest_block_count: int = 50,
    clock: Callable[[], float] = time.perf_counter,
) -> float:
    """Time of one step, without output, over about ``seconds``, by a clock."""
    stepper = simulation.stepper
    first, started = stepper.step_count, clock()
    block_count = 1
    while (elapsed := clock() - started) < seconds:
        stepper.advance(block_count)
        _synchronise()
        block_count = min(2 * block_count, largest_block_count)
    return elapsed / (stepper.step_count - first)


def _synchronise() -> None:
    import warp as wp

    wp.synchronize()


def phases(simulation: Any, seconds: float) -> dict[str, float]:
    """Time [s] of each phase of a step, and of an output frame, on one thread; the state does not change."""
    repeats = 10
    result = {name: _repeat(phase, seconds) / repeats for name, phase in simulation.stepper.phases(repeats).items()}
    # these include the phases before them
    result["nodes and contact"] -= result["elements"]
    result["elements"] -= result.pop("copy")
    # the best of a few, as for the others: writing to disk stalls occasionally
    result["output frame"] = min(output_frame(simulation, 0.5 * seconds) for _ in range(3))
    return result


def output_frame(simulation: Any, seconds: float) -> float:
    """Mean time of an output frame of a run into a result folder: ledger, film, series (not for every frame), log.

    Measured over about ``seconds``, at least four frames, at most as many as a run has.
    """
    from weavesim.app.progress import RunLog
    from weavesim.output import ResultFolder
    from weavesim.run.frame import Outcome

    with TemporaryDirectory() as folder:
        observers = (ResultFolder(folder), RunLog(Path(folder)))
        for observer in observers:
            observer.start(simulation.info)
        for index in range(simulation.setup.frame_count + 1):
            if index == 1:  # preparations for the first frame are not counted
                started = time.perf_counter()
            time_now = simulation.setup.duration * index / simulation.setup.frame_count
            frame = replace(simulation.ledger.frame(index), time=time_now)
            simulation.ledger.penetration(frame)
            for observer in observers:
                observer.frame(frame)
            if index >= 4 and time.perf_counter() - started > seconds:
                break
        elapsed = time.perf_counter() - started
        for observer in observers:
            observer.finish(Outcome.INTERRUPTED)
    return elapsed / index


def _repeat(work: Callable[[], object], seconds: float) -> float:
    """Best time of one call, over about ``seconds``, at least two calls."""
    times, started = [], time.perf_counter()
    while time.perf_counter() - started < seconds or len(times) < 2:
        before = time.perf_counter()
        work()
        _synchronise()
        times.append(time.perf_counter() - before)
    return min(times)


def state_bytes(simulation: Any) -> float:
    """Allocated bytes per element of all arrays with constants and state of a run, without tables of curves."""
    tables = {array.ptr for array in simulation.stepper.model.tables()}
    arrays = (array for array in simulation.stepper.arrays() if array.ptr not in tables)
    return sum(array.capacity for array in arrays) / element_count(simulation)


def moved_bytes(simulation: Any) -> float:
    """Bytes per element that a step reads and writes if each kernel touches every array once (performance.md)."""
    return sum(moved_parts(simulation).values())


def moved_parts(simulation: Any) -> dict[str, float]:
    """The parts of ``moved_bytes``."""
    from weavesim.kernels.rows import CORNER_ROW_COUNT, CellReportRow, MotionRow, ThicknessRow

    model = simulation.stepper.model.sheet
    size, per_node = model.precision.numpy.itemsize, model.blank.node_count / model.blank.element_count
    flat = 4 * 4 + size * (4 + 2 + 1)
    if not model.sheet_traits.flat:
        flat += size * 8
    own_rows = model.cell_law.unknown_count + model.cell_law.slope_count + CellReportRow.row_count()
    slots = model.nodes.corner_offset.shape[0]
    thickness = ThicknessRow.row_count() if model.follows_thickness else 0
    return {
        "constants of elements": flat,
        "motion of nodes, for elements": per_node * size * 3 * 4,
        "cell: unknowns, report": 2 * size * own_rows,
        "corners, written and read": 2 * size * CORNER_ROW_COUNT,
        "constants of nodes": per_node * (4 * slots + 4 + size * 4),
        "motion of nodes": 2 * per_node * size * (MotionRow.row_count() + thickness),
        "works": 2 * per_node * size * len(model.node_work_rows),
        "friction springs of tools": 2 * per_node * size * 3 * model.tool_count,
    }
