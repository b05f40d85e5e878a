"""Many runs in one process, and many steps in one run: memory, file descriptors and threads stay as they are."""

from __future__ import annotations

import gc
import os
import shutil
import threading
import time
from pathlib import Path

import numpy as np

from tests.support.kills import WRITERS, tiny_setup
from weavesim.app.run_into_folder import run_into_folder
from weavesim.engine.state import State
from weavesim.engine.stepper import Stepper
from weavesim.output import ResultFolder
from weavesim.run.simulation import Simulation

# Runs before the first measurement: libraries keep what they need once.
WARM_UP = 10
# Memory that a run may keep on average [bytes], and that a million steps may.
LARGEST_GROWTH, LARGEST_GROWTH_OF_STEPS = 50_000, 20_000_000


def resident() -> int:
    """Memory of this process now [bytes]; only Linux tells."""
    gc.collect()
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def descriptors() -> int:
    """Open file descriptors of this process."""
    return len(os.listdir("/proc/self/fd"))


def runs(folder: Path, count: int, seed: int) -> bool:
    """``count`` runs with their results, one after the other."""
    setup = tiny_setup()
    memory, files, threads = 0, 0, 0
    for number in range(count + WARM_UP):
        if number == WARM_UP:
            memory, files, threads = resident(), descriptors(), threading.active_count()
        shutil.rmtree(folder, ignore_errors=True)
        run_into_folder(setup, ResultFolder(folder, writers=WRITERS), options={})
        if number % 10 == 9:
            print(f"{number + 1} runs: {resident() / 1e6:.1f} MB, {descriptors()} descriptors", flush=True)
    growth = (resident() - memory) / count
    print(f"{growth:.0f} bytes a run, {descriptors() - files} descriptors more", flush=True)
    return growth < LARGEST_GROWTH and descriptors() == files and threading.active_count() == threads


def steps(folder: Path, count: int, seed: int) -> bool:
    """``count`` steps of one run, without its frames."""
    simulation = Simulation(tiny_setup())
    stepper, state = simulation.stepper, simulation.state
    assert isinstance(stepper, Stepper) and isinstance(state, State)
    block = max(1, count // 20 // 20)
    stepper.advance(block)
    memory, files, started = resident(), descriptors(), time.monotonic()
    while state.step_count < count:
        told = state.step_count + max(1, count // 20)
        while state.step_count < min(told, count):
            stepper.advance(block)
        finite = all(np.isfinite(sheet.motion.numpy()).all() for sheet in state.sheets)
        print(f"{state.step_count} steps, {state.time:.4g} s, {resident() / 1e6:.1f} MB, "
              f"{time.monotonic() - started:.0f} s", flush=True)  # fmt: skip
        if not finite:
            print("FAILED: the state is not finite", flush=True)
            return False
    growth = resident() - memory
    print(f"{growth / 1e6:.2f} MB more, {descriptors() - files} descriptors more", flush=True)
    return growth < LARGEST_GROWTH_OF_STEPS and descriptors() == files
