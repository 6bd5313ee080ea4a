"""The Kalman stage over a window that is solved: its Gauss-Newton covariance and innovation."""

from __future__ import annotations

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

    def told(
        self,
        window: MheState,
        trajectory: Trajectory,
        updates: list[Update],
        predictions: list[Prediction],
        k: int,
    ) -> Update:
        """Return the update of stage k, of what `run` returns, with the innovation itself."""
        if not self._has_losses:
            return updates[k]
        x, y = trajectory.states[k], window.measurements[k].y
        at = predictions[k - 1].state if k else self._carried(window.prior, x)[0]
        return self._stage.update(at, y, x_lin=x)

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
