"""The extended Kalman filter: the shared stage, linearised at its own mean."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from estimation.estimate import Estimate
from estimation.estimator import late_estimate, remarks
from estimation.kalman_stage import KalmanStage, Update, rows_present
from estimation.recording import Measurement
from estimation.status import Status
from models.errors import InputError
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel


@dataclass(frozen=True)
class EkfConfig:
    """Settings of the EKF.

    Parameters
    ----------
    gate_probability : a sensor's reading is dropped when its squared
        Mahalanobis distance to the prediction exceeds the χ² quantile of this
        probability; nearer to 1 drops less, None never drops
    """

    gate_probability: float | None = None

    def __post_init__(self) -> None:
        if self.gate_probability is not None and not 0 < self.gate_probability < 1:
            raise InputError(
                f"gate_probability is {self.gate_probability}, expected between 0 and 1"
            )


@dataclass(frozen=True, eq=False)
class EkfState:
    """Time (None before the first measurement) and Gaussian x_k|k, or the prior x_0|-1."""

    time_s: float | None
    gaussian: GaussianState


class Ekf:
    """Extended Kalman filter on a state-space model.

    Each step predicts to the measurement's time and updates with the readings
    it has, both linearised at the filter's current mean.

    References
    ----------
    Särkkä (2013), Bayesian Filtering and Smoothing, Algorithm 5.4.
    """

    name = "ekf"

    def __init__(self, model: StateSpaceModel, config: EkfConfig | None = None) -> None:
        self.model = model
        self.config = config or EkfConfig()
        self._stage = KalmanStage(model)

    def init(self) -> EkfState:
        """Return the state before the first measurement, from the model's prior."""
        return EkfState(None, self.model.prior)

    def step(self, state: EkfState, measurement: Measurement) -> tuple[EkfState, Estimate]:
        """Predict to the measurement's time and update."""
        time_s = measurement.time_s
        dt = 0.0 if state.time_s is None else time_s - state.time_s
        if state.time_s is not None and dt < 0:
            return state, late_estimate(self.model, state.time_s, state.gaussian)
        present, status = rows_present(self.model, measurement.y), Status.SOLVED
        predicted = self._stage.predict(state.gaussian, dt)
        update = self._stage.update(predicted, measurement.y, present)
        innovation = np.where(present, update.innovation, np.nan)
        innovation_covariance = update.innovation_covariance
        if (rejected := self._gated(update)).any():
            status |= Status.GATED
            update = self._stage.update(predicted, measurement.y, present & ~rejected)
        gaussian = update.state
        if not (np.isfinite(gaussian.mean).all() and np.isfinite(gaussian.covariance).all()):
            status |= Status.NOT_FINITE
            gaussian = predicted
        status |= remarks(self.model, gaussian, measurement.y, update.present)
        estimate = Estimate(time_s, gaussian, status, innovation, innovation_covariance)
        return EkfState(time_s, gaussian), estimate

    def _gated(self, update: Update) -> NDArray[np.bool_]:
        """Return the rows (n_r,) of sensors whose readings are too far off."""
        rejected = np.zeros(self.model.n_r, dtype=bool)
        if self.config.gate_probability is None:
            return rejected
        start = 0
        for sensor in self.model.sensors:
            rows = start + np.flatnonzero(update.present[start : start + sensor.n_r])
            start += sensor.n_r
            if len(rows) == 0:
                continue
            v, S = update.innovation[rows], update.innovation_covariance[np.ix_(rows, rows)]
            distance = v @ np.linalg.solve(S, v)
            rejected[rows] = distance > chi2.ppf(self.config.gate_probability, len(rows))
        return rejected
