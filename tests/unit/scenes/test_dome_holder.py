"""The blank holder of the double dome in segments, with spacers: what is made, and what is refused."""

import numpy as np
import pytest

from weavesim.errors import InputError
from weavesim.process.strokes import Fixed, ForceDriven
from weavesim.scenes.dome_holder import blank_holder_area
from weavesim.scenes.double_dome import DoubleDomeParameters, double_dome

COARSE = {"mesh_size": 0.03}


def holders(**given):
    return double_dome(DoubleDomeParameters(**COARSE, **given)).tools[2:]


@pytest.mark.parametrize(("part", "count"), [("quarter", 2), ("half", 4), ("full", 8)])
def test_segments_share_force_and_mass_by_their_areas(part, count):
    (whole,), parts = holders(part=part), holders(part=part, blank_holder_segments=8)
    assert [tool.name for tool in parts] == [f"blank_holder_{k + 1}" for k in range(count)]
    assert sum(tool.motion.forces[-1] for tool in parts) == pytest.approx(whole.motion.forces[-1])
    assert sum(tool.motion.mass for tool in parts) == pytest.approx(whole.motion.mass)
    # 20 kPa on each of their areas, which are those of the flange
    area = blank_holder_area(0.0012) * count / 8
    assert sum(tool.motion.forces[-1] for tool in parts) / 20e3 == pytest.approx(area, rel=1e-6)
    angles = [tuple(np.degrees(np.arctan2(p[1], p[0])) for p in _middles(tool)) for tool in parts]
    assert [a[0] for a in angles] == sorted(a[0] for a in angles) or part != "quarter"


def _middles(tool):
    vertices, _ = tool.display_triangles()
    return [vertices.mean(axis=0)]


def test_each_has_its_own_force_or_gap():
    first, second = holders(blank_holder_segments=8, blank_holder_loads="300, gap 0.0002")
    assert isinstance(first.motion, ForceDriven) and first.motion.forces[-1] == 300.0
    assert isinstance(second.motion, Fixed)
    assert second.shape.origin[2] - first.shape.origin[2] == pytest.approx(2.0e-4)


def test_spacers_hold_the_whole_holder_and_segments():
    for given in ({}, {"blank_holder_segments": 4}):
        (free,), (held,) = holders(**given), holders(**given, blank_holder_stop=3.0e-4)
        assert free.motion.stop is None and held.motion.stop == 0.0
        assert held.shape.origin[2] - free.shape.origin[2] == pytest.approx(3.0e-4)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"blank_holder_segments": 6}, "a symmetry plane would cut one; take a multiple of 4"),
        ({"blank_holder_segments": 3, "part": "half"}, "take a multiple of 2"),
        ({"blank_holder_segments": 8, "blank_holder_loads": "1,2,3"}, "3 values for the 2 segments of the part"),
        ({"blank_holder_segments": 8, "blank_holder_loads": "1,-2"}, "'-2': a force of zero or more"),
        ({"blank_holder_segments": 8, "blank_holder_loads": "1,gap x"}, "'gap x': a force of zero or more"),
        ({"blank_holder_segments": 8, "blank_holder_loads": "1,gap 0.5"}, "a gap of at most 0.1 m"),
        ({"blank_holder_loads": "1,2"}, "has no effect without"),
        ({"blank_holder_segments": 8, "blank_holder_loads": "1,2", "blank_holder_force": 5.0}, "choose one"),
        ({"blank_holder_stop": 1e-4, "blank_holder_gap": 1e-4}, "no use for a stop"),
        ({"blank_holder_segments": 0}, "blank_holder_segments"),
    ],
)
def test_bad_input_is_refused(given, message):
    with pytest.raises(InputError, match=message):
        holders(**given)
