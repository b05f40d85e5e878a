"""Kernels of a step have no more machine instructions on a CPU than they had; speed itself is never asserted.

What they had is in ``tests/data/instructions.json``: python scripts/benchmark.py instructions --record. A change of
more than three per cent is seen there, with its reason in the commit.
"""

import platform
import sys

import pytest
import warp as wp

from scripts.benchmarks.compilation.instructions import (
    compiled_for,
    content,
    instruction_count,
    read_counts,
    step_kernels,
)
from weavesim.device import initialise

pytestmark = pytest.mark.skipif(
    sys.platform != "linux" or platform.machine() != "x86_64", reason="objects for Linux on an x86 processor are read"
)


@pytest.fixture(scope="module")
def kernels():
    initialise()
    return step_kernels("float32")


def counted(kernels, precision):
    """Instructions now and in the record, by kernel."""
    _, counts = read_counts()
    now = {name: instruction_count(kernel) for name, kernel in kernels.items()}
    return now, {name: pytest.approx(counts[precision][name].instructions, rel=0.03) for name in kernels}


def test_no_kernel_that_has_changed_has_more_instructions_than_it_had(kernels):
    """A kernel with the content that was counted has the instructions that were counted: it is not compiled again."""
    warp, counts = read_counts()
    assert set(counts["float32"]) == set(kernels)
    changed = {
        name: kernel
        for name, kernel in kernels.items()
        if warp != wp.config.version or content(kernel) != counts["float32"][name].content
    }
    now, recorded = counted(changed, "float32")
    assert now == recorded


def test_the_record_is_what_the_compiler_gives(kernels):
    now, recorded = counted({"nodes": kernels["nodes"]}, "float32")
    assert now == recorded


@pytest.mark.verification
@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_every_kernel_has_no_more_instructions_than_it_had(precision):
    initialise()
    now, recorded = counted(step_kernels(precision), precision)
    assert now == recorded


def test_a_run_is_compiled_for_its_own_processor_afterwards(kernels):
    options = kernels["nodes"].module.options
    before = dict(options)
    with compiled_for(kernels["nodes"], "x86-64-v4"):
        flags = options["cpu_compiler_flags"]
        assert "-march=native" not in flags and "-target-cpu x86-64-v4" in flags
    assert options == before
