"""Every kernel that a run launches on a GPU is among those whose registers are recorded."""

import pytest

from scripts.benchmarks.cuda.resources import short_name
from scripts.benchmarks.cuda.users import free_patch, kernels_by_user, kernels_of_batch, kernels_of_scene
from weavesim.app.command_line import SCENES, default_setups
from weavesim.device import initialise
from weavesim.fabric.presets import UNIT_CELLS

OF_CPU = {"flush_subnormals", "restore_subnormals", "barrier", "count_rounds"}
OF_GPU = {"check_clock", "partial_maximum", "partial_sums"}


@pytest.fixture(scope="module")
def names_by_user():
    """Names of the kernels in single precision by what asks for them."""
    initialise()
    found = {}
    for kernel, users in kernels_by_user("float32").items():
        for user in users:
            found.setdefault(user, set()).add(short_name(kernel))
    return found


def test_scenes_cells_batches_tools_and_self_contact_are_there(names_by_user):
    assert set(SCENES) | {f"cell: {name}" for name in UNIT_CELLS} <= set(names_by_user)
    assert {"free patch", "batch: double-dome", "batch: grippers", "self-contact"} <= set(names_by_user)
    assert {f"tools: {kind}" for kind in ("mesh", "carried", "carried mesh", "carried in stages")} <= set(names_by_user)
    for name in UNIT_CELLS:
        assert names_by_user[f"cell: {name}"] == {"element_forces", "element_frequencies", "element_ledger"}


def test_they_are_those_of_a_gpu_though_there_is_none(names_by_user):
    every = set().union(*names_by_user.values())
    assert every >= OF_GPU and not every & OF_CPU
    many = names_by_user["batch: double-dome"]
    assert many >= {"world_forces", "world_nodes", "world_samples", "world_tile_maxima", "partial_sums"}
    assert "world_maxima" not in many
    assert {"world_grips", "world_nodes"} <= names_by_user["batch: grippers"]


def test_a_run_is_asked_about_on_a_gpu_whatever_its_set_up_says():
    (setup,) = default_setups(["double-dome"], precision="float64")
    on_host = setup.model_copy(update={"solver": setup.solver.model_copy(update={"lane_count": 16, "threads": 2})})
    assert kernels_of_scene(on_host) == kernels_of_scene(setup)
    assert kernels_of_batch(on_host) == kernels_of_batch(setup)
    assert {short_name(kernel) for kernel in kernels_of_scene(free_patch("float32"))} >= {
        "element_forces",
        "node_motion",
    }
