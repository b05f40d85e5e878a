"""Colours of angles and of sheets."""

import numpy as np
import pytest

from weavesim.output.colours import DISTINCT_COLOURS, colour_table, distinct_colour, encoded, shear_colours


def test_angles_have_the_colours_of_the_table_whatever_their_sign():
    table = colour_table()
    assert np.array_equal(shear_colours(np.array([0.0, 60.0, 90.0])), table[[0, 255, 255]])
    assert np.array_equal(shear_colours(np.array([-30.0])), shear_colours(np.array([30.0])))
    assert (np.diff(table @ (0.2126, 0.7152, 0.0722)) > 0.0).all()


def test_colours_of_sheets_are_those_of_lines_in_linear_light():
    for place, code in enumerate(DISTINCT_COLOURS):
        values = 255.0 * encoded(np.array(distinct_colour(place)))
        assert values == pytest.approx([int(code[k : k + 2], 16) for k in (1, 3, 5)], abs=1e-3)
    assert len(set(map(distinct_colour, range(len(DISTINCT_COLOURS))))) == len(DISTINCT_COLOURS)
    assert distinct_colour(len(DISTINCT_COLOURS)) == distinct_colour(0)
