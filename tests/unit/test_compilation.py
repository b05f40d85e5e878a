"""Kernels compiled ahead are those that runs launch."""

import os
import subprocess
import sys
from importlib import import_module

import pytest

from weavesim.command_line import SCENES
from weavesim.compilation import SCENE_TRAITS, KernelSet, compile_kernels
from weavesim.device import Precision
from weavesim.errors import InputError
from weavesim.simulation import Simulation


def made(name: str, precision: str) -> list[Simulation]:
    """The simulations of a scene's default set-up on its coarsest sensible mesh, on two threads."""
    module = import_module(f"weavesim.scenes.{SCENES[name].module}")
    options = {"precision": precision, "threads": 2}
    if name == "double-dome":
        return [module.double_dome(module.DoubleDomeParameters(mesh_size=0.02, **options))]
    if name == "hemisphere":
        return [module.hemisphere(module.HemisphereParameters(mesh_size=0.02, **options), "low-bending")]
    make = getattr(module, name.replace("-", "_"))
    return [make(getattr(module, SCENES[name].parameters)(**options))]


@pytest.mark.parametrize("name", SCENES)
def test_a_scene_launches_nothing_else(name, precision):
    ahead = KernelSet(Precision(precision), scene=name).kernels()
    for simulation in made(name, precision):
        launched = [*simulation.stepper.kernels, simulation.ledger._kernel, simulation.ledger._distance_kernel]
        assert len(launched) >= 9
        assert all(any(kernel is other for other in ahead) for kernel in launched)


def test_all_scenes_are_compiled_ahead():
    assert set(SCENE_TRAITS) == set(SCENES)
    everything = KernelSet().kernels()
    assert all(kernel in everything for name in SCENES for kernel in KernelSet(scene=name).kernels())


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


def test_unknown_unit_cell_or_scene_is_refused_with_those_there_are():
    with pytest.raises(InputError, match="plain-weave"):
        compile_kernels(KernelSet(unit_cell="felt"), process_count=1)
    with pytest.raises(InputError, match="double-dome"):
        compile_kernels(KernelSet(scene="triple-dome"), process_count=1)
