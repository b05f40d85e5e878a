"""Designs that are known from the start: all combinations, a Latin hypercube, Sobol's design for indices."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np

from ...errors import InputError
from ..factors import Factor, Value
from ..schema import LARGEST_RUN_COUNT
from .trials import Plan, Trial


def design(points: Sequence[tuple[Value, ...]]) -> Plan:
    """A plan that asks for all points at once."""
    yield [Trial(values, point=index) for index, values in enumerate(points)]


def factorial(factors: Sequence[Factor]) -> list[tuple[Value, ...]]:
    """Every combination of the values of all factors, the last one changing fastest.

    Raises:
        InputError: a factor without a number of values, or too many combinations.
    """
    levels = [factor.levels() for factor in factors]
    count = 1
    for values in levels:
        count *= len(values)
    if count > LARGEST_RUN_COUNT:
        raise InputError(f"a factorial study of these parameters has {count:,} runs; take latin-hypercube or sobol")
    return list(product(*levels))


def latin_hypercube(factors: Sequence[Factor], samples: int, seed: int) -> list[tuple[Value, ...]]:
    """``samples`` points, in every factor one in each of so many parts of equal probability."""
    from scipy.stats.qmc import LatinHypercube

    shares = LatinHypercube(len(factors), rng=np.random.default_rng(seed)).random(samples)
    return _points(factors, shares)


def sobol_design(factors: Sequence[Factor], samples: int, seed: int) -> list[tuple[Value, ...]]:
    """``samples`` (k + 2) points: matrices A and B, then A with one column after the other from B.

    Saltelli et al., "Variance based sensitivity analysis of model output", Comput. Phys. Commun. 181 (2010). A and B
    are the halves of one scrambled Sobol sequence of dimension 2 k, as in ``scipy.stats.sobol_indices``.
    """
    from scipy.stats.qmc import Sobol

    k = len(factors)
    both = Sobol(2 * k, scramble=True, rng=np.random.default_rng(seed)).random(samples)
    a, b = both[:, :k], both[:, k:]
    parts = [a, b]
    for column in range(k):
        mixed = a.copy()
        mixed[:, column] = b[:, column]
        parts.append(mixed)
    return _points(factors, np.concatenate(parts))


def scenarios(factors: Sequence[Factor], count: int, seed: int) -> list[tuple[Value, ...]]:
    """The same values of uncontrolled factors for every candidate, so that candidates differ by themselves alone."""
    return latin_hypercube(factors, count, seed) if factors else []


def _points(factors: Sequence[Factor], shares: np.ndarray) -> list[tuple[Value, ...]]:
    return [tuple(factor.at(float(share)) for factor, share in zip(factors, row, strict=True)) for row in shares]
