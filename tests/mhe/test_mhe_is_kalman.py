"""On a linear model every MHE is the Kalman filter, for every N: `mhe-rti` in one pass.

With a filtered and with a smoothed arrival cost: both eliminate the dropped stage.
"""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from estimation.status import Status
from tests.configs import config_for
from tests.linear_models import (
    constant_acceleration_system,
    coupled_system,
    irregular_times,
    random_walk_system,
)
from tests.mhe.runs import ESTIMATORS, REAL_TIME, run_mhe

SYSTEMS = {
    "one axis": constant_acceleration_system(1),
    "two axes": constant_acceleration_system(2, density=20.0),
    "coupled": coupled_system(3),
    "walk": random_walk_system(2, q=1.0, r=0.3, p0=4.0),
}


EXACT_ARRIVALS = ("filtered", "smoothed")
CASES = [
    *(("mhe-ipopt", "filtered", horizon) for horizon in (1, 5, 20)),
    pytest.param("mhe-ipopt", "filtered", 50, marks=pytest.mark.slow),
    *(("mhe-ipopt", "smoothed", horizon) for horizon in (1, 5)),
    *itertools.product(REAL_TIME, EXACT_ARRIVALS, (1, 5, 20, 50)),
]
TOLERANCE_STD = {"mhe-ipopt": 1e-9, "mhe-rti": 1e-10, "mhe": 1e-10}


@pytest.mark.cover
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=() if name in ("one axis", "coupled") else pytest.mark.slow)
        for name in SYSTEMS
    ],
)
@pytest.mark.parametrize(("estimator", "arrival_cost", "horizon"), CASES)
def test_every_step_is_the_textbook_filters(
    name: str, estimator: str, arrival_cost: str, horizon: int
) -> None:
    system, rng = SYSTEMS[name], np.random.default_rng(31)
    measurements = system.simulate(irregular_times(70, rng), rng, missing=0.35)
    config = config_for(estimator, horizon=horizon, arrival_cost=arrival_cost)
    estimates = run_mhe(system.model, measurements, config, estimator)
    posteriors = system.textbook(measurements)
    missing_rows = 0
    for measurement, estimate, wanted in zip(measurements, estimates, posteriors, strict=True):
        x, P = wanted.mean, wanted.covariance
        std, tolerance = np.sqrt(np.diag(P)), TOLERANCE_STD[estimator]
        assert np.abs((estimate.state.mean - x) / std).max() < tolerance
        assert np.abs((estimate.state.covariance - P) / np.outer(std, std)).max() < tolerance
        assert estimate.status is (Status.SOLVED if len(wanted.rows) else Status.NO_READING)
        np.testing.assert_array_equal(np.isnan(estimate.innovation), np.isnan(measurement.y))
        missing_rows += int(np.isnan(measurement.y).sum())
        if estimator == "mhe-rti":
            assert estimate.iterations == 1
    assert missing_rows > 20


@pytest.mark.cover
@pytest.mark.parametrize("estimator", ESTIMATORS)
@pytest.mark.parametrize("horizon", [1, 5])
def test_innovations_are_the_filters(horizon: int, estimator: str) -> None:
    """The newest stage's innovation on a linear model is y - H x⁻, its covariance S."""
    system, rng = SYSTEMS["coupled"], np.random.default_rng(32)
    measurements = system.simulate(irregular_times(25, rng), rng, missing=0.3)
    estimates = run_mhe(
        system.model, measurements, config_for(estimator, horizon=horizon), estimator
    )
    for estimate, wanted in zip(estimates, system.textbook(measurements), strict=True):
        rows = wanted.rows
        std = np.sqrt(np.diag(wanted.innovation_covariance))
        S = estimate.innovation_covariance[np.ix_(rows, rows)]
        error_S = (S - wanted.innovation_covariance) / np.outer(std, std)
        assert np.abs((estimate.innovation[rows] - wanted.innovation) / std).max(initial=0) < 1e-9
        assert np.abs(error_S).max(initial=0) < 1e-9


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_window_slides_over_the_last_stages(estimator: str) -> None:
    system, rng = SYSTEMS["one axis"], np.random.default_rng(33)
    measurements = system.simulate(irregular_times(12, rng), rng)
    estimates = run_mhe(system.model, measurements, config_for(estimator, horizon=5), estimator)
    times = [measurement.time_s for measurement in measurements]
    for k, estimate in enumerate(estimates):
        assert estimate.window is not None
        np.testing.assert_array_equal(estimate.window.time_s, times[max(0, k - 5) : k + 1])
        np.testing.assert_array_equal(estimate.window.states[-1], estimate.state.mean)
