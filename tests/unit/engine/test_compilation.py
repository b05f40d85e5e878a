"""Kernels compiled ahead are those that runs launch."""

import logging
import os
import pickle
import signal
import subprocess
import sys
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest
import warp as wp

from tests.support.processes import COARSE, ENOUGH, environment, start, wait_for
from tests.support.runs import one_sheet_run
from weavesim.app.command_line import SCENES, default_setups
from weavesim.device import Precision
from weavesim.engine import compilation
from weavesim.engine.compilation import (
    KernelSet,
    MeshKernelSet,
    compile_kernels,
    compile_missing,
    missing,
    side_by_side,
)
from weavesim.engine.model import Model
from weavesim.engine.setup import Setup
from weavesim.engine.state import State
from weavesim.engine.stepper import Stepper
from weavesim.fabric.presets import assumed_fabric, glass_polypropylene
from weavesim.fabric.shear import LinearShear
from weavesim.kernel_cache import LEFTOVER
from weavesim.kernels.stepping.supports import support_motion_kernel
from weavesim.process.dynamics import Dynamics
from weavesim.run.ledger import Ledger
from weavesim.run.simulation import Simulation
from weavesim.run.staging.rehearsal import phases_of
from weavesim.sheet.blank import Blank
from weavesim.tools.mesh_tool import MeshShape
from weavesim.tools.shapes import Plane, Sphere
from weavesim.tools.tool import Tool

# Kernels that every run takes and that compile in a second each.
SMALL = KernelSet(
    glass_polypropylene().unit_cell, (), (), Precision.SINGLE, "cpu", 1, tools=False, driven=False, threaded=False
)


def made(name: str, precision: str) -> list[Setup]:
    """A scene's default set-ups on its coarsest sensible mesh, on two threads."""
    scene = SCENES[name].load()
    coarse = {"double-dome": {"mesh_size": 0.0075}, "hemisphere": {"mesh_size": 0.02, "case": "low-bending"}}
    parameters = scene.parameters(precision=precision, threads=2, **coarse.get(name, {}))
    return list(scene.setups(parameters).values())


def launched_by(stepper: Stepper, ledger: Ledger) -> list[wp.Kernel]:
    """All that a run launches once its tools are sampled."""
    own = []
    for each in ledger.sheets:
        gaps = (each._contact_gaps, each._judged_gaps, each._tool_forces, each._surface_fields)
        own += [each._kernel, *(command.kernel for one in gaps for command in one.launches)]
    return [*stepper.kernels, *own]


def launched_without_loading(setup: Setup, monkeypatch) -> list[wp.Kernel]:
    """The same, of a run that is not prepared: nothing but small kernels of its tools is compiled."""
    model = Model(phases_of(setup)[0].setup)
    stepper = Stepper(model, State.initial(model), thread_counts=(setup.solver.threads,))
    with monkeypatch.context() as patch:
        patch.setattr(wp, "launch", lambda kernel, *_, **__: SimpleNamespace(kernel=kernel))
        return launched_by(stepper, Ledger(stepper))


@pytest.mark.parametrize("name", SCENES)
def test_a_scene_launches_nothing_else(name, precision, monkeypatch):
    ahead = KernelSet.of_setups(default_setups([name], precision=precision)).kernels()
    for setup in made(name, precision):
        launched = launched_without_loading(setup, monkeypatch)
        assert len(launched) >= 9
        assert all(any(kernel is other for other in ahead) for kernel in launched)


def test_all_scenes_are_compiled_ahead():
    everything = KernelSet.of_setups(default_setups(SCENES, precision=Precision.SINGLE)).kernels()
    for name in SCENES:
        of_one = KernelSet.of_setups(default_setups([name], precision=Precision.SINGLE)).kernels()
        assert all(kernel in everything for kernel in of_one)


def test_another_unit_cell_takes_other_kernels_of_its_law_only():
    setups = default_setups(["double-dome"])
    own, other = KernelSet.of_setups(setups), KernelSet.of_setups(setups, assumed_fabric("twill").unit_cell)
    assert (own.sheets, own.nodes) == (other.sheets, other.nodes)
    changed = [a.key for a, b in zip(own.kernels(), other.kernels(), strict=True) if a is not b]
    assert len(changed) == 3 and all(key.startswith("element_") for key in changed)


def small_run(**given) -> Simulation:
    blank = Blank.rectangle((-0.01, -0.01), (0.01, 0.01), 0.005)
    settings = {"fabric": glass_polypropylene(), "threads": 1, "lane_count": 1}
    return one_sheet_run(name="small", blank=blank, duration=1e-3, **(settings | given))


RUNS = {
    "no tools": lambda: {},
    "other laws": lambda: {
        "fabric": assumed_fabric("twill").model_copy(update={"shear": LinearShear(modulus=1e6)}),
        "dynamics": Dynamics(contact_thickness="current"), "threads": 2,
        "tools": [Tool("plane", Plane(origin=(0.0, 0.0, -0.01)))],
    },
}  # fmt: skip


@pytest.mark.parametrize("name", RUNS)
def test_a_run_takes_all_of_its_set_and_nothing_else(name):
    simulation = small_run(**RUNS[name]())
    (kernel_set,) = simulation.stepper.kernel_sets
    launched = launched_by(simulation.stepper, simulation.ledger)
    assert {id(kernel) for kernel in launched} == {id(kernel) for kernel in kernel_set.kernels()}
    assert pickle.loads(pickle.dumps(kernel_set)) == kernel_set


def test_what_is_loaded_is_not_missing():
    (kernel_set,) = small_run().stepper.kernel_sets
    compile_kernels(kernel_set, process_count=1)
    assert missing(kernel_set) == []


