"""Least squares against linear theory: estimates, intervals from repeats and from residuals, bounds, starts."""

import numpy as np
import pytest
from scipy.stats import t

from weavesim.calibration.fitting import Problem, Unknown, solve
from weavesim.calibration.fitting.fit import condition, inverse_square

X = np.linspace(0.0, 1.0, 25)
DESIGN = np.column_stack([np.ones_like(X), X])
TRUE = np.array([2.0, -3.0])


def line_problem(observed, repeats, sigma=0.1, low=-100.0):
    """A straight line through repeats on the same points."""
    unknowns = tuple(Unknown(name, "", "", 0.5, low, 100.0, is_log=False) for name in ("a", "b"))
    count = len(observed) // len(X)
    design = np.tile(DESIGN, (count, 1))
    group = np.zeros(len(observed), dtype=int)
    return Problem(
        unknowns, lambda sets: sets @ design.T, observed, np.full(len(observed), sigma), group,
        np.repeat(np.arange(repeats), len(observed) // repeats), ("line",),
    )  # fmt: skip


def test_a_line_is_found_with_the_interval_of_regression():
    rng = np.random.default_rng(0)
    observed = DESIGN @ TRUE + 0.1 * rng.standard_normal(len(X))
    fit = solve(line_problem(observed, 1))
    exact, sum_of_squares, *_ = np.linalg.lstsq(DESIGN, observed, rcond=None)
    np.testing.assert_allclose(fit.values, exact, rtol=1e-6)
    variance = float(sum_of_squares[0]) / (len(X) - 2)
    deviation = np.sqrt(variance * np.diag(np.linalg.inv(DESIGN.T @ DESIGN)))
    # neighbours of this noise are not alike
    np.testing.assert_allclose(fit.deviation, deviation, rtol=1e-4)
    half = t.ppf(0.975, len(X) - 2) * deviation
    np.testing.assert_allclose(fit.interval(0), (exact[0] - half[0], exact[0] + half[0]), rtol=1e-4)


def test_with_repeats_the_interval_is_that_of_their_mean():
    rng = np.random.default_rng(1)
    # every specimen has its own line
    lines = [DESIGN @ (TRUE + 0.3 * rng.standard_normal(2)) + 0.01 * rng.standard_normal(len(X)) for _ in range(5)]
    fit = solve(line_problem(np.concatenate(lines), 5))
    own = np.array([np.linalg.lstsq(DESIGN, line, rcond=None)[0] for line in lines])
    np.testing.assert_allclose(fit.values, own.mean(axis=0), rtol=1e-6)
    np.testing.assert_allclose(fit.deviation, own.std(axis=0, ddof=1) / np.sqrt(5), rtol=1e-5)
    np.testing.assert_allclose(fit.half_width, t.ppf(0.975, 4) * fit.deviation, rtol=1e-6)


def test_alike_neighbours_widen_the_interval():
    rng = np.random.default_rng(2)
    count = 12 * len(X)
    white = rng.standard_normal(count)
    walk = np.convolve(rng.standard_normal(count + 9), np.ones(10) / np.sqrt(10), "valid")
    ratios = []
    for noise in (white, walk):
        fit = solve(line_problem(np.tile(DESIGN @ TRUE, 12) + 0.1 * noise, 1))
        size = np.sqrt(fit.residual @ fit.residual / (count - 2))
        ratios.append(fit.deviation[0] / size / np.sqrt(inverse_square(fit.jacobian)[0, 0]))
    assert ratios[0] == pytest.approx(1.0, abs=0.1)
    # neighbours correlated by 0.9: the variance of a mean is (1 + 0.9) / (1 - 0.9) times that of white noise
    assert ratios[1] == pytest.approx(np.sqrt(19.0), rel=0.3)


def test_a_bound_is_said_and_has_no_interval():
    fit = solve(line_problem(DESIGN @ TRUE, 1, low=0.0))
    assert fit.at_bound.tolist() == [False, True] and fit.values[1] == 0.0
    assert np.isnan(fit.interval(1)).all() and np.isfinite(fit.interval(0)).all()


def test_several_starts_find_the_deeper_of_two_minima():
    def predict(sets):
        u = np.log(sets[:, :1])
        return np.hstack([(u**2 - 1.0), 0.1 * (u + 1.0)])  # minima at e and 1/e; 1/e is the deeper one

    unknown = Unknown("v", "", "", 4.0, 0.01, 100.0)
    zeros = np.zeros(2)
    problem = Problem((unknown,), predict, zeros, np.ones(2), zeros.astype(int), zeros.astype(int), ("well",))
    assert solve(problem).values[0] > 1.0
    best = solve(problem, starts=8)
    assert best.values[0] == pytest.approx(np.exp(-1.0), rel=1e-3)
    assert len(best.costs) == 8 and 1 <= best.same_minimum < 8


def test_held_values_stay_and_their_uncertainty_widens_the_rest():
    rng = np.random.default_rng(3)
    problem = line_problem(DESIGN @ TRUE + 0.01 * rng.standard_normal(len(X)), 1)
    held = solve(problem, held=["b"])
    assert held.values[1] == 0.5 and held.chosen.tolist() == [0]
    loose = solve(problem, held=["b"], held_uncertainty=0.5)
    # the mean of X is a half: a changes by half of what b does
    assert loose.effect_of_held[0, 0] == pytest.approx(-0.5, rel=1e-6)
    assert loose.deviation[0] ** 2 - held.deviation[0] ** 2 == pytest.approx((0.5 * 0.25) ** 2, rel=1e-3)


def test_what_cannot_be_predicted_is_avoided():
    def predict(sets):
        return np.where(sets > 5.0, np.nan, sets) * np.ones((1, 4))

    unknown = Unknown("v", "", "", 20.0, 0.1, 100.0)
    problem = Problem(
        (unknown,), predict, np.full(4, 2.0), np.ones(4), np.zeros(4, dtype=int), np.zeros(4, dtype=int), ("t",)
    )
    assert solve(problem, starts=16).values[0] == pytest.approx(2.0, rel=1e-6)


def test_condition_of_a_direction_that_is_not_seen():
    assert condition(np.array([[1.0, 1.0], [1.0, 1.0]])) > 1e12
    assert inverse_square(np.array([[1.0, 0.0], [0.0, 0.0]]))[1, 1] > 1e20
