"""Zigzags of a known height are found."""

import numpy as np
import pytest

from tests.support.flat_blanks import FULL, blank_of
from weavesim import measures
from weavesim.sheet.blank import Blank


@pytest.mark.parametrize("distortion", [0.0, 0.25])
def test_checkerboard_finds_a_zigzag_of_known_height(distortion):
    blank = blank_of(FULL, distortion=distortion)
    column = np.arange(blank.element_count) // 14
    row = np.arange(blank.element_count) % 14
    zigzag = np.deg2rad(2.0) * (-1.0) ** (column + row)
    found = measures.checkerboard(blank, 0.2 + zigzag)
    assert (found.rms, found.maximum) == pytest.approx((2.0, 2.0))
    stripes = measures.checkerboard(blank, np.deg2rad(2.0) * (-1.0) ** column)
    assert stripes.maximum < 1e-12


def test_checkerboard_of_a_smooth_field_is_small_and_names_the_worst_node():
    blank = blank_of(FULL)
    centre = blank.element_centres()
    assert measures.checkerboard(blank, centre[:, 0] + 2.0 * centre[:, 1]).maximum < 1e-12
    angle = np.zeros(blank.element_count)
    angle[100] = np.deg2rad(8.0)
    found = measures.checkerboard(blank, angle)
    assert found.maximum == pytest.approx(2.0)
    assert found.node in blank.quads[100]


def test_checkerboard_without_blocks():
    blank = Blank.rectangle((0.0, 0.0), (1.0, 0.1), 0.1)
    assert measures.checkerboard(blank, np.ones(blank.element_count)) == (0.0, 0.0, -1)
