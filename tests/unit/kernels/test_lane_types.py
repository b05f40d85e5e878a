"""Compiler options of the kernels of a step, by processor and precision."""

import pytest
import warp as wp

from weavesim.kernels.lane_types import step_options

# Threads of a block on a GPU.
ON_EVERY_PROCESSOR = {"block_dim": 64}


@pytest.mark.parametrize("machine", ["x86_64", "AMD64"])
def test_single_precision_does_without_gathers_on_x86(monkeypatch, machine):
    monkeypatch.setattr("platform.machine", lambda: machine)
    monkeypatch.setattr(wp.config, "cpu_compiler_flags", "-march=native")
    without_gathers = {"cpu_compiler_flags": "-march=native -target-feature +prefer-no-gather"}
    assert step_options(wp.float32) == ON_EVERY_PROCESSOR | without_gathers
    assert step_options(wp.float64) == ON_EVERY_PROCESSOR


@pytest.mark.parametrize(
    ("machine", "flags"), [("aarch64", "-march=native"), ("arm64", "-march=native"), ("x86_64", None)]
)
def test_other_processors_and_unset_flags_keep_the_options(monkeypatch, machine, flags):
    monkeypatch.setattr("platform.machine", lambda: machine)
    monkeypatch.setattr(wp.config, "cpu_compiler_flags", flags)
    assert step_options(wp.float32) == ON_EVERY_PROCESSOR
