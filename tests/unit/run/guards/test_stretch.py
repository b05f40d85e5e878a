"""Guard of the stretch of the yarns: at any time, wherever the frames are."""

import math

import numpy as np
import pytest

from tests.support.judged import said
from tests.support.runs import small_run
from weavesim.fabric.cell import LinearMembrane
from weavesim.process.strokes import Stroke
from weavesim.process.supports import Drive, Support
from weavesim.run.guards import Level
from weavesim.run.watch.extremes import Extreme
from weavesim.sheet.blank import Blank


@pytest.mark.parametrize(
    ("name", "value", "level"),
    [
        ("min_stretch", 0.89, Level.WARNING),
        ("max_stretch", 1.11, Level.WARNING),
        ("max_stretch", math.nan, Level.DO_NOT_USE),
        ("max_stretch", 1.3, Level.DO_NOT_USE),
        ("min_stretch", 0.7, Level.DO_NOT_USE),
    ],
)
def test_each_side_is_doubted(name, value, level):
    (doubt,) = said("yarn_stretch", extremes={name: Extreme(value, 0.5, (0.1, 0.2))})
    assert doubt.level == level and "yarn stretches ranged from" in doubt.text
    assert said("yarn_stretch", extremes={"min_stretch": Extreme(0.91), "max_stretch": Extreme(1.09)}) == []


def test_rubber_bears_more_than_yarns(fabric):
    """A membrane of 3 MPa."""
    soft = fabric(thickness=1.5e-3, unit_cell=LinearMembrane(warp_stiffness=4.5e3, weft_stiffness=4.5e3))

    def doubts(stretch):
        return said("yarn_stretch", extremes={"max_stretch": Extreme(stretch, 0.5, (0.1, 0.2))}, fabric=soft)

    assert doubts(1.4) == []
    assert [doubt.level for doubt in (*doubts(1.6), *doubts(2.1))] == [Level.WARNING, Level.DO_NOT_USE]
    assert "rubber is not linear there" in doubts(1.6)[0].message


def pulled_and_back(strain: float, frame_count: int, axis: int = 0):
    """A square whose one edge is pulled away and comes back before the end."""
    blank = Blank.rectangle((0.0, 0.0), (0.02, 0.02), 0.005)
    place = blank.node_position[:, axis]
    travel = Stroke((0.0, 1e-3, 2e-3, 3e-3), (0.0, strain * 0.02, 0.0, 0.0))
    supports = (
        Support("held", np.flatnonzero(place < 1e-9)),
        Support("pulled", np.flatnonzero(place > 0.02 - 1e-9), (Drive(travel, np.eye(3)[axis]),)),
    )
    simulation = small_run(blank=blank, supports=supports, duration=3e-3, frame_count=frame_count)
    simulation.run()
    return simulation


@pytest.mark.parametrize(("strain", "axis"), [(0.26, 0), (0.15, 1), (-0.15, 0)])
def test_a_pull_and_back_is_seen_with_any_number_of_frames(strain, axis):
    runs = [pulled_and_back(strain, frame_count, axis) for frame_count in (1, 30)]
    said = [[doubt for doubt in run.doubts() if doubt.guard == "yarn_stretch"] for run in runs]
    assert said[0] == said[1]
    (doubt,) = said[0]
    assert doubt.level == (Level.DO_NOT_USE if abs(strain) > 0.25 else Level.WARNING)
    assert doubt.value > abs(strain) * 0.9 and doubt.time > 0.5e-3
    assert runs[0].summary()["doubts"] == runs[1].summary()["doubts"]


def test_a_small_pull_is_not_doubted():
    assert [doubt for doubt in pulled_and_back(0.01, 1).doubts() if doubt.guard == "yarn_stretch"] == []
