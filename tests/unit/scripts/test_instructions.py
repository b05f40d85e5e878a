"""Kernels of a step have no more machine instructions on a CPU than they had; speed itself is never asserted."""

import platform
import sys

import pytest

from scripts.benchmarks.compilation.instructions import compiled_for, instruction_count, step_kernels

# In the default double dome in sixteen lanes, for x86 processors with AVX-512, by Warp 1.19 (python
# scripts/benchmark.py instructions). A change of more than three per cent says so here, with its reason in the commit.
INSTRUCTIONS = {
    ("float32", "forces"): 4956,
    ("float32", "nodes"): 1980,
    ("float32", "stable step"): 4342,
    ("float64", "forces"): 8885,
    ("float64", "nodes"): 2974,
    ("float64", "stable step"): 7239,
}

pytestmark = pytest.mark.skipif(
    sys.platform != "linux" or platform.machine() != "x86_64", reason="objects for Linux on an x86 processor are read"
)


@pytest.fixture(scope="module", params=["float32", "float64"])
def kernels(request):
    return request.param, step_kernels(request.param)


def test_a_step_has_no_more_instructions_than_it_had(kernels):
    precision, of = kernels
    found = {name: instruction_count(kernel) for name, kernel in of.items()}
    assert found == {name: pytest.approx(INSTRUCTIONS[precision, name], rel=0.03) for name in found}


def test_a_run_is_compiled_for_its_own_processor_afterwards(kernels):
    _, of = kernels
    options = of["nodes"].module.options
    before = dict(options)
    with compiled_for(of["nodes"], "x86-64-v4"):
        assert "-march=native" not in options["cpu_compiler_flags"]
        assert "-target-cpu x86-64-v4" in options["cpu_compiler_flags"]
    assert options == before and "-march=native" in options["cpu_compiler_flags"]
