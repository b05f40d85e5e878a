"""Folds of a rim are counted, and nothing else is."""

import numpy as np
import pytest

from tests.support.flat_blanks import FULL, HALF_IN_X, QUARTER
from weavesim import measures
from weavesim.sheet.blank import Blank


def rim_position(blank, radius):
    """Nodes at a distance from the axis that depends on the position along the sides of the square, from 0 to 2 pi."""
    x, y = blank.material_coordinates.T
    polar = np.arctan2(y, x)
    side = np.round(polar / (np.pi / 2))
    distance = radius((side + 0.5 * np.tan(polar - side * np.pi / 2)) * np.pi / 2)
    return np.column_stack([distance * np.cos(polar), distance * np.sin(polar), -np.hypot(x, y)])


@pytest.mark.parametrize(("symmetry", "count"), [(FULL, 7), (QUARTER, 8), (HALF_IN_X, 6)])
def test_folds_of_a_fluted_rim_are_counted(symmetry, count):
    half = 0.2
    lower = [0.0 if axis in symmetry.planes else -half for axis in "xy"]
    blank = Blank.rectangle(lower, (half, half), 0.005)
    folds = measures.rim_folds(blank, rim_position(blank, lambda p: 0.1 + 0.008 * np.cos(count * p)), symmetry)
    assert folds.fold_count == count
    assert folds.amplitude == pytest.approx(0.008, rel=0.02)


def test_a_wrapped_cloth_has_no_folds_and_a_flat_one_is_not_wrapped():
    from weavesim.scenes.hemisphere import smooth_radius

    blank = Blank.rectangle((-0.2, -0.2), (0.2, 0.2), 0.01)
    smooth = smooth_radius(blank, 0.1)
    flat = blank.node_position
    wrapped = flat * (smooth / np.maximum(np.linalg.norm(flat, axis=1), 1e-12))[:, None]
    folds = measures.rim_folds(blank, wrapped, smooth_radius=smooth)
    assert folds.fold_count == 0 and folds.amplitude < 1e-12
    angle = np.arctan2(flat[:, 1], flat[:, 0])
    fluted = wrapped * (1.0 + 0.1 * np.cos(6 * angle))[:, None]
    folds = measures.rim_folds(blank, fluted, smooth_radius=smooth)
    assert folds.fold_count == 6
    assert folds.amplitude == pytest.approx(0.01, rel=0.02)


def test_a_smooth_rim_has_no_folds_and_noise_does_not_count():
    blank = Blank.rectangle((-0.2, -0.2), (0.2, 0.2), 0.005)
    still = measures.rim_folds(blank, rim_position(blank, lambda p: 0.1 + 0.0 * p))
    assert still.fold_count == 0 and still.amplitude < 1e-12
    noise = rim_position(blank, lambda p: 0.1 + 0.0005 * np.sin(31 * p))
    assert measures.rim_folds(blank, noise).fold_count == 0
    assert measures.rim_folds(blank, noise, threshold=0.0005).fold_count == 31
