"""Noise from repeats, and what is no more than noise."""

import numpy as np
import pytest

from weavesim.study.analysis.noise import chance_of, noise_of


def test_the_interval_covers_the_truth_as_often_as_it_says():
    rng = np.random.default_rng(0)
    covered = 0
    for _ in range(400):
        noise = noise_of([(7.0 * point + 0.3 * rng.normal(size=5)).tolist() for point in range(3)])
        covered += noise.low <= 0.3 <= noise.high
    assert 0.91 < covered / 400 < 0.985
    assert noise.degrees == 12 and noise.points == 3


def test_the_least_difference_is_exceeded_by_chance_in_one_pair_of_twenty():
    rng = np.random.default_rng(1)
    noise = noise_of([rng.normal(size=2000).tolist()])
    pairs = rng.normal(size=(20000, 2))
    assert np.mean(np.abs(pairs[:, 0] - pairs[:, 1]) > noise.least_difference) == pytest.approx(0.05, abs=0.01)


def test_without_repeats_nothing_is_known():
    assert noise_of([]) is None and noise_of([[1.0], [2.0]]) is None


def test_chance_tells_an_effect_from_noise():
    noise = noise_of([[0.0, 1.0, -1.0, 0.5, -0.5]] * 4)
    assert chance_of([0.0, 10.0, 20.0], noise) < 1e-6
    assert chance_of([0.0, 0.3, 0.1, -0.2], noise) > 0.5
    exact = noise_of([[1.0, 1.0]])
    assert chance_of([1.0, 2.0], exact) == 0.0 and chance_of([1.0, 1.0], exact) == 1.0
