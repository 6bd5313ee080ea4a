from __future__ import annotations

import math

import numpy as np
import pytest

from classical_baseline.fixed_weight import FixedWeightConfig, run
from classical_baseline.weight_search import (
    CURVE_WEIGHTS,
    Ended,
    best_weight,
    search_weight,
    weight_curve,
)
from models.errors import InputError


def valley(at: float) -> object:
    return lambda weight: 1 + (weight - at) ** 2


def test_it_finds_the_valley() -> None:
    found = search_weight(valley(0.3))  # type: ignore[arg-type]
    assert found.ended is Ended.INSIDE
    assert not found.ended.at_bound
    assert found.weight == pytest.approx(0.3, abs=1e-3)
    assert found.rmse == pytest.approx(1.0, abs=1e-6)
    assert abs(found.slope) < 3e-3


@pytest.mark.parametrize(
    ("at", "bound", "ended"), [(1.2, 1.0, Ended.UPPER_BOUND), (-0.1, 0.0, Ended.LOWER_BOUND)]
)
def test_it_says_where_it_ends_at_a_bound(at: float, bound: float, ended: Ended) -> None:
    found = search_weight(valley(at))  # type: ignore[arg-type]
    assert (found.weight, found.ended) == (bound, ended)
    assert found.ended.at_bound
    assert math.copysign(1.0, found.slope) == (-1.0 if ended is Ended.UPPER_BOUND else 1.0)


def test_it_never_leaves_its_interval_and_counts_its_runs() -> None:
    seen = []

    def rmse(weight: float) -> float:
        seen.append(weight)
        return (weight - 0.999) ** 2

    found = search_weight(rmse)
    assert found.evaluations == len(seen)
    assert 0 <= min(seen) <= max(seen) <= 1


def test_white_noise_at_rest_has_no_best_weight() -> None:
    """One step of a first-order filter: var = σ² / (1 + 2w), falling for ever."""
    rng = np.random.default_rng(0)
    n = 20000
    acceleration = np.array([0.0, 0.0, 1.0]) + rng.normal(0, 0.01, (n, 3))
    time_s, rates = 0.01 * np.arange(n), np.zeros((n, 2))

    def rmse(weight: float) -> float:
        R = run(FixedWeightConfig(weight), time_s, acceleration, rates)
        return float(np.sqrt(np.mean(np.arctan2(R[:, 1], R[:, 2]) ** 2)))

    raw = rmse(0.0)
    for weight in (0.25, 1.0, 20.0):
        expected = raw / math.sqrt(1 + 2 * weight)
        # An average over n / 2w independent values, relative deviation of √(w / n).
        assert rmse(weight) == pytest.approx(expected, rel=0.02 + 3 * math.sqrt(weight / n))


def test_the_curve_and_its_best() -> None:
    assert CURVE_WEIGHTS[0] == 0
    assert CURVE_WEIGHTS[-1] == 300
    assert {0.25, 1.0} < set(CURVE_WEIGHTS)
    assert all(np.diff(CURVE_WEIGHTS) > 0)
    errors = weight_curve(valley(20.0), (0.0, 10.0, 19.0, 22.0))  # type: ignore[arg-type]
    assert errors.tolist() == [401.0, 101.0, 2.0, 5.0]
    assert best_weight((0.0, 10.0, 19.0, 22.0), errors) == 19.0


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"low": 1.0, "high": 1.0}, "interval of the weight is 1.0 to 1.0"),
        ({"low": -1.0}, "interval of the weight is -1.0"),
        ({"high": math.inf}, "to inf"),
        ({"tolerance": 2.0}, "tolerance is 2.0"),
        ({"tolerance": 0.0}, "tolerance is 0.0"),
        ({"difference": 0.3}, "difference is 0.3"),
    ],
)
def test_bad_settings(settings: dict[str, float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        search_weight(valley(0.3), **settings)  # type: ignore[arg-type]


def test_no_curve() -> None:
    with pytest.raises(InputError, match="expected one error for each"):
        best_weight((1.0, 2.0), np.array([1.0]))
    with pytest.raises(InputError, match="at least one weight"):
        best_weight((), np.array([]))
