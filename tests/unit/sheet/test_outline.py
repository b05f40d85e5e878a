"""Distances from closed polygons, with holes."""

import numpy as np

from weavesim.sheet.outline import Outline, Region, checked_outline

SQUARE = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])


def test_distance_is_positive_inside_and_the_arc_goes_around():
    distance, arc = Outline(SQUARE).nearest(np.array([[1.0, 0.5], [3.0, 1.0], [-1.0, 2.0]]))
    assert np.allclose(distance, [0.5, -1.0, -1.0])
    assert np.allclose(arc, [1.0, 3.0, 6.0])


def test_a_hole_is_outside():
    hole = Outline(0.5 * SQUARE[::-1] + 0.5)
    region = Region([Outline(SQUARE), hole])
    assert np.allclose(region.distance(np.array([[1.0, 1.0], [0.25, 1.0], [0.4, 1.0]])), [-0.5, 0.25, 0.1])
    assert region.has_hollows and not Region([Outline(SQUARE)]).has_hollows


def test_corners_become_counter_clockwise():
    assert np.array_equal(checked_outline(SQUARE[::-1]), SQUARE)
