"""What data cannot tell apart is said, and held."""

from dataclasses import replace

import numpy as np
import pytest

from weavesim.calibration.fitting import Problem, Unknown, fit_reduced

X = np.linspace(0.1, 1.0, 40)
NAMES = ("a", "b", "c")


def product_problem(noise=0.01, seed=0):
    """a b x + c x^2: only the product of a and b can be seen."""
    rng = np.random.default_rng(seed)

    def predict(sets):
        return (sets[:, 0] * sets[:, 1])[:, None] * X + sets[:, 2:3] * X**2

    truth = predict(np.array([[2.0, 3.0, 1.0]]))[0]
    unknowns = tuple(
        Unknown(name, "", "", start, 0.01, 100.0) for name, start in zip(NAMES, (1.0, 3.0, 2.0), strict=True)
    )
    zeros = np.zeros(len(X), dtype=int)
    return Problem(
        unknowns, predict, truth + noise * rng.standard_normal(len(X)), np.full(len(X), noise), zeros, zeros, ("t",)
    )


def test_a_product_is_told_and_one_factor_held():
    found = fit_reduced(product_problem())
    assert len(found.held) == 1 and found.held[0] in ("a", "b")
    assert found.whole.condition > 1e8
    (direction,) = found.weak
    assert {name for name, _ in direction.entries} == {"a", "b"}
    assert direction.entries[0][1] * direction.entries[1][1] < 0.0  # one up, the other down
    a, b, c = found.fit.values
    assert a * b == pytest.approx(6.0, rel=0.02) and c == pytest.approx(1.0, rel=0.1)


def test_the_whole_set_may_be_kept_but_is_said():
    found = fit_reduced(product_problem(), keep_all=True)
    assert found.fit is found.whole and found.held and found.fit.is_free.all()
    low, high = found.fit.interval(NAMES.index(found.held[0]))
    assert low == pytest.approx(0.01) and high == pytest.approx(100.0)  # anything within its bounds


@pytest.mark.parametrize(("ranks", "held"), [((0, 1, 0), "a"), ((1, 0, 0), "b"), ((2, 1, 0), "b")])
def test_the_lowest_rank_is_held_first(ranks, held):
    problem = product_problem()
    unknowns = tuple(replace(u, rank=rank) for u, rank in zip(problem.unknowns, ranks, strict=True))
    assert fit_reduced(replace(problem, unknowns=unknowns)).held == (held,)


def test_nothing_is_held_where_all_can_be_told():
    problem = product_problem()
    assert fit_reduced(problem, held=["b"]).held == ()
