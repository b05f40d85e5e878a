"""The picture of the architecture shows the rooms that there are, and no import that points up."""

from functools import cache

import pytest
from PIL import Image

from scripts.architecture import A_RESULT, A_STEP, IN_EVERY_STEP, KERNEL_ROWS, ROOMS, House, draw
from tests.support.imports import Sources
from tests.support.paths import ROOT
from tests.support.rooms import ORDER

SOURCES = Sources(ROOT)


@cache
def house() -> House:
    """That of the checkout: it reads all of it, which takes seconds."""
    return House.of(SOURCES)


def upward(arrows, order) -> set:
    """Arrows of which the importer does not stand above what it imports."""
    return {pair for pair in arrows if order.index(pair[0]) <= order.index(pair[1])}


def test_the_rooms_are_those_of_the_tree():
    folders = {file.relative_to(ROOT).parts[:-1] for file in SOURCES.file_of.values()}
    names = {parts[1] if parts[0] == "weavesim" and len(parts) > 1 else parts[0] for parts in folders}
    assert set(ROOMS) == names - {"weavesim"} | {"base"}
    assert tuple(house().modules) == tuple(ROOMS) == ORDER
    inside = {parts[1] for parts in folders if parts[0] == "kernels" and len(parts) > 1}
    assert {name for row in KERNEL_ROWS for name in row} == inside | {""}


def test_no_arrow_points_up():
    assert upward(house().arrows, ORDER) == set()
    rows_upwards = [name for row in reversed(KERNEL_ROWS) for name in row]
    assert upward(house().kernel_arrows, rows_upwards) == set()
    beside = {pair for pair in house().kernel_arrows for row in KERNEL_ROWS if set(pair) <= set(row)}
    assert beside == set()


def test_an_arrow_that_points_up_is_found():
    assert upward({("kernels", "run"): 1, ("run", "kernels"): 1}, ORDER) == {("kernels", "run")}


@pytest.mark.parametrize("stop", [*A_STEP, *A_RESULT], ids=lambda stop: stop.name)
def test_a_walk_names_what_exists(stop):
    name = f"weavesim.{stop.name}"
    if name not in SOURCES.file_of:
        module, _, own = name.rpartition(".")
        assert f"class {own}" in SOURCES.file_of[module].read_text()
    assert stop.room == stop.name.split(".")[0]


def test_a_step_is_repeated_between_stops_of_it():
    assert set(IN_EVERY_STEP) <= {stop.name for stop in A_STEP}


def test_the_picture_is_written_and_the_kept_one_shows_the_same_rooms(tmp_path):
    draw(house(), tmp_path / "rooms.png")
    for path in (tmp_path / "rooms.png", ROOT / "docs/images/architecture.png"):
        with Image.open(path) as picture:
            assert picture.info["Description"].split() == list(ORDER)
            assert picture.width > 1200
