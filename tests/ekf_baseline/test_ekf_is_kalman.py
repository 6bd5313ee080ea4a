"""On a linear model the EKF is the textbook Kalman filter."""

from __future__ import annotations

import numpy as np
import pytest

from ekf_baseline.ekf import Ekf
from estimation.recording import Measurement
from estimation.status import Status
from tests.linear_models import (
    constant_acceleration_system,
    coupled_system,
    irregular_times,
    random_walk_system,
)

SYSTEMS = {
    "one axis": constant_acceleration_system(1),
    "two axes": constant_acceleration_system(2),
    "coupled": coupled_system(3),
}
TOLERANCE_STD = 1e-10


@pytest.mark.cover
@pytest.mark.parametrize("name", SYSTEMS)
@pytest.mark.parametrize("missing", [0.0, 0.4])
def test_mean_and_covariance_are_the_textbooks(name: str, missing: float) -> None:
    system, rng = SYSTEMS[name], np.random.default_rng(11)
    measurements = system.simulate(irregular_times(150, rng), rng, missing)
    ekf = Ekf(system.model)
    state = ekf.init()
    for measurement, wanted in zip(measurements, system.textbook(measurements), strict=True):
        state, estimate = ekf.step(state, measurement)
        std = np.sqrt(np.diag(wanted.covariance))
        error = (estimate.state.mean - wanted.mean) / std
        error_P = (estimate.state.covariance - wanted.covariance) / np.outer(std, std)
        assert np.abs(error).max() < TOLERANCE_STD
        assert np.abs(error_P).max() < TOLERANCE_STD
        assert estimate.status is (Status.SOLVED if len(wanted.rows) else Status.NO_READING)
        assert estimate.time_s == measurement.time_s


@pytest.mark.parametrize("name", SYSTEMS)
def test_innovations_are_the_textbooks_and_nan_where_missing(name: str) -> None:
    system, rng = SYSTEMS[name], np.random.default_rng(12)
    measurements = system.simulate(irregular_times(60, rng), rng, 0.4)
    ekf = Ekf(system.model)
    state = ekf.init()
    for measurement, wanted in zip(measurements, system.textbook(measurements), strict=True):
        state, estimate = ekf.step(state, measurement)
        rows, missing = wanted.rows, np.isnan(measurement.y)
        S = estimate.innovation_covariance[np.ix_(rows, rows)]
        std = np.sqrt(np.diag(wanted.innovation_covariance))
        error = (estimate.innovation[rows] - wanted.innovation) / std
        error_S = (S - wanted.innovation_covariance) / np.outer(std, std)
        assert np.abs(error).max(initial=0.0) < TOLERANCE_STD
        assert np.abs(error_S).max(initial=0.0) < TOLERANCE_STD
        np.testing.assert_array_equal(np.isnan(estimate.innovation), missing)


def test_two_readings_at_one_time_are_one_reading_of_both() -> None:
    system, rng = SYSTEMS["coupled"], np.random.default_rng(13)
    times = irregular_times(30, rng)
    together = system.simulate(times, rng, missing=0.0)
    ekf = Ekf(system.model)
    one = two = ekf.init()
    for measurement in together:
        first, second = measurement.y.copy(), measurement.y.copy()
        first[1:], second[:1] = np.nan, np.nan
        one, _ = ekf.step(one, measurement)
        two, _ = ekf.step(two, Measurement(measurement.time_s, first))
        two, _ = ekf.step(two, Measurement(measurement.time_s, second))
        error = (one.gaussian.mean - two.gaussian.mean) / one.gaussian.std
        assert np.abs(error).max() < TOLERANCE_STD
    assert np.linalg.norm(one.gaussian.mean) > 0.01


def test_a_model_with_one_state_works() -> None:
    """Steady state of a random walk, q = r = 1: P⁺ = (√5 - 1) / 2, the golden ratio."""
    system = random_walk_system(1, q=1.0, r=1.0, p0=1.0)
    ekf = Ekf(system.model)
    state = ekf.init()
    for k in range(60):
        state, estimate = ekf.step(state, Measurement(float(k), np.array([0.5])))
    assert estimate.state.covariance.shape == (1, 1)
    assert estimate.state.covariance[0, 0] == pytest.approx((np.sqrt(5) - 1) / 2, abs=1e-12)
