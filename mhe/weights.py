"""The scales by which the losses of a configuration weigh readings and noises."""

from __future__ import annotations

from estimation.function_call import FunctionCall
from estimation.kalman_stage import rows_present, without_gaps
from mhe.config import WindowConfig
from mhe.stage_functions import measure_function, shake_function
from models.arrays import Array
from models.state_space import StateSpaceModel


class Weights:
    """Scales of rows and noises at a point, for a solver that is not compiled.

    Without losses a row counts fully where it has a reading and a noise has its own
    standard deviation.
    """

    def __init__(self, model: StateSpaceModel, config: WindowConfig) -> None:
        self._model, self._noise_threshold = model, config.noise_threshold
        self._thresholds = config.thresholds([sensor.name for sensor in model.sensors])
        self._measure = FunctionCall(measure_function(model))
        self._shake = FunctionCall(shake_function(model))

    def readings(self, x: Array, y: Array) -> tuple[Array, float]:
        """Return the scales (n_r,) of readings y (n_row,) at x, NaN where missing, and cost."""
        present = rows_present(self._model, y)
        rows, cost = self._measure(x, without_gaps(y), present, self._thresholds)
        return rows, float(cost[0])

    def noises(self, w: Array) -> tuple[Array, float]:
        """Return the scales (n_w,) of noises w, and their cost."""
        scales, cost = self._shake(w, self._noise_threshold)
        return scales, float(cost[0])
