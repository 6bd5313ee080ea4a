"""Arrival costs against least squares written down anew for every window."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from estimation.recording import Measurement
from mhe.arrival_cost import DIFFUSE_FACTOR
from mhe.config import MheConfig
from models.errors import InputError
from tests.configs import config_for
from tests.linear_models import (
    LinearSystem,
    constant_acceleration_system,
    coupled_system,
    irregular_times,
    random_walk_system,
)
from tests.mhe.runs import ESTIMATORS, linear_batch, run_mhe
from tests.references.careless_arrival import newest_variance

SYSTEMS = {"one axis": constant_acceleration_system(1), "coupled": coupled_system(3)}
TOLERANCE_STD = 1e-8


def measured(system: LinearSystem) -> list[Measurement]:
    rng = np.random.default_rng(61)
    return system.simulate(irregular_times(14, rng), rng, missing=0.25)


@pytest.mark.cover
@pytest.mark.parametrize("estimator", ESTIMATORS)
@pytest.mark.parametrize("name", SYSTEMS)
@pytest.mark.parametrize("horizon", [1, 6])
def test_none_forgets_what_was_before_the_window(name: str, horizon: int, estimator: str) -> None:
    system = SYSTEMS[name]
    measurements, prior = measured(system), system.model.prior
    config = config_for(estimator, horizon=horizon, arrival_cost="none")
    for k, estimate in enumerate(run_mhe(system.model, measurements, config, estimator)):
        window = measurements[max(0, k - horizon) : k + 1]
        diffuse = DIFFUSE_FACTOR**2 * prior.covariance
        wanted = linear_batch(system, window, covariance=diffuse).solve()
        assert estimate.window is not None
        error = (estimate.window.states - wanted.states) / wanted.std
        assert np.abs(error).max() < TOLERANCE_STD
        assert np.abs(estimate.state.std / wanted.std[-1] - 1).max() < TOLERANCE_STD


@pytest.mark.cover
@pytest.mark.parametrize("estimator", ESTIMATORS)
@pytest.mark.parametrize("name", SYSTEMS)
@pytest.mark.parametrize("horizon", [1, 6])
def test_constant_is_the_priors_covariance_around_the_prediction(
    name: str, horizon: int, estimator: str
) -> None:
    """x̄ of a window is the prediction made for its first stage from all stages before."""
    system = SYSTEMS[name]
    measurements = measured(system)
    config = config_for(estimator, horizon=horizon, arrival_cost="constant")
    predictions = [system.model.prior.mean]
    for k, estimate in enumerate(run_mhe(system.model, measurements, config, estimator)):
        first = max(0, k - horizon)
        window = measurements[first : k + 1]
        wanted = linear_batch(system, window, mean=predictions[first]).solve()
        assert estimate.window is not None
        error = (estimate.window.states - wanted.states) / wanted.std
        assert np.abs(error).max() < TOLERANCE_STD
        assert np.abs(estimate.state.std / wanted.std[-1] - 1).max() < TOLERANCE_STD
        if k + 1 < len(measurements):
            dt = measurements[k + 1].time_s - measurements[k].time_s
            predictions.append(system.F(dt) @ wanted.states[-1])


@pytest.mark.cover
@pytest.mark.parametrize("estimator", ESTIMATORS)
@pytest.mark.parametrize("arrival_cost", ["filtered", "smoothed"])
@pytest.mark.parametrize("copies", [1, 2])
@pytest.mark.parametrize("horizon", [1, 3])
def test_no_reading_is_counted_twice(
    copies: int, horizon: int, arrival_cost: str, estimator: str
) -> None:
    """A constant, prior variance 1, reading variance 1: after n readings 1 / (n + 1).

    A posterior used as the prior once more would give 1/3 where 1/2 is right.
    """
    system = random_walk_system(copies, q=1e-30, r=1.0, p0=1.0)
    rng = np.random.default_rng(7)
    measurements = system.simulate(np.arange(12.0), rng, missing=0.0)
    config = config_for(estimator, horizon=horizon, arrival_cost=arrival_cost)
    estimates = run_mhe(system.model, measurements, config, estimator)
    y = np.array([m.y for m in measurements])
    for n, estimate in enumerate(estimates, start=1):
        assert estimate.state.covariance.shape == (copies, copies)
        variance = np.diag(estimate.state.covariance)
        np.testing.assert_allclose(variance, 1 / (n + 1), rtol=1e-12)
        mean = y[:n].sum(axis=0) / (n + 1)
        np.testing.assert_allclose(estimate.state.mean, mean, rtol=0, atol=1e-10)


@pytest.mark.cover
@pytest.mark.parametrize("estimator", ESTIMATORS)
@pytest.mark.parametrize("horizon", [1, 4])
def test_filtered_settles_at_the_golden_ratio(horizon: int, estimator: str) -> None:
    """A random walk, q = r = 1: P⁺ = (√5 - 1) / 2, whatever the horizon."""
    system = random_walk_system(2, q=1.0, r=1.0, p0=5.0)
    rng = np.random.default_rng(8)
    measurements = system.simulate(np.arange(40.0), rng, missing=0.0)
    newest = run_mhe(system.model, measurements, config_for(estimator, horizon=horizon), estimator)[
        -1
    ]
    variance = np.diag(newest.state.covariance)
    np.testing.assert_allclose(variance, (np.sqrt(5) - 1) / 2, rtol=1e-12)


@pytest.mark.cover
@pytest.mark.parametrize("estimator", ESTIMATORS)
@pytest.mark.parametrize("horizon", [1, 4])
def test_smoothed_is_not_surer_than_the_filter(horizon: int, estimator: str) -> None:
    """A slow random walk: the careless version claims 0.7 of the true variance."""
    q, r, p0, steps = 0.01, 1.0, 5.0, 60
    system, rng = random_walk_system(1, q, r, p0), np.random.default_rng(9)
    measurements = system.simulate(np.arange(float(steps)), rng, missing=0.0)
    config = config_for(estimator, horizon=horizon, arrival_cost="smoothed")
    newest = run_mhe(system.model, measurements, config, estimator)[-1].state
    wanted = system.textbook(measurements)[-1]
    np.testing.assert_allclose(newest.covariance, wanted.covariance, rtol=1e-10)
    np.testing.assert_allclose(newest.mean, wanted.mean, rtol=0, atol=1e-9)
    careless = newest_variance(q, r, p0, horizon, steps)
    assert 0.65 < careless / wanted.covariance[0, 0] < 0.8


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_the_three_differ(estimator: str) -> None:
    """On the same readings the newest estimates are not the same: the name is used."""
    system = SYSTEMS["coupled"]
    measurements = measured(system)
    newest = [
        run_mhe(
            system.model,
            measurements,
            config_for(estimator, horizon=3, arrival_cost=name),
            estimator,
        )[-1]
        for name in ("none", "constant", "filtered")
    ]
    variances = [np.trace(estimate.state.covariance) for estimate in newest]
    assert variances[0] > 1.01 * variances[1] > 1.02 * variances[2]


@pytest.mark.parametrize(
    ("settings", "named"),
    [
        ({"horizon": 0}, "horizon"),
        ({"arrival_cost": "exact"}, "exact.*none, constant, filtered, smoothed"),
        ({"max_iterations": -1}, "max_iterations"),
        ({"deadline_s": 0.0}, "deadline_s"),
        ({"tolerance": 0.0}, "tolerance"),
    ],
)
def test_settings_out_of_range_are_refused(settings: dict[str, Any], named: str) -> None:
    with pytest.raises(InputError, match=named):
        MheConfig(**settings)
