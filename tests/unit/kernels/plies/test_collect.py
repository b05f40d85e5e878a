"""What groups of threads find, and one thread sums up, against NumPy over all blocks at once."""

import numpy as np
import pytest
import warp as wp

from weavesim.engine.plies.pass_launches import group_count
from weavesim.kernels.pass_entries import PassEntry
from weavesim.kernels.plies.collect import (
    GROUP,
    count_strays_kernel,
    list_strays_kernel,
    sum_up_kernel,
    survey_groups_kernel,
    survey_struct,
)
from weavesim.kernels.plies.search import search_struct, watch_struct
from weavesim.kernels.stepping.step import group_maximum_kernel

REAL, SKIN = wp.float64, 0.5


def launch(kernel, dim, *arguments) -> None:
    wp.launch(kernel, dim=dim, inputs=list(arguments), device="cpu")


def summed_up(block_count: int, lane_count: int, *, slot: int = -1, share: float = 0.1, seed: int = 0):
    """The watch after the kernels, its inputs, and whether both sheets are awake."""
    rng = np.random.default_rng(seed)
    node_count = block_count * lane_count
    given = {
        "travel": 0.1 * rng.random(block_count),
        "late": (rng.random(block_count) < 0.001).astype(np.int32),
        "deepest": rng.normal(size=block_count) - 3.0,
        "found": (rng.random(node_count) < share).astype(np.int32),
    }
    way = (rng.random(block_count) < 0.9) * 1.0
    watch, survey, search = watch_struct(REAL)(), survey_struct(REAL)(), search_struct(REAL)()
    for name, values in given.items():
        setattr(watch, name, wp.array(values, device="cpu"))
    watch.entry = wp.array(np.full(len(PassEntry), -9.0), dtype=wp.float64, device="cpu")
    watch.stray = wp.array(np.full(node_count, -1), dtype=wp.int32, device="cpu")
    search.skin, search.slot = SKIN, slot
    blocks, nodes = group_count(block_count), group_count(node_count)
    survey.travel, survey.deepest = (wp.zeros(blocks, dtype=REAL, device="cpu") for _ in range(2))
    survey.late, survey.watched = (wp.zeros(blocks, dtype=wp.int32, device="cpu") for _ in range(2))
    survey.stray = wp.zeros(nodes, dtype=wp.int32, device="cpu")
    awake = [wp.zeros(1, dtype=wp.int32, device="cpu") for _ in range(2)]
    launch(survey_groups_kernel(REAL), blocks, watch, wp.array(way, device="cpu"), survey)
    launch(count_strays_kernel(REAL), nodes, watch, survey)
    launch(sum_up_kernel(REAL), 1, search, watch, survey, *awake)
    launch(list_strays_kernel(REAL), nodes, watch, survey)
    return watch, given | {"way": way}, [int(each.numpy()[0]) for each in awake]


@pytest.mark.parametrize(("block_count", "lane_count"), [(3, 16), (256, 1), (1000, 1), (300, 16)])
def test_groups_find_what_a_look_through_all_finds(block_count, lane_count):
    watch, given, awake = summed_up(block_count, lane_count)
    entry = watch.entry.numpy()
    strays = np.flatnonzero(given["found"])
    assert entry[PassEntry.stray_count] == len(strays) > 0 and entry[PassEntry.rebuild] == 1.0
    np.testing.assert_array_equal(watch.stray.numpy()[: len(strays)], strays)
    assert (watch.stray.numpy()[len(strays) :] == -1).all()
    assert entry[PassEntry.late] == given["late"].max() and entry[PassEntry.deepest] == given["deepest"].max()
    watched = (given["way"] == 0.0).any()
    assert awake == [watched, watched] and entry[PassEntry.watched] == watched


def test_lists_are_made_anew_for_strays_and_for_long_ways_only():
    watch, given, _ = summed_up(700, 1, share=0.0)
    assert watch.entry.numpy()[PassEntry.rebuild] == 0.0 and watch.entry.numpy()[PassEntry.stray_count] == 0.0
    assert given["travel"].max() < 0.5 * SKIN


def test_a_sheet_wakes_where_a_block_is_watched():
    _, given, awake = summed_up(700, 1, slot=0)
    assert awake == [1, 1] and (given["way"] == 0.0).any()


def test_the_largest_speed_of_every_group():
    speeds = np.random.default_rng(2).random(600)
    largest = wp.zeros(group_count(600), dtype=REAL, device="cpu")
    launch(group_maximum_kernel(REAL, GROUP), 3, wp.array(speeds, device="cpu"), largest)
    np.testing.assert_array_equal(largest.numpy(), [speeds[:256].max(), speeds[256:512].max(), speeds[512:].max()])
