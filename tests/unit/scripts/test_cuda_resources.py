"""Kernels build for CUDA devices, and need no more registers than they did: no GPU is needed for that."""

import pytest

from scripts.benchmarks.cuda_resources import Resources, dump_program, kernels_on_gpu, resources, short_name
from weavesim.app.command_line import SCENES, default_setups

# Measured on 26 November 2026 with CUDA 13.4 (python scripts/benchmark.py cuda): the most that any scene needs.
LIMITS = {
    ("element_forces", "float32"): Resources(128, 0),
    ("element_forces", "float64"): Resources(255, 16),
    ("node_motion", "float32"): Resources(147, 0),
    ("node_motion", "float64"): Resources(246, 0),
    ("element_frequencies", "float32"): Resources(121, 0),
    ("element_frequencies", "float64"): Resources(254, 0),
}
SMALL = Resources(80, 0)

pytestmark = pytest.mark.skipif(dump_program() is None, reason="nvidia-cuda-cuobjdump is not installed")


def beyond_limits(setup, precision, architecture, names=None):
    """Kernels that need more than they did, with what they need."""
    found = {}
    for kernel in kernels_on_gpu(setup, precision):
        name = short_name(kernel)
        if names is None or name in names:
            needs, limit = resources(kernel, architecture), LIMITS.get((name, precision), SMALL)
            if needs.registers > limit.registers or needs.stack > limit.stack:
                found[name] = needs
    return found


def test_elements_and_nodes_of_the_double_dome():
    (setup,) = default_setups(["double-dome"], precision="float32")
    assert beyond_limits(setup, "float32", 90, ("element_forces", "node_motion")) == {}


@pytest.mark.verification
@pytest.mark.parametrize("architecture", [80, 90])
@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("scene", SCENES)
def test_every_kernel_of_every_scene(scene, precision, architecture):
    for setup in default_setups([scene], precision=precision):
        assert beyond_limits(setup, precision, architecture) == {}
