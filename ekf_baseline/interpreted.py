"""The loop of ekf_baseline/filter.c in Python, for machines without a C compiler."""

from __future__ import annotations

import time
from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from estimation.estimator import remarks
from estimation.inputs import with_inputs
from estimation.kalman_stage import KalmanStage, Update, rows_present
from estimation.layout import Layout
from estimation.outputs import derived_outputs
from estimation.report import report
from estimation.rest_detector import RestDetector
from estimation.result import checked_input, result_layout, stepped
from estimation.status import Status
from estimation.stored import restored, store
from models.arrays import Array
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel

FIRST: Mapping[str, float] = MappingProxyType({"FIRST_UPDATES": 20, "FIRST_SETTLED": 1e-3})
"""Macros of filter.c: how often an update with first readings is linearised anew at most, and how
far, in standard deviations, its posterior then may be from where it was linearised. Starts wrong by
up to 90° and told so take 3 to 12, by 170° some the whole number."""


class InterpretedFilter:
    """The EKF's engine around the interpreted stage; see `estimation.result.Engine`.

    Parameters
    ----------
    gate : (n_r + 1,) limits of the squared distance by number of rows; None has no gate
    """

    def __init__(self, model: StateSpaceModel, memory: Layout, gate: Array | None) -> None:
        self.memory, self.result = memory, result_layout(model)
        self._model, self._gate = model, gate
        self._stage, self._derived = KalmanStage(model), derived_outputs(model)
        self._rest = RestDetector(model)

    @np.errstate(over="ignore", invalid="ignore")  # an absurd reading: the status says it
    def step(self, given: Array, time_s: float, y: Array) -> tuple[Array, Array]:
        """Return the state after a measurement and what the step says; `given` stays."""
        start, model, at = time.perf_counter(), self._model, self.memory
        _, y = checked_input(at, model, given, np.asarray(time_s), y)
        before = float(at.view(given, "time_s"))
        state = restored(at.view(given, "mean"), at.view(given, "covariance"))
        if time_s < before:
            return given.copy(), report(
                self.result, self._derived, before, state, None, Status.LATE, 0
            )
        is_first = bool(np.isnan(before))
        dt = 0.0 if is_first else time_s - before
        y = with_inputs(model, at.view(given, "inputs"), y)
        known = y[model.n_y :] if is_first else at.view(given, "inputs")
        rest, y = self._rest.step(self._rest.part(at, given), dt, y)
        present, status = rows_present(model, y), Status.SOLVED
        inputs = (known, y[model.n_y :]) if model.n_u else ()
        predicted = self._stage.predict(state, dt, inputs=inputs).state
        first = update = self._stage.update(predicted, y, present)
        if (rejected := self._gated(update)).any():
            status |= Status.GATED
            update = self._stage.update(predicted, y, present & ~rejected)
        seen, updates, gaussian = self._seen(given, update), 1, update.state
        if (seen != at.view(given, "seen")).any():
            gaussian, updates = self._settled(predicted, y, update)
        if not _is_finite(gaussian):
            status |= Status.NOT_FINITE
            gaussian = predicted if _is_finite(predicted) else state  # the last rung
            seen = at.view(given, "seen")
        status |= remarks(model, gaussian, y, update.present) | self._stage.remark()
        result = report(self.result, self._derived, time_s, gaussian, first, status, updates)
        memory = np.empty(at.size)
        at.view(memory, "time_s")[...] = time_s
        at.view(memory, "mean")[:] = gaussian.mean
        store(gaussian, at.view(memory, "covariance"))
        at.view(memory, "seen")[:] = seen
        at.view(memory, "inputs")[:] = y[model.n_y :]
        self._rest.part(at, memory)[:] = rest
        self.result.view(result, "step_time_s")[...] = time.perf_counter() - start
        return memory, result

    def batch(self, given: Array, time_s: Array, y: Array) -> tuple[Array, Array]:
        """Return the state after n measurements and what each step says, (n, result.size)."""
        return stepped(self, self._model, given, time_s, y)

    def _seen(self, given: Array, update: Update) -> Array:
        """Return which sensors' readings were ever used (n_sensors,), with those of an update."""
        seen = self.memory.view(given, "seen").copy()
        used, start = update.present & self._model.measured_rows, 0
        for i, sensor in enumerate(self._model.sensors):
            seen[i] = max(seen[i], float(used[start : start + sensor.n_r].any()))
            start += sensor.n_r
        return seen

    def _settled(
        self, predicted: GaussianState, y: Array, update: Update
    ) -> tuple[GaussianState, int]:
        """Return an update linearised at its own posterior, and how many it took."""
        state, present, updates = update.state, update.present, 1
        while updates < FIRST["FIRST_UPDATES"]:
            d_minus = -self._stage.difference(state.mean, predicted.mean)
            again = self._stage.update(predicted, y, present, state.mean, d_minus)
            if not np.isfinite(again.deviation).all():
                break
            largest = np.fmax.reduce(np.abs(again.deviation) / state.std)  # 0 / 0 says nothing
            if not largest > FIRST["FIRST_SETTLED"]:
                break
            state, updates = again.state, updates + 1
        return state, updates

    def _gated(self, update: Update) -> NDArray[np.bool_]:
        """Return the rows (n_r,) of sensors whose readings are too far off."""
        rejected = np.zeros(self._model.n_r, dtype=bool)
        if self._gate is None:
            return rejected
        start = 0
        for sensor in self._model.sensors:
            rows = start + np.flatnonzero(update.present[start : start + sensor.n_r])
            start += sensor.n_r
            if len(rows) == 0:
                continue
            v, S = update.innovation[rows], update.innovation_covariance[np.ix_(rows, rows)]
            rejected[rows] = v @ np.linalg.solve(S, v) > self._gate[len(rows)]
        return rejected


def _is_finite(gaussian: GaussianState) -> bool:
    return bool(np.isfinite(gaussian.mean).all() and np.isfinite(gaussian.covariance).all())
