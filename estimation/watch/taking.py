"""A row is taken: without what is stuck, an outlier, or left out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from estimation.estimate import Estimate
from estimation.inputs import rows_with_inputs
from estimation.recording import Measurement
from estimation.watch.livelier import MotionLevels
from estimation.watch.replay import Replays
from estimation.watch.state import RETRY_S, LeftOut, WatchState
from estimation.watch.statistics import Statistics
from models.arrays import Array
from models.state_space import StateSpaceModel

STUCK_S = 0.3
"""So long a gyroscope is stuck before it is left out."""


class Taking:
    """Gives rows to an estimator that is watched, and their innovations to the statistics."""

    def __init__(
        self,
        model: StateSpaceModel,
        levels: MotionLevels,
        statistics: Statistics,
        replays: Replays,
    ) -> None:
        self._model, self._levels = model, levels
        self._statistics, self._replays = statistics, replays

    def with_inputs(self, state: WatchState, y: Array) -> Array:
        """Return a copy of a row, with the inputs that were known before where it has none."""
        if not self._model.n_u:
            return y.copy()  # it is kept, and whoever gave it may write the next one there
        [row] = rows_with_inputs(self._model, [y], last=state.past.newest)
        return row

    def taken(
        self, state: WatchState, t: float, y: Array, stuck: frozenset[int]
    ) -> tuple[WatchState, Estimate, frozenset[int]]:
        """Take a row; what is an outlier is not used. `state.memory` is changed in place."""
        estimator, without = self._levels[state.level], self._replays.without
        skipped = stuck | state.left_out
        inner, estimate = estimator.step(state.inner, Measurement(t, without(y, skipped)))
        z, far = self._distances(estimate)
        outliers = frozenset[int]()
        if t >= state.calm_s:
            outliers = frozenset(self._statistics.outliers(state.memory, far))
        if outliers:
            given = without(y, skipped | outliers)
            inner, estimate = estimator.step(state.inner, Measurement(t, given))
            for each in self._statistics.sensors:
                if each.index in outliers:
                    for row in each.rows:
                        z[row] = np.nan
        self._statistics.take(state.memory, z)
        self._statistics.count_outliers(state.memory, far, outliers)
        return replace(state, inner=inner), estimate, outliers

    def stuck_long(self, state: WatchState, t: float, sensor: int) -> WatchState:
        """Leave out a gyroscope that has been stuck so long that its return is no trifle.

        Without it an attitude is soon worse than it seems. Without an accelerometer it is not.
        """
        if not self._model.sensors[sensor].reads_rate:
            return state
        since_s = t
        for row in reversed(state.past.rows):
            if sensor in row.stuck:
                since_s = row.time_s
            elif self._replays.has_reading(row.y, sensor):
                break
        if t - since_s < STUCK_S:
            return state
        return replace(state, out=(*state.out, LeftOut(sensor, t + RETRY_S)))

    def _distances(self, estimate: Estimate) -> tuple[list[float], list[float]]:
        S = estimate.innovation_covariance
        return self._statistics.distances(estimate.innovation.tolist(), S.tolist())
