"""The Kalman stage over a window that is solved: its Gauss-Newton covariance and innovation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from estimation.kalman_stage import KalmanStage, Prediction, Update
from mhe.config import WindowConfig
from mhe.reference.state import MheState
from mhe.stage_functions import carry_function
from mhe.trajectory import Trajectory
from mhe.weights import Weights
from models.arrays import Array
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel


class ForwardPass:
    """Updates and predictions, linearised at a trajectory.

    Parameters
    ----------
    stage, weights : of the estimator
    """

    def __init__(
        self, model: StateSpaceModel, config: WindowConfig, stage: KalmanStage, weights: Weights
    ) -> None:
        self._model, self._has_losses = model, config.has_losses
        self._stage, self._weights, self._carry = stage, weights, carry_function(model)

    def newest(
        self,
        window: MheState,
        trajectory: Trajectory,
        updates: list[Update],
        predictions: list[Prediction],
    ) -> tuple[Update, GaussianState]:
        """Return the newest update and state, of what `run` returns."""
        update, gaussian = updates[-1], updates[-1].state
        if self._has_losses:  # told is the innovation itself, not its weighed share
            x, y = trajectory.states[-1], window.measurements[-1].y
            first = self._carried(window.prior, x)[0]
            told = self._stage.update(predictions[-1].state if predictions else first, y, x_lin=x)
            v, S = told.innovation, told.innovation_covariance
            update = replace(update, innovation=v, innovation_covariance=S)
        return update, GaussianState(trajectory.states[-1], gaussian.covariance)

    def run(
        self, window: MheState, trajectory: Trajectory
    ) -> tuple[list[Update], list[Prediction]]:
        """Run the Kalman stage over the window, linearised at the trajectory."""
        updates, predictions = list[Update](), list[Prediction]()
        gaussian, away = self._carried(window.prior, trajectory.states[0])
        times = [m.time_s for m in window.measurements]
        for k, measurement in enumerate(window.measurements):
            if k:
                x, w = trajectory.states[k - 1], trajectory.noises[k - 1]
                scale, _ = self._weights.noises(w)
                dt = times[k] - times[k - 1]
                inputs = self._model.step_inputs(window.measurements[k - 1].y, measurement.y)
                predictions.append(self._stage.predict(gaussian, dt, x, w, scale, inputs=inputs))
                gaussian = predictions[-1].state
            x = trajectory.states[k]
            rows, _ = self._weights.readings(x, measurement.y)
            y = measurement.y
            updates.append(self._stage.update(gaussian, y, rows, x, None if k else away))
            gaussian = updates[-1].state
        return updates, predictions

    def _carried(self, prior: GaussianState, x: Array) -> tuple[GaussianState, Array]:
        """Return a prior along the tangent space at x, and its mean's deviation from x."""
        d = self._stage.difference(x, prior.mean)
        if self._carry is None:
            return prior, -d
        J = np.asarray(self._carry(prior.mean, d, x))
        return GaussianState(prior.mean, J @ prior.covariance @ J.T), -J @ d
