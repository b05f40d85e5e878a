"""Colours of angles and of sheets."""

import numpy as np
import pytest

from weavesim.output.colours import (
    _CONES_TO_LINEAR,
    _OKLAB_TO_CONES,
    DISTINCT_COLOURS,
    colour_table,
    distinct_colour,
    encoded,
    shear_colours,
)
from weavesim.output.pictures.verdict import COLOURS


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
    decoded = np.where(regions <= 0.04045, regions / 12.92, ((regions + 0.055) / 1.055) ** 2.4)
    for colours in (np.array([distinct_colour(k) for k in range(len(DISTINCT_COLOURS))]), decoded):
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
