"""What a run will take: steps, time, memory and disk, estimated before it starts.

The figures are those of docs/performance.md for one core, a GPU, and the writers; a run may well take half or twice as
long. They are to tell an afternoon from a year.
"""

from __future__ import annotations

import math
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from ..device import Precision, available_memory
from ..engine.setup import Setup
from ..errors import InputError
from ..ranges import ACCEPTING

# Elements times steps per second: of a core and of a GPU in single precision. Double precision takes twice as long.
CORE_RATE, GPU_RATE = 15.0e6, 4.0e9
# Smallest time of a step [s], which small meshes take.
CORE_STEP, GPU_STEP = 15.0e-6, 20.0e-6
# Of a node and a mesh of a tool, on one core [s].
MESH_TIME = 15.0e-9
# Time of a frame with its files [s]: of each, and per element.
FRAME_TIME, FRAME_TIME_PER_ELEMENT = 3.0e-3, 2.0e-6
# Largest need of memory, while a run is prepared, and need per frame of the history [bytes].
BYTES_PER_ELEMENT, BYTES_PER_FRAME = 2000.0, 2000.0
# Disk: per frame, of the film for a computed element and of the ParaView series for one of the whole part; and of the
# pictures and the report [bytes].
FILM_BYTES, SERIES_BYTES, REPORT_BYTES = 90.0, 90.0, 5.0e6
# The page keeps frames in memory and then in its file, per element and frame, up to a largest size [bytes].
PAGE_MEMORY, PAGE_BYTES, LARGEST_PAGE_MEMORY = 70.0, 15.0, 64.0e6
# Beyond these a user is asked.
LARGEST_STEP_COUNT = 1.0e8
LONGEST_TIME = 24.0 * 3600.0


@dataclass(frozen=True)
class Estimate:
    """What a run takes, roughly.

    Attributes:
        element_count: of all sheets.
        frame_count: after the first.
        step_count: of the time step at the start; None before that is known.
        time_step: at the start [s].
        seconds: of the whole run; None before the time step is known.
        memory, disk: [bytes].
    """

    element_count: int
    frame_count: int
    step_count: float | None
    time_step: float | None
    seconds: float | None
    memory: float
    disk: float

    def __str__(self) -> str:
        memory, disk = (max(1.0, size / 1.0e6) for size in (self.memory, self.disk))
        parts = [f"{memory:,.0f} MB of memory", f"{disk:,.0f} MB on disk"]
        if self.step_count is not None and self.time_step is not None and self.seconds is not None:
            steps = f"{self.step_count:,.0f} steps of {1e6 * self.time_step:.3g} us"
            parts = [steps, duration_text(self.seconds), *parts]
        return f"about {', '.join(parts)}"


def duration_text(seconds: float) -> str:
    """``seconds`` in the unit in which people would say it."""
    for size, unit in ((365.25 * 86400.0, "years"), (86400.0, "days"), (3600.0, "h"), (60.0, "min")):
        if seconds >= 2.0 * size:
            return f"{seconds / size:,.0f} {unit}"
    return f"{max(1.0, seconds):.0f} s"


def estimate(setup: Setup, *, time_step: float | None = None, thread_count: int = 1, is_cpu: bool = True) -> Estimate:
    """What a run takes.

    Args:
        setup: of the run.
        time_step: at its start [s], once it is known.
        thread_count: of a CPU.
        is_cpu: whether it runs on a CPU.
    """
    elements = sum(sheet.blank.element_count for sheet in setup.sheets)
    whole = sum(s.blank.element_count / world.symmetry.share for world in setup.worlds for s in world.sheets)
    frames = sum(setup.frame_counts)
    step_count = seconds = None
    if time_step is not None:
        step_count = setup.duration / time_step if time_step > 0.0 else math.inf
        slower = 1.0 if setup.solver.precision is Precision.SINGLE else 2.0
        rate = CORE_RATE * max(1.0, 0.8 * thread_count) if is_cpu else GPU_RATE
        per_step = max(CORE_STEP if is_cpu else GPU_STEP, slower * elements / rate)
        per_step += mesh_nodes(setup) * MESH_TIME * CORE_RATE / rate
        seconds = step_count * per_step + frames * (FRAME_TIME + FRAME_TIME_PER_ELEMENT * elements)
    on_page = min(PAGE_MEMORY * frames * elements, LARGEST_PAGE_MEMORY)
    return Estimate(
        elements,
        frames,
        step_count,
        time_step,
        seconds,
        memory=BYTES_PER_ELEMENT * elements + BYTES_PER_FRAME * frames + on_page,
        disk=frames * (FILM_BYTES * elements + SERIES_BYTES * whole)
        + on_page * PAGE_BYTES / PAGE_MEMORY
        + REPORT_BYTES,
    )


def mesh_nodes(setup: Setup) -> int:
    """Nodes times parts of tools that are meshes, of all worlds."""
    return sum(
        sum(sheet.blank.node_count for sheet in world.sheets)
        * sum(part.surface is not None for tool in world.tools for part in tool.shape.parts())
        for world in setup.worlds
    )


def check_bounds(expected: Estimate, setup: Setup) -> None:
    """Ask about a run that takes absurdly long or more memory than there is.

    Raises:
        InputError: it does, and the set-up does not accept what is unusual.
    """
    if setup.accept_unusual:
        return
    if problems := list(_problems(expected, setup)):
        raise InputError(f"this run would take {expected}: {'; '.join(problems)}. {ACCEPTING}")


def check_room(expected: Estimate, setup: Setup, folder: Path) -> None:
    """Ask about a run whose results have no room on the disk.

    Raises:
        InputError: they have none, and the set-up does not accept what is unusual; the folder has gone.
    """
    try:
        free = shutil.disk_usage(folder).free
    except OSError as error:
        raise InputError(
            f"output folder {folder}: it was there, and is no longer ({error.strerror or error}); run it again, or "
            "give another folder"
        ) from None
    if expected.disk > free and not setup.accept_unusual:
        raise InputError(
            f"output folder {folder}: {free / 1e6:,.0f} MB are free, but this run would take {expected}; give a folder "
            f"on another disk, or fewer frames than {expected.frame_count:,}. {ACCEPTING}"
        )


def _problems(expected: Estimate, setup: Setup) -> Iterator[str]:
    if expected.step_count is not None and expected.step_count > LARGEST_STEP_COUNT:
        yield (
            f"more than {LARGEST_STEP_COUNT:.0e} steps; the run lasts {setup.duration:.4g} s, so check the speeds of "
            "the tools, duration, time_step and target_step"
        )
    elif expected.seconds is not None and expected.seconds > LONGEST_TIME:
        yield (
            f"more than {LONGEST_TIME / 3600.0:.0f} h; fewer frames than {expected.frame_count:,}, a coarser mesh, "
            "faster tools or mass scaling (target_step) make it shorter"
        )
    if (free := available_memory()) is not None and expected.memory > free:
        yield (
            f"{free / 1e6:,.0f} MB of memory are free; a coarser mesh (mesh_size) or fewer frames than "
            f"{expected.frame_count:,} take less"
        )
