"""Sectors of a plate with an opening are together the whole, and each of them has the distance that it should."""

import numpy as np
import pytest

from weavesim import Tool
from weavesim.errors import InputError
from weavesim.tools import DomeOpening, DomeOpeningSector, Union

SIZES = {"radius": 0.02, "half_length": 0.03, "edge_radius": 0.004}
WHOLE = DomeOpening(**SIZES)


def points(count=4000):
    random = np.random.default_rng(3)
    return random.uniform((-0.12, -0.09, -0.01), (0.12, 0.09, 0.01), (count, 3))


@pytest.mark.parametrize("count", [2, 3, 8])
def test_all_sectors_together_are_the_whole(count):
    step = 360.0 / count
    parts = tuple(DomeOpeningSector(**SIZES, begin=k * step - 20.0, end=(k + 1) * step - 20.0) for k in range(count))
    every = points()
    expected, _ = Tool("whole", WHOLE).distance(every)
    found, _ = Tool("parts", Union(parts)).distance(every)
    outside = expected > 0.0
    np.testing.assert_allclose(found[outside], expected[outside], atol=1e-12)
    # inside, a side may be nearer: a bound
    assert np.all(found[~outside] >= expected[~outside] - 1e-12) and np.all(found[~outside] <= 1e-12)


def test_distance_and_normal_of_a_sector_belong_together():
    """The gradient of the distance is the normal, of length one, and none is nearer than to the whole."""
    sector = Tool("sector", DomeOpeningSector(**SIZES, begin=10.0, end=75.0))
    every, size = points(1500), 1e-6
    distance, normal = sector.distance(every)
    steps = [sector.distance(every + size * axis)[0] - sector.distance(every - size * axis)[0] for axis in np.eye(3)]
    gradient = np.stack(steps, axis=1) / (2.0 * size)
    smooth = np.abs(np.linalg.norm(gradient, axis=1) - 1.0) < 1e-4
    # not where a side meets the wall of the opening at another angle: there it is a bound
    assert smooth.mean() > 0.9
    np.testing.assert_allclose(gradient[smooth], normal[smooth], atol=2e-4)
    whole, _ = Tool("whole", WHOLE).distance(every)
    assert np.all(distance >= whole - 1e-12)


def test_what_is_drawn_is_the_surface():
    for begin, end in ((0.0, 45.0), (90.0, 270.0)):
        shape = DomeOpeningSector(**SIZES, begin=begin, end=end)
        vertices, faces = shape.display_triangles()
        assert len(faces) > 20
        distance, _ = Tool("sector", shape).distance(vertices)
        assert np.abs(distance).max() < 2e-5
        angle = np.degrees(np.arctan2(vertices[:, 1], vertices[:, 0])) % 360.0
        assert np.all(((angle >= begin - 1e-6) & (angle <= end + 1e-6)) | (angle > 360.0 - 1e-6))


@pytest.mark.parametrize(("begin", "end"), [(0.0, 0.0), (30.0, 10.0), (0.0, 181.0)])
def test_a_sector_goes_on_from_its_begin(begin, end):
    with pytest.raises(InputError, match="by up to 180 degrees"):
        DomeOpeningSector(**SIZES, begin=begin, end=end)
