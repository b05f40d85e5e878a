"""Kernels compiled ahead are those that runs launch."""

import os
import subprocess
import sys

import numpy as np
import pytest

from weavesim.blank import Blank
from weavesim.compilation import KernelSet, compile_kernels
from weavesim.device import Precision
from weavesim.errors import InputError
from weavesim.fabric import glass_polypropylene
from weavesim.motion import Stroke
from weavesim.shapes import Plane
from weavesim.simulation import Simulation
from weavesim.support import Drive, Support
from weavesim.tool import Tool


def test_a_run_launches_nothing_else(precision):
    blank = Blank.rectangle((0.0, 0.0), (0.02, 0.02), 0.005)
    held = Support("edge", np.arange(5), drives=(Drive(Stroke((0.0, 1.0), (0.0, 0.01)), (1.0, 0.0, 0.0)),))
    simulation = Simulation(
        name="all", blank=blank, fabric=glass_polypropylene(), duration=1.0, supports=(held,), threads=2,
        tools=(Tool("plane", Plane(origin=(0.0, 0.0, -0.01))),), precision=precision,
    )  # fmt: skip
    ahead = KernelSet(Precision(precision)).kernels()
    launched = [*simulation.stepper.kernels, simulation.ledger._kernel, simulation.ledger._distance_kernel]
    assert len(launched) == 11
    assert all(any(kernel is other for other in ahead) for kernel in launched)


def test_what_is_loaded_is_not_compiled_again_by_its_launch(tmp_path):
    code = """
import warp as wp
from weavesim.device import initialise, load_kernel
from weavesim.kernels.barrier import barrier
initialise()
load_kernel(barrier, wp.get_device("cpu"))
wp.launch(barrier, dim=1, inputs=[wp.zeros(1, dtype=wp.int32, device="cpu"), 1], device="cpu")
"""
    environment = {**os.environ, "WARP_CACHE_PATH": str(tmp_path), "PYTHONPATH": os.pathsep.join(sys.path)}
    subprocess.run([sys.executable, "-c", code], env=environment, check=True)
    assert len(list(tmp_path.glob("*/*/wp_*barrier*"))) == 1


def test_unknown_unit_cell_is_refused_with_those_there_are():
    with pytest.raises(InputError, match="plain-weave"):
        compile_kernels(KernelSet(unit_cell="felt"), process_count=1)