def test_nothing_is_said_or_compiled_if_all_is_cached(monkeypatch, caplog):
    caplog.set_level(logging.INFO, "weavesim")
    compile_kernels(SMALL, process_count=1)
    monkeypatch.setattr(compilation, "ProcessPoolExecutor", None)
    said = []
    with side_by_side(said.append):
        compile_missing(SMALL)
    assert said == [] and caplog.messages == []


def test_a_program_is_informed_but_starts_no_processes(monkeypatch, caplog, tmp_path):
    monkeypatch.setattr(wp.config, "kernel_cache_dir", str(tmp_path))
    monkeypatch.setattr(compilation, "ProcessPoolExecutor", None)
    caplog.set_level(logging.INFO, "weavesim")
    assert missing(SMALL) == list(range(len(SMALL.kernels())))
    compile_missing(SMALL)
    assert caplog.messages == [f"{len(SMALL.kernels())} kernels are not in the cache and are compiled first"]
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_the_command_line_compiles_side_by_side_what_is_missing(monkeypatch, tmp_path):
    monkeypatch.setattr(wp.config, "kernel_cache_dir", str(tmp_path / wp.config.version))
    monkeypatch.setattr(compilation, "available_threads", lambda: 2)
    said = []
    with side_by_side(said.append):
        compile_missing(SMALL)
        compile_missing(SMALL)
    assert said == [len(SMALL.kernels())] and missing(SMALL) == []
    driven = replace(SMALL, driven=True)
    assert [driven.kernels()[index] for index in missing(driven)] == [support_motion_kernel(wp.float32)]


def test_runs_check_the_cache_before_they_load_kernels(monkeypatch):
    asked = []
    monkeypatch.setattr("weavesim.engine.stepper.compile_missing", asked.append)
    monkeypatch.setattr("weavesim.engine.model.compile_missing", asked.append)
    ball = Sphere(radius=0.01).display_mesh()
    mesh = MeshShape.from_triangles(ball.vertices, ball.faces, spacing=2e-3, origin=(0.0, 0.0, -0.012))
    simulation = small_run(tools=[Tool("ball", mesh)])
    assert asked == [MeshKernelSet("cpu"), *simulation.stepper.kernel_sets]


@pytest.mark.slow
def test_what_is_loaded_is_not_compiled_again_by_its_launch(tmp_path):
    code = """
import warp as wp
wp.config.use_precompiled_headers = False  # of one small kernel they take longer than it
from weavesim.device import initialise, is_compiled, load_kernel
from weavesim.kernels.machine import barrier
initialise()
assert not is_compiled(barrier, wp.get_device("cpu"))
load_kernel(barrier, wp.get_device("cpu"))
assert is_compiled(barrier, wp.get_device("cpu"))
wp.launch(barrier, dim=1, inputs=[wp.zeros(1, dtype=wp.int32, device="cpu"), 1], device="cpu")
"""
    environment = {**os.environ, "WARP_CACHE_PATH": str(tmp_path), "PYTHONPATH": os.pathsep.join(sys.path)}
    subprocess.run([sys.executable, "-c", code], env=environment, check=True)
    assert len(list(tmp_path.glob("*/*/wp_*barrier*"))) == 1


def workers_of(pid: int) -> list[int]:
    """Processes that a process has started and that are alive."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):
            fields = stat.read_text().rpartition(")")[2].split()
            if int(fields[1]) == pid and fields[0] != "Z":
                found.append(int(stat.parent.name))
    return found


def is_alive(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def forces(cache: Path) -> list[Path]:
    """Folders of the forces of elements in a cache."""
    return [path for path in cache.rglob("wp_element_force*") if path.is_dir()]


def is_unfinished(folder: Path) -> bool:
    """Whether a compiler is at work in a folder, or has ended in the middle."""
    return LEFTOVER.search(folder.name) is not None


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="needs /proc to find processes")
@pytest.mark.parametrize(
    "number",
    [signal.SIGINT, pytest.param(signal.SIGKILL, marks=pytest.mark.slow)],
    ids=["SIGINT", "SIGKILL"],
)
def test_compiler_processes_end_with_the_one_that_started_them(tmp_path, number):
    """Only that one gets the signal, as from another program; and in the middle of a kernel.

    One handler takes SIGINT, SIGTERM and SIGHUP (``tests/unit/run/test_interruption.py``), and to the compilers, which
    get none of them, it is one way to end.
    """
    cache = tmp_path / "cache"
    process = start(*COARSE, "--out", tmp_path / "out", env=environment(WARP_CACHE_PATH=str(cache)))
    try:
        # compilers, and the one that tracks their resources; the kernel that takes longest is the first
        wait_for(lambda: len(workers_of(process.pid)) >= 3 and any(map(is_unfinished, forces(cache))))
        workers = workers_of(process.pid)
        process.send_signal(number)
        out, err = process.communicate(timeout=ENOUGH)
        wait_for(lambda: not any(map(is_alive, workers)))
    finally:
        process.kill()
    assert all(map(is_unfinished, forces(cache)))
    assert "Traceback" not in err
    assert process.returncode == (-number if number == signal.SIGKILL else 128 + number)
    assert [path.name for path in (tmp_path / "out").iterdir()] == [".weavesim.lock"]


def test_what_processes_fail_to_compile_is_left_to_the_run(monkeypatch, caplog):
    caplog.set_level(logging.INFO, "weavesim")

    class Broken:
        def __init__(self, *arguments, **given):
            raise OSError("no more processes")

    monkeypatch.setattr(compilation, "ProcessPoolExecutor", Broken)
    compilation._compile(SMALL, [0], 2)
    assert "kernels could not be compiled side by side: OSError: no more processes" in caplog.messages
