"""Intervals by resampling: what they are drawn from, and how often they hold the truth."""

from __future__ import annotations

import numpy as np
import pytest

from benchmark.verdicts.bootstrap import RESAMPLES, STATISTICS, Interval, Strata, interval
from models.arrays import Array

ONE_CELL = 30


def of_mean(values: Array, cell: Array | None = None, name: str = "a") -> Interval:
    strata = Strata(np.zeros(len(values), dtype=np.int64) if cell is None else cell)
    return interval(name, strata, lambda index: np.mean(values[index], axis=-1), len(values))


def test_resamples_stay_within_their_cells() -> None:
    cell = np.array([0, 0, 0, 1, 2, 2, 3, 3, 3, 3])
    drawn = Strata(cell).resamples("a")
    assert drawn.shape == (RESAMPLES, len(cell))
    assert np.array_equal(cell[drawn], np.tile(cell, (RESAMPLES, 1)))
    # With replacement, each member of a cell as often as another: within five deviations.
    for number in range(4):
        members = np.flatnonzero(cell == number)
        places = drawn[:, members].ravel()
        counts = np.array([(places == member).sum() for member in members])
        p, n = 1 / len(members), len(places)
        assert np.abs(counts - n * p).max() <= 5 * np.sqrt(n * p * (1 - p))


def test_a_name_is_a_set_of_draws() -> None:
    values = np.random.default_rng(0).standard_normal(20)
    assert of_mean(values) == of_mean(values)
    assert of_mean(values, name="b") != of_mean(values)


def test_the_interval_of_a_mean_holds_the_truth_as_often_as_it_says() -> None:
    """With 30 values; the percentile interval of few values is known to be too short."""
    drawn = np.random.default_rng(1).normal(3.0, 2.0, (400, ONE_CELL))
    found = [of_mean(values, name=str(i)) for i, values in enumerate(drawn)]
    holds = np.mean([of.low <= 3.0 <= of.high for of in found])
    assert 0.90 <= holds <= 0.98
    # Its width is that of the mean's normal law: ±1.96 σ/√n.
    width = np.mean([of.high - of.low for of in found])
    assert width == pytest.approx(2 * 1.96 * 2.0 / np.sqrt(ONE_CELL), rel=0.06)


def test_differences_between_cells_are_not_chance() -> None:
    """The cases are the ones that are asked about: only their seeds are drawn anew."""
    cell = np.repeat([0, 1], 10)
    values = np.where(cell == 0, 1.0, 100.0)
    assert of_mean(values, cell) == Interval(50.5, 50.5, 50.5)
    mixed = of_mean(values)
    assert mixed.high - mixed.low > 20


def test_one_seed_leaves_nothing_to_draw() -> None:
    assert of_mean(np.array([1.0, 5.0]), np.array([0, 1])) == Interval(3.0, 3.0, 3.0)


def test_infinite_figures(recwarn: pytest.WarningsRecorder) -> None:
    """Three of twenty runs never settle: a resample without them happens in 4 % of the draws."""
    values = np.array([1.0] * 17 + [np.inf] * 3)
    found = of_mean(values)
    assert (found.figure, found.low, found.high) == (np.inf, 1.0, np.inf)
    median = STATISTICS["median"]
    strata = Strata(np.zeros(20, dtype=np.int64))
    settled = interval("a", strata, lambda index: median(values[index]), 20)
    assert (settled.figure, settled.low) == (1.0, 1.0)
    against = interval("a", strata, lambda index: median(values[index] - values[index]), 20)
    assert np.isnan([against.low, against.high]).all()
    assert not recwarn.list
