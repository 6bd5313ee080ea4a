"""The region of a mean of squared distances, against χ² written another way and against draws."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import gammaincinv

from estimation.consistency import PROBABILITY, consistency_of

ALLOWED_ERRORS = 2.6
"""Standard errors, with fixed seeds."""


def quantile(probability: float, freedom: float) -> float:
    """χ² as what it is, a gamma distribution of shape ν/2 and scale 2."""
    return float(2 * gammaincinv(freedom / 2, probability))


def test_region_of_a_mean() -> None:
    """n times the mean is χ² with the sum of the degrees of freedom."""
    squared = np.array([0.5, np.nan, 9.0, 2.0, 0.001, np.nan])
    freedom = np.array([1, 0, 3, 2, 3, 2])
    found = consistency_of(squared, freedom)
    assert found.count == 4
    assert found.mean == pytest.approx(11.501 / 4, rel=1e-14)
    assert found.expected == 9 / 4
    tail = (1 - PROBABILITY) / 2
    assert found.lower == pytest.approx(quantile(tail, 9) / 4, rel=1e-12)
    assert found.upper == pytest.approx(quantile(1 - tail, 9) / 4, rel=1e-12)
    assert found.is_inside
    # 9.0 of 3 is below its own upper limit, 9.35; 0.001 of 3 is below the lower one, 0.22.
    assert found.inside_fraction == 3 / 4


def test_one_freedom_for_all_is_that_freedom_for_each() -> None:
    squared = np.array([3.0, 1.0, np.nan, 8.0])
    assert consistency_of(squared, 4) == consistency_of(squared, np.full(4, 4))


def test_the_region_holds_the_mean_as_often_as_it_says() -> None:
    rng = np.random.default_rng(10)
    freedom, n_trials = np.array([1, 3, 3, 6, 2]), 4000
    found = [consistency_of(rng.chisquare(freedom), freedom) for _ in range(n_trials)]
    for fractions, n in (
        ([one.is_inside for one in found], n_trials),
        ([one.inside_fraction for one in found], n_trials * len(freedom)),
    ):
        standard_error = np.sqrt(PROBABILITY * (1 - PROBABILITY) / n)
        assert abs(np.mean(fractions) - PROBABILITY) < ALLOWED_ERRORS * standard_error
