"""Colours of angles and of sheets."""

import numpy as np
import pytest

from weavesim.output.colours import (
    COLOUR_MAP,
    DISTINCT_COLOURS,
    colour_table,
    decoded,
    distinct_colour,
    encoded,
    shear_colours,
)
from weavesim.output.pictures.verdict import COLOURS
from weavesim.output.run_page.writing import COLOUR_TABLES

# Inverse of the OKLab colour space (B. Ottosson, 2020): to cone responses, and from their cubes to linear sRGB.
_OKLAB_TO_CONES = np.array(
    [
        [1.0, 0.3963377774, 0.2158037573],
        [1.0, -0.1055613458, -0.0638541728],
        [1.0, -0.0894841775, -1.2914855480],
    ]
)
_CONES_TO_LINEAR = np.array(
    [
        [4.0767416621, -3.3077115913, 0.2309699292],
        [-1.2684380046, 2.6097574011, -0.3413193965],
        [-0.0041960863, -0.7034186147, 1.7076147010],
    ]
)


def test_pictures_film_and_page_have_one_scale():
    assert COLOUR_TABLES[0] == COLOUR_MAP
    table = colour_table()
    assert decoded(encoded(table)) == pytest.approx(table, abs=1e-7)
    assert [round(255.0 * value) for value in encoded(table)[[0, -1]].ravel()] == [68, 1, 84, 253, 231, 37]


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


# To simulate vision without one kind of cones, linear sRGB (Machado, Oliveira and Fernandes 2009, severity 1).
BLINDNESS = {
    "red": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "green": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "blue": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
    "none": np.eye(3).tolist(),
}


def seen(linear: np.ndarray, blindness: str) -> np.ndarray:
    """OKLab of colours (k, 3) as they are seen."""
    colours = np.clip(linear @ np.array(BLINDNESS[blindness]).T, 0.0, 1.0)
    cones = np.linalg.inv(_OKLAB_TO_CONES) @ np.cbrt(np.linalg.inv(_CONES_TO_LINEAR) @ colours.T)
    return cones.T


@pytest.mark.parametrize("blindness", BLINDNESS)
def test_the_colour_blind_tell_lines_and_regions_apart(blindness):
    regions = np.array([[int(code[k : k + 2], 16) / 255.0 for k in (1, 3, 5)] for code in COLOURS.values()])
    for colours in (np.array([distinct_colour(k) for k in range(len(DISTINCT_COLOURS))]), decoded(regions)):
        lab = seen(colours, blindness)
        apart = np.linalg.norm(lab[:, None] - lab, axis=2) + np.eye(len(lab))
        assert apart.min() > 0.09


@pytest.mark.parametrize("blindness", BLINDNESS)
def test_the_colour_blind_read_the_scale(blindness):
    """Lightness rises steadily, and equal steps look alike."""
    lab = seen(colour_table(), blindness)
    assert np.all(np.diff(lab[:, 0]) > 0.0)
    steps = np.linalg.norm(np.diff(lab[::16], axis=0), axis=1)
    assert steps.min() > 0.25 * steps.max()
