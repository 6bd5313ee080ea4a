"""Means and quantiles of parts: exact while they are few, close when they are many."""

from __future__ import annotations

import numpy as np
import pytest

from estimation.consistency import ConsistencyInParts, consistency_of
from estimation.tallies import Mean, Quantiles

NUMBERS = np.random.default_rng(0).lognormal(-8, 1, 5000)


def filled(tally: Mean | Quantiles) -> None:
    for part in np.array_split(NUMBERS, 17):
        tally.add(part)


def test_few_are_those_of_all_at_once() -> None:
    mean, quantiles = Mean(), Quantiles()
    filled(mean)
    filled(quantiles)
    assert mean.value == NUMBERS.mean()
    assert quantiles.median == np.median(NUMBERS)
    assert quantiles.at(0.99) == np.quantile(NUMBERS, 0.99)
    assert np.isnan([Mean().value, Quantiles().median, Quantiles().at(0.99)]).all()


def test_many_are_close(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("estimation.tallies.KEPT", 1000)
    mean, quantiles = Mean(), Quantiles()
    filled(mean)
    filled(quantiles)
    assert mean.count == quantiles.count == len(NUMBERS)
    assert abs(mean.value / NUMBERS.mean() - 1) < 1e-14
    assert abs(quantiles.median / np.median(NUMBERS) - 1) < 2e-3
    assert abs(quantiles.at(0.99) / np.quantile(NUMBERS, 0.99, method="higher") - 1) < 2e-3


def test_one_number_again_and_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """A delay that is always the same is said as it is, and none as none."""
    monkeypatch.setattr("estimation.tallies.KEPT", 10)
    for number in (0.045, 0.0):
        quantiles = Quantiles()
        quantiles.add(np.full(100, number))
        assert abs(quantiles.median - number) < 1e-15


def test_consistency_in_parts() -> None:
    rng = np.random.default_rng(1)
    freedom = rng.integers(1, 7, 1000)
    squared = rng.chisquare(freedom)
    squared[::50] = np.nan
    parts = ConsistencyInParts()
    for rows in np.array_split(np.arange(1000), 7):
        parts.add(squared[rows], freedom[rows])
    assert parts.result() == consistency_of(squared, freedom)
    assert ConsistencyInParts().result() is None
