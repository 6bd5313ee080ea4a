"""filterpy's extended Kalman filter on the same stream.

The transition of these models is linear and the sample time constant, so F and Q are given
once; h and H are this project's, brought in three ways:

- ``calls``: CasADi functions called as CasADi documents it, results made NumPy arrays;
- ``buffers``: compiled, called through fixed buffers;
- ``arrays``: evaluated outside the clock. What is timed is filterpy's own algebra.
"""

from __future__ import annotations

import numpy as np

from estimation.derivatives import Derivatives
from models.state_space import StateSpaceModel
from suites.speed.contender import ContenderAbsentError, RaceOutcome, peer
from suites.speed.filterpy_readings import READINGS
from suites.speed.samples import Sample


class Filterpy:
    """filterpy's predict and update, one sample at a time.

    Parameters
    ----------
    dt : constant sample time, s
    readings : a key of `suites.speed.filterpy_readings.READINGS`
    """

    def __init__(self, model: StateSpaceModel, example: Sample, dt: float, readings: str) -> None:
        kalman, self.version = peer("filterpy.kalman", "filterpy")
        if len({sensor.rate_hz for sensor in model.sensors}) > 1:
            raise ContenderAbsentError("filterpy has no missing rows")
        self._readings = READINGS[readings](model)
        self._filter = kalman.ExtendedKalmanFilter(model.n_x, model.n_y)
        self._filter.F, G = Derivatives(model).of_step(model.prior.mean, dt)
        self._filter.Q, self._filter.R = G @ G.T, np.diag(model.noise_std**2)
        self._x, self._P = model.prior.mean, model.prior.covariance

    def prepare(self, item: Sample) -> None:
        """Set the filter back to the state before this sample."""
        self._y, self._first = item.measurement.y, item.index == 0
        self._filter.x, self._filter.P = self._x, self._P
        self._readings.expect(self._x if self._first else self._filter.F @ self._x)

    def solve(self) -> None:
        """Predict, update."""
        if not self._first:
            self._filter.predict()
        self._filter.update(self._y, self._readings.H, self._readings.h)

    def outcome(self) -> RaceOutcome:
        """Go on to the next sample."""
        self._x, self._P = self._filter.x, self._filter.P
        return RaceOutcome(True, self._x)
