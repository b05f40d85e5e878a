"""Waves: a sine of given amplitude and wavelength on a plane, on a cylinder, and above a tool."""

import numpy as np
import pytest

from weavesim.measures.defects.waves import waves
from weavesim.sheet.blank import Blank

LONGEST = 0.06
BLANK = Blank.rectangle((0.0, 0.0), (0.3, 0.2), 0.0025)
CENTRE = BLANK.element_centres()
# a wavelength from the border
INNER = (np.abs(CENTRE[:, 0] - 0.15) < 0.09) & (np.abs(CENTRE[:, 1] - 0.1) < 0.04)


def sine(wavelength, amplitude, across=0.0):
    x, y = BLANK.material_coordinates.T
    return amplitude * np.sin(2.0 * np.pi * (np.cos(across) * x + np.sin(across) * y) / wavelength)


@pytest.mark.parametrize(
    ("wavelength", "amplitude", "across", "tolerance"),
    [(0.03, 1e-3, 0.0, 0.05), (0.02, 5e-4, 0.6, 0.05), (0.05, 2e-3, 1.57, 0.08)],
)
def test_a_sine_has_its_amplitude_and_wavelength(wavelength, amplitude, across, tolerance):
    position = np.column_stack([BLANK.material_coordinates, sine(wavelength, amplitude, across)])
    found = waves(BLANK, position, LONGEST)
    assert found.amplitude[INNER].mean() == pytest.approx(amplitude, rel=tolerance)
    assert found.wavelength[INNER].mean() == pytest.approx(wavelength, rel=tolerance)
    if wavelength < 0.04:  # a longer one is half outside the band
        assert found.amplitude[INNER] == pytest.approx(amplitude, rel=0.15)


def test_a_plane_at_any_angle_has_no_waves_even_at_its_border():
    x, y = BLANK.material_coordinates.T
    found = waves(BLANK, np.column_stack([x, 0.8 * y, 0.3 * x + 0.6 * y]), LONGEST)
    assert np.abs(found.deviation).max() < 1e-12


def test_a_cylinder_is_the_shape_of_a_part_and_its_waves_are_found():
    x, y = BLANK.material_coordinates.T
    radius = 0.2
    smooth = waves(BLANK, np.column_stack([radius * np.sin(x / radius), y, radius * np.cos(x / radius)]), LONGEST)
    assert smooth.amplitude[INNER].max() < 5e-5
    # a border is smoothed from one side only
    assert np.abs(smooth.deviation).max() < 6e-4
    bumpy = radius + sine(0.03, 1e-3, 1.57)
    found = waves(BLANK, np.column_stack([bumpy * np.sin(x / radius), y, bumpy * np.cos(x / radius)]), LONGEST)
    assert found.amplitude[INNER].mean() == pytest.approx(1e-3, rel=0.05)


def test_above_a_tool_its_shape_does_not_count():
    """A sheet over a sharp bend: its heights above the tool are those of the waves alone."""
    x, y = BLANK.material_coordinates.T
    bent = np.column_stack([x, y, np.maximum(x - 0.15, 0.0)])
    height = sine(0.02, 5e-4)
    assert waves(BLANK, bent, LONGEST).amplitude.max() > 1e-3
    found = waves(BLANK, bent, LONGEST, height)
    assert found.amplitude[INNER].mean() == pytest.approx(5e-4, rel=0.05)
