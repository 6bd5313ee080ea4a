"""The error against frames that were left out, of a run that comes in parts."""

from __future__ import annotations

import numpy as np

from estimation.arrivals import arrival_of
from estimation.estimate import EstimateHistory
from estimation.recording import Recording
from estimation.tallies import Mean
from models.arrays import Array
from models.sensor_model import SensorModel
from models.state_space import StateSpaceModel
from recordings.thinning import LeftOutError, residual_squares, rms_by_unit


class LeftOutInParts:
    """`recordings.thinning.left_out_error` of a run whose parts pass by."""

    def __init__(self, model: StateSpaceModel, sensor: SensorModel) -> None:
        self._model, self._sensor = model, sensor
        self._begins_s, self._told_first_s = np.inf, np.inf
        self._means = [Mean() for _ in range(sensor.n_r)]
        self._times, self._frames = np.zeros(0), np.zeros((0, sensor.n_y))
        self._newest: tuple[Array, Array] = (np.zeros(0), np.zeros((0, model.n_x)))

    def read(self, recorded: Recording, used: Recording | None) -> None:
        """Keep the frames of the next part that were left out."""
        times, frames = recorded.sensor(self._sensor.name)
        if used is not None:
            given = used.sensor(self._sensor.name)[0]
            if len(given) and self._begins_s == np.inf:
                arrives = arrival_of(used.time_s, used.arrivals, self._sensor)
                self._begins_s = float(arrives[used.time_s == given[0]][0])
            left = ~np.isin(times, given)
            times, frames = times[left], frames[left]
        # What was captured before the first frame arrived does not count.
        counts = times >= self._begins_s
        self._times = np.append(self._times, times[counts])
        self._frames = np.concatenate([self._frames, frames[counts]])

    def take(self, told: EstimateHistory) -> None:
        """Judge by the next part of a run the frames until its last instant."""
        if not len(told):
            return
        told = told.first_told()
        self._told_first_s = min(self._told_first_s, float(told.time_s[0]))
        time_s = np.append(self._newest[0], told.time_s)
        mean = np.concatenate([self._newest[1], told.mean])
        self._newest = time_s[-1:], mean[-1:]
        now = self._times <= time_s[-1]
        counts = now & (self._times >= self._told_first_s)
        if counts.any():
            frames = self._times[counts], self._frames[counts]
            squares = residual_squares(self._model, self._sensor, *frames, time_s=time_s, mean=mean)
            for mean_of_row, row in zip(self._means, squares, strict=True):
                mean_of_row.add(row)
        self._times, self._frames = self._times[~now], self._frames[~now]

    def result(self) -> LeftOutError | None:
        """Return the error of all; None where no frame was left out after the first estimate."""
        if not self._means[0].count:
            return None
        means = np.array([mean.value for mean in self._means])
        return LeftOutError(self._means[0].count, rms_by_unit(self._sensor, means))
