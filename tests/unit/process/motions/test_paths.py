"""Paths and rotations of tools: their curves, poses, and what is refused."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from weavesim.errors import InputError
from weavesim.process.motions.paths import PathMotion, Pose, Rotation, place_of, turn_matrix
from weavesim.process.strokes import ForceDriven, SmoothStroke, Stroke

Z = (0.0, 0.0, 1.0)
ORIGIN = (0.0, 0.0, 0.0)


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.tuples(st.floats(0.01, 1.0), st.floats(-1.0, 1.0)), min_size=1, max_size=8), st.booleans(),
)  # fmt: skip
def test_a_path_goes_through_its_points_and_stays_between_them(knots, at_rest):
    times = np.cumsum([gap for gap, _ in knots])
    points = [(x, 2.0 * x, 0.0) for _, x in knots]
    motion = PathMotion(tuple(times), points, at_rest=at_rest)
    for time, point in zip(times, points, strict=True):
        np.testing.assert_allclose(motion.state_at(float(time))[0], point, atol=1e-12)
    for k in range(len(times) - 1):
        low, high = sorted((points[k][0], points[k + 1][0]))
        for time in np.linspace(times[k], times[k + 1], 9):
            assert low - 1e-12 <= motion.state_at(float(time))[0][0] <= high + 1e-12
    for time in (times[0] - 1.0, times[-1] + 1.0):
        assert not np.any(motion.rates_at(float(time))[0])
    if at_rest:
        assert not np.any(motion.rates_at(float(times[0]))[0])


def test_the_speed_of_a_path_is_continuous():
    motion = PathMotion((0.0, 1.0, 3.0, 4.0), [(0, 0, 0), (1, 0, 0), (2, 1, 0), (2, 2, 0)])
    for knot in (1.0, 3.0):
        before, after = motion.rates_at(knot - 1e-9)[0], motion.rates_at(knot + 1e-9)[0]
        np.testing.assert_allclose(before, after, atol=1e-6)


def test_two_points_without_rest_are_a_straight_line():
    motion = PathMotion((0.0, 2.0), [(0, 0, 0), (0, 0, 0.4)], at_rest=False)
    assert motion.state_at(0.5)[0][2] == pytest.approx(0.1)
    np.testing.assert_allclose(motion.rates_at(0.7)[0], [0.0, 0.0, 0.2])


def test_a_pose_turns_about_the_point_and_carries_the_axis_along():
    turn = Rotation(Z, (1.0, 0.0, 0.0), (0.0, 1.0), (0.0, 90.0))
    motion = PathMotion((0.0, 1.0), [ORIGIN, (0.0, 0.0, 5.0)], turn, Stroke((0.0, 1.0), (0.0, 2.0)))
    pose = place_of(motion, (0.0, 1.0, 0.0), 2.0, 1.0)
    points = np.array([(1.0, 0.0, 0.0), (2.0, 0.0, 0.0)])
    np.testing.assert_allclose(pose.moved(points), [(1.0, 2.0, 5.0), (1.0, 3.0, 5.0)], atol=1e-12)
    np.testing.assert_allclose(pose.back(pose.moved(points)), points, atol=1e-12)
    np.testing.assert_allclose(pose.turned(np.array([(1.0, 0.0, 0.0)])), [(0.0, 1.0, 0.0)], atol=1e-12)
    assert Pose.from_numbers(pose.numbers) == pose
    assert motion.displacement_at(1.0) == 2.0 and motion.duration == 1.0


@settings(max_examples=40, deadline=None)
@given(st.floats(-7.0, 7.0), st.tuples(*[st.floats(-1.0, 1.0)] * 3))
def test_turn_matrices_are_rotations_about_their_axis(angle, axis):
    axis = np.array(axis) + (0.0, 0.0, 1.5)
    axis /= np.linalg.norm(axis)
    turn = turn_matrix(tuple(axis), angle)
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(turn @ axis, axis, atol=1e-12)
    assert np.trace(turn) == pytest.approx(1.0 + 2.0 * math.cos(angle), abs=1e-12)


def test_a_smooth_rotation_keeps_its_speed_between_the_ramps():
    turn = Rotation.smooth(Z, ORIGIN, -720.0, 10.0, 0.05, start_time=0.1)
    motion = PathMotion(rotation=turn)
    end = 0.1 + 4.0 * math.pi / 10.0 + 0.05
    assert motion.duration == pytest.approx(end)
    assert motion.state_at(0.1)[1] == 0.0 and motion.state_at(end)[1] == pytest.approx(-4.0 * math.pi)
    for time in np.linspace(0.16, end - 0.06, 7):
        np.testing.assert_allclose(motion.rates_at(float(time))[1], [0.0, 0.0, -10.0], rtol=1e-4)
    assert motion.largest_rates(0.0, end)[1] == pytest.approx(10.0, rel=1e-3)


def test_what_is_along_the_axis_is_that_of_the_inner_motion():
    force = ForceDriven.constant(5.0, 2.0, 0.1)
    motion = PathMotion(rotation=Rotation(Z, ORIGIN, (0.0,), (10.0,)), along=force)
    assert motion.is_carried and motion.by_force and motion.driven_mass == 2.0 and motion.along_axis is force
    assert motion.force_at(0.05) == 2.5 and motion.damper(4.0) == force.damper(4.0) and motion.limiting_force == 0.0
    assert not force.is_carried and force.along_axis is force


def test_motions_are_values():
    motion = PathMotion((0.0, 1.0), [ORIGIN, (0.1, 0.0, 0.0)], Rotation(Z, ORIGIN, (0.0, 1.0), (0.0, 30.0)))
    again = PathMotion.from_json(motion.to_json())
    assert again == motion and hash(again) == hash(motion)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: PathMotion((0.0, 1.0), [ORIGIN]), "2 times and 1 points"),
        (lambda: PathMotion((1.0, 0.0), [ORIGIN, ORIGIN]), "times must increase"),
        (lambda: PathMotion((0.0,), [(0.0, 0.0)]), "three finite numbers"),
        (lambda: PathMotion(along=PathMotion()), "no motion along an axis"),
        (lambda: PathMotion(along=SmoothStroke((0.0,), (0.0,), (0.0,))), "no motion along an axis"),
        (lambda: PathMotion(placed=(1.0,) * 12), "rotation matrix"),
        (lambda: PathMotion(placed=(1.0,)), "rotation matrix"),
        (lambda: Rotation(Z, ORIGIN, (0.0, 1.0), (0.0,)), "2 times and 1 angles"),
        (lambda: Rotation(Z, ORIGIN, (), ()), "at least 1"),
        (lambda: Rotation(ORIGIN, ORIGIN, (0.0,), (0.0,)), "a direction is needed"),
        (lambda: Rotation.smooth(Z, ORIGIN, 90.0, 0.0, 0.1), "speed of the rotation"),
    ],
)
def test_bad_input_is_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()
