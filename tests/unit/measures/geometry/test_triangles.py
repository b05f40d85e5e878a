"""Whether triangles meet: known cases, at the limit of rounding; by linear programming in ``test_crossings.py``."""

import numpy as np
import pytest

from weavesim.measures.geometry.triangles import meet, pierces, volume_sign

FLAT = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
# Through the middle of FLAT, upright.
UPRIGHT = np.array([[0.25, 0.25, -1.0], [0.25, 0.25, 1.0], [1.0, 1.0, 0.0]])


def moved(triangle: np.ndarray, *, seed: int) -> np.ndarray:
    """By a rotation and a shift far from the origin, the same for every triangle of a seed."""
    rng = np.random.default_rng(seed)
    rotation = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    return triangle @ rotation.T + rng.uniform(-1.0, 1.0, 3)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize(
    ("other", "wanted"),
    [
        (UPRIGHT, True),
        (FLAT + (0.0, 0.0, 1.0e-9), False),
        (FLAT + (0.4, 0.4, 0.0), True),
        (FLAT + (0.6, 0.6, 0.0), False),
        (UPRIGHT + (0.26, 0.26, 0.0), False),
        (UPRIGHT + (0.0, 0.0, 1.0 + 1.0e-9), False),
        (UPRIGHT + (0.0, 0.0, 1.0 - 1.0e-9), True),
    ],
)
def test_triangles_meet_or_not_wherever_they_are(seed, other, wanted):
    first, second = moved(FLAT, seed=seed), moved(other, seed=seed)
    assert meet(np.stack([first, second]), np.stack([second, first])).tolist() == [wanted, wanted]


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize(("shift", "overlaps"), [(0.4, True), (0.6, False), (2.0, False)])
def test_triangles_of_one_plane_but_for_rounding(seed, shift, overlaps):
    """One corner is off the plane by more than what counts as rounding, as in flat parts of a sheet that is bent."""
    first = moved(FLAT, seed=seed)
    for corner in range(3):
        other = FLAT + (shift, shift, 0.0)
        other[corner, 2] += 3.0e-13
        second = moved(other, seed=seed)
        # without its first corner, only an edge beside the other triangle is left in the plane
        wanted = overlaps and corner != 0
        assert meet(np.stack([first, second]), np.stack([second, first])).tolist() == [wanted, wanted]


def test_touching_is_meeting_and_no_pairs_are_none():
    on_the_face = UPRIGHT + (0.0, 0.0, 1.0)
    at_a_corner = FLAT + (1.0, 0.0, 0.0)
    assert meet(np.stack([FLAT, FLAT, FLAT]), np.stack([on_the_face, at_a_corner, FLAT])).all()
    assert meet(np.zeros((0, 3, 3)), np.zeros((0, 3, 3))).tolist() == []


def test_a_segment_that_only_touches_does_not_go_through():
    p, q = np.array([[0.2, 0.2, 0.0]]), np.array([[0.2, 0.2, 1.0]])
    assert pierces(p, q, FLAT[None], touching=True).all() and not pierces(p, q, FLAT[None], touching=False).any()
    assert pierces(p - (0.0, 0.0, 0.5), q, FLAT[None], touching=False).all()


def test_a_volume_of_rounding_has_no_sign():
    a, b, c = (corner[None] for corner in FLAT)
    heights = np.array([0.0, 1.0e-15, 1.0e-12, -1.0e-12, 1.0])
    assert [int(volume_sign(a, b, c, np.array([[0.3, 0.3, z]]))[0]) for z in heights] == [0, 0, 1, -1, 1]
