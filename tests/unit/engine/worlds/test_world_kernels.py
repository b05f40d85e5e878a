"""The kernels of many worlds follow from what determines those of one."""

import pickle

from tests.unit.engine.worlds.test_world_stepper import world
from tests.unit.run.batch.test_batch import variant
from weavesim.engine.compilation import missing
from weavesim.engine.worlds.world_kernels import WorldKernelSet


def names(setup):
    return {kernel.key.rpartition("__")[2] for kernel in WorldKernelSet.of(setup, "cpu").kernels()}


def test_only_what_there_is_has_a_kernel():
    few, many = names(variant(lane_count=1)), names(world())
    assert many - few == {"world_drives", "world_grips", "world_samples"} and few < many
    assert {"world_forces", "world_nodes", "world_frequencies", "world_tools", "world_maxima", "check_worlds"} <= few
    assert "world_tile_maxima" not in many  # of GPUs


def test_a_set_can_be_sent_to_another_process():
    own = WorldKernelSet.of(world(), "cpu")
    other = pickle.loads(pickle.dumps(own))
    assert other.kernels() == own.kernels()
    assert set(missing(other)) <= set(range(len(own.kernels())))


def test_numbers_need_no_other_kernels():
    assert WorldKernelSet.of(world(0), "cpu").kernels() == WorldKernelSet.of(world(2), "cpu").kernels()
