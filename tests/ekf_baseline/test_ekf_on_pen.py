"""The EKF on the pen against one written in NumPy: formulas by hand, rows deleted, Joseph."""

from __future__ import annotations

import functools

import numpy as np
import pytest

from ekf_baseline.ekf import Ekf
from estimation.kalman_stage import rows_present
from estimation.recording import Measurement
from models.arrays import Array
from models.state_space import StateSpaceModel
from tests.estimation import pens
from tests.references import kalman
from tests.references.batch import white_jerk_step

TOLERANCE_STD = 1e-10
FIRST_UPDATES, FIRST_SETTLED = 20, 1e-3
SETTLING_UPDATES, SETTLING_S = 5, 0.3


def whitened_reading(measurement: Measurement, x: Array) -> tuple[Array, Array]:
    """Residual of the rows that are there, over their deviations, and its H by complex steps."""
    readings = pens.pen_batch([measurement]).readings
    H = [-readings((x + 1e-100j * e)[None]).imag / 1e-100 for e in np.eye(len(x))]
    return readings(x[None]), np.array(H).T.reshape(-1, len(x))


def sensors_of(model: StateSpaceModel, measurement: Measurement) -> set[str]:
    """Return the names of the sensors that have any row that is there."""
    present, start, found = rows_present(model, measurement.y), 0, set()
    for sensor in model.sensors:
        if present[start : start + sensor.n_r].any():
            found.add(sensor.name)
        start += sensor.n_r
    return found


@pytest.mark.parametrize("seed", [3, 5])
def test_every_step_is_that_of_a_filter_in_numpy(seed: int) -> None:
    run = pens.draw_pen_run(60, seed)
    ekf = Ekf(run.model)
    state, x, P = ekf.init(), pens.PRIOR_MEAN, np.diag(pens.PRIOR_STD**2)
    seen: set[str] = set()
    settling_s = 0.0
    for k, measurement in enumerate(run.measurements):
        if k:
            dt = measurement.time_s - run.measurements[k - 1].time_s
            F, G = white_jerk_step(dt, pens.DENSITIES)
            x, P = kalman.predict(x, P, F, G @ G.T)
            settling_s = max(settling_s - dt, 0.0)
        now = sensors_of(run.model, measurement)
        most = SETTLING_UPDATES if settling_s > 0 else 1
        if now - seen:
            settling_s, most = SETTLING_S, FIRST_UPDATES
        seen |= now
        wanted = kalman.iterated(
            x, P, functools.partial(whitened_reading, measurement), FIRST_SETTLED, most
        )
        x, P = wanted.mean, wanted.covariance
        state, estimate = ekf.step(state, measurement)
        std = np.sqrt(np.diag(P))
        error_P = (estimate.state.covariance - P) / np.outer(std, std)
        difference = estimate.state.mean - x
        difference[3:5] = np.angle(np.exp(1j * difference[3:5]))  # x is not wrapped
        assert np.abs(difference / std).max() < TOLERANCE_STD
        assert np.abs(error_P).max() < TOLERANCE_STD

        rows = np.flatnonzero(~np.isnan(estimate.innovation))
        noise = run.model.noise_std[rows]
        S = estimate.innovation_covariance[np.ix_(rows, rows)] / np.outer(noise, noise)
        spread = np.sqrt(np.diag(wanted.innovation_covariance))
        error_S = (S - wanted.innovation_covariance) / np.outer(spread, spread)
        error = (estimate.innovation[rows] / noise - wanted.innovation) / spread
        assert np.abs(error).max() < TOLERANCE_STD
        assert np.abs(error_S).max() < TOLERANCE_STD
