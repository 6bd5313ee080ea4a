"""Gating: an outlier of one sensor is dropped and flagged, the other sensors are used."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import chi2

from ekf_baseline.ekf import Ekf, EkfConfig, EkfState
from estimation.recording import Measurement
from estimation.status import Status
from models.arrays import Array
from models.errors import InputError
from tests.linear_models import LinearSystem, coupled_system
from tests.references import kalman

SYSTEM = coupled_system(5)
PROBABILITY = 0.99


def settled(system: LinearSystem, config: EkfConfig | None = None) -> tuple[Ekf, EkfState]:
    """An EKF some steps into a run without outliers, with its state."""
    rng = np.random.default_rng(3)
    plain, ekf = Ekf(system.model), Ekf(system.model, config)
    state = plain.init()
    for measurement in system.simulate(np.arange(1, 20) * 0.05, rng, missing=0.0):
        state, _ = plain.step(state, measurement)
    return ekf, state


def prediction(state: EkfState, dt: float) -> tuple[Array, Array]:
    mean, covariance = state.gaussian.mean, state.gaussian.covariance
    return kalman.predict(mean, covariance, SYSTEM.F(dt), SYSTEM.Q(dt))


def test_the_outlier_is_dropped_and_the_other_sensor_used() -> None:
    ekf, state = settled(SYSTEM, EkfConfig(gate_probability=PROBABILITY))
    x, P = prediction(state, 0.05)
    good = SYSTEM.H @ x + np.array([0.05, -0.03, 0.1])
    bad = good + np.array([0.0, 40.0, 0.0])
    _, estimate = ekf.step(state, Measurement(1.0, bad))
    only_first = np.where([True, False, False], good, np.nan)
    wanted = kalman.update(x, P, only_first, SYSTEM.H, SYSTEM.R)
    error = (estimate.state.mean - wanted.mean) / np.sqrt(np.diag(wanted.covariance))
    assert np.abs(error).max() < 1e-10
    assert estimate.status is Status.GATED
    assert estimate.status.is_solved


def test_without_a_gate_the_outlier_is_used() -> None:
    ekf, state = settled(SYSTEM)
    x, P = prediction(state, 0.05)
    bad = SYSTEM.H @ x + np.array([0.0, 40.0, 0.0])
    _, estimate = ekf.step(state, Measurement(1.0, bad))
    wanted = kalman.update(x, P, bad, SYSTEM.H, SYSTEM.R)
    error = (estimate.state.mean - wanted.mean) / np.sqrt(np.diag(wanted.covariance))
    assert np.abs(error).max() < 1e-10
    assert estimate.status is Status.SOLVED


@pytest.mark.parametrize(("factor", "dropped"), [(0.999, False), (1.001, True)])
@pytest.mark.parametrize("missing_row", [None, 2])
def test_the_gate_is_the_quantile_of_the_rows_that_are_there(
    factor: float, dropped: bool, missing_row: int | None
) -> None:
    ekf, state = settled(SYSTEM, EkfConfig(gate_probability=PROBABILITY))
    x, P = prediction(state, 0.05)
    rows = [row for row in (1, 2) if row != missing_row]
    H, R = SYSTEM.H[rows], SYSTEM.R[np.ix_(rows, rows)]
    S = H @ P @ H.T + R
    direction = np.linalg.cholesky(S)[:, 0]  # squared Mahalanobis length 1
    y = SYSTEM.H @ x
    y[rows] += factor * np.sqrt(chi2.ppf(PROBABILITY, len(rows))) * direction
    if missing_row is not None:
        y[missing_row] = np.nan
    _, estimate = ekf.step(state, Measurement(1.0, y))
    assert (Status.GATED in estimate.status) == dropped


def test_a_dropped_reading_keeps_its_true_innovation() -> None:
    """Zero would read as a perfect prediction and flatter every consistency statistic."""
    ekf, state = settled(SYSTEM, EkfConfig(gate_probability=PROBABILITY))
    x, P = prediction(state, 0.05)
    deviation = np.array([0.05, 40.0, 0.1])
    _, estimate = ekf.step(state, Measurement(1.0, SYSTEM.H @ x + deviation))
    S = SYSTEM.H @ P @ SYSTEM.H.T + SYSTEM.R
    np.testing.assert_allclose(estimate.innovation, deviation, rtol=0, atol=1e-9)
    np.testing.assert_allclose(estimate.innovation_covariance, S, rtol=1e-9)


def test_all_sensors_dropped_leaves_the_prediction() -> None:
    ekf, state = settled(SYSTEM, EkfConfig(gate_probability=PROBABILITY))
    x, P = prediction(state, 0.05)
    _, estimate = ekf.step(state, Measurement(1.0, SYSTEM.H @ x + 50.0))
    std = np.sqrt(np.diag(P))
    assert np.abs((estimate.state.mean - x) / std).max() < 1e-10
    assert np.abs((estimate.state.covariance - P) / np.outer(std, std)).max() < 1e-10
    assert Status.GATED in estimate.status


@pytest.mark.parametrize("probability", [0.0, 1.0, -0.1, 1.5, float("nan")])
def test_a_probability_outside_0_and_1_is_refused(probability: float) -> None:
    with pytest.raises(InputError, match="gate_probability"):
        EkfConfig(gate_probability=probability)
