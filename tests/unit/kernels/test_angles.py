"""Angles in lanes against NumPy, in both precisions, with one lane and with sixteen."""

import numpy as np
import pytest
import warp as wp

from tests.support.lanes import scalars
from weavesim.kernels.angles import angle_beside, angle_of, angles_of
from weavesim.kernels.lane_types import CPU_LANE_COUNT, lane_types
from weavesim.kernels.lanes import square_root


def test_angle_is_that_of_arctan2(types):
    lanes = types.lanes

    @wp.kernel(module="unique", enable_backward=False)
    def angles(sine: wp.array(dtype=lanes), cosine: wp.array(dtype=lanes), result: wp.array(dtype=lanes)):
        i = wp.tid()
        s = sine[i]
        c = cosine[i]
        result[i] = angle_of(s, c, square_root(wp.cw_mul(s, s) + wp.cw_mul(c, c)))

    expected = np.concatenate([np.linspace(-1.0, 1.0, 465), np.geomspace(1e-12, 1e-2, 15)]) * np.deg2rad(170.0)
    size = np.geomspace(1e-3, 1e3, len(expected))
    result = scalars(types, np.zeros(len(expected)))
    wp.launch(
        angles,
        dim=len(expected) // types.lane_count,
        inputs=[scalars(types, size * np.sin(expected)), scalars(types, size * np.cos(expected))],
        outputs=[result],
        device="cpu",
    )
    # relative: small angles keep their digits; the polynomial itself is good to 1e-14
    error = np.abs(result.numpy().ravel() - expected)
    assert np.all(error <= np.maximum(4.0 * np.finfo(wp.dtype_to_numpy(types.real)).eps, 2e-14) * np.abs(expected))


def test_two_angles_at_once_have_the_bits_of_each():
    types = lane_types(wp.float32, CPU_LANE_COUNT)
    lanes = types.lanes

    @wp.kernel(module="unique", enable_backward=False)
    def both(sine: wp.array(dtype=lanes), beside: wp.array(dtype=lanes), result: wp.array2d(dtype=lanes)):
        i = wp.tid()
        j = (i + 1) % sine.shape[0]
        first, second = angles_of(sine[i], beside[i], sine[j], beside[j])
        result[0, i] = first - angle_beside(sine[i], beside[i])
        result[1, i] = second - angle_beside(sine[j], beside[j])
        result[2, i] = first

    angle = np.linspace(-3.0, 3.0, 5 * CPU_LANE_COUNT)
    sine, beside = scalars(types, np.sin(angle)), scalars(types, 1.0 + np.cos(angle))
    result = wp.full((3, 5), wp.nan, dtype=lanes, device="cpu")
    wp.launch(both, dim=5, inputs=[sine, beside], outputs=[result], device="cpu")
    assert not np.any(result.numpy()[:2])
    assert result.numpy()[2].ravel() == pytest.approx(angle, abs=1e-5)
