"""The loop of ekf_baseline/filter.c in Python, for machines without a C compiler."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from ekf_baseline.outliers import OUTLIERS, needed, squared_distance
from estimation.estimator import remarks
from estimation.inputs import with_inputs
from estimation.kalman_stage import KalmanStage, Update, rows_present
from estimation.layout import Layout
from estimation.outputs import derived_outputs
from estimation.report import report
from estimation.rest_detector import RestDetector
from estimation.result import checked_input, result_layout, stepped
from estimation.square_roots import kept
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
    gate : limits of squared distances, see `ekf_baseline.outliers.gate_limits`; None has no gate
    huber : (n_sensors,) thresholds of bounded influence; None has none
    """

    def __init__(
        self, model: StateSpaceModel, memory: Layout, gate: Array | None, huber: Array | None
    ) -> None:
        self.memory, self.result = memory, result_layout(model)
        self._model, self._gate, self._huber = model, gate, huber
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
        used, S = present.astype(float), update.innovation_covariance
        doubt, doubted, prior = at.view(given, "doubt").copy(), False, predicted
        if self._gate is not None:
            opens = self._gated(given, update, used, doubt, dt)
            if (used != present).any():
                status |= Status.GATED
            doubted = bool((opens > 0).any())
            prior, S = self._widened(predicted, y, update, opens)
        if self._huber is not None:
            self._bound(given, update, S, used)
        if doubted or (used != present).any():
            update = self._stage.update(prior, y, used)
        seen, updates, gaussian = self._seen(given, update), 1, update.state
        if doubted or (seen != at.view(given, "seen")).any():
            gaussian, updates = self._settled(prior, y, update, used)
        if not _is_finite(gaussian):
            status |= Status.NOT_FINITE
            gaussian = prior if _is_finite(prior) else state  # the last rung
            seen, doubt = at.view(given, "seen"), at.view(given, "doubt")
        status |= remarks(model, gaussian, y, update.present) | self._stage.remark()
        result = report(self.result, self._derived, time_s, gaussian, first, status, updates)
        memory = np.empty(at.size)
        at.view(memory, "time_s")[...] = time_s
        at.view(memory, "mean")[:] = gaussian.mean
        store(gaussian, at.view(memory, "covariance"))
        at.view(memory, "seen")[:] = seen
        at.view(memory, "doubt")[:] = doubt
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
        self, predicted: GaussianState, y: Array, update: Update, used: Array
    ) -> tuple[GaussianState, int]:
        """Return an update linearised at its own posterior, and how many it took."""
        state, updates = update.state, 1
        while updates < FIRST["FIRST_UPDATES"]:
            d_minus = -self._stage.difference(state.mean, predicted.mean)
            again = self._stage.update(predicted, y, used, state.mean, d_minus)
            if not np.isfinite(again.deviation).all():
                break
            largest = np.fmax.reduce(np.abs(again.deviation) / state.std)  # 0 / 0 says nothing
            if not largest > FIRST["FIRST_SETTLED"]:
                break
            state, updates = again.state, updates + 1
        return state, updates

    def _rows(self, used: Array) -> Iterator[tuple[int, bool, NDArray[np.intp]]]:
        """Yield sensors, whether they are measured, and those of their rows that are used."""
        start = 0
        for i, sensor in enumerate(self._model.sensors):
            rows = start + np.flatnonzero(used[start : start + sensor.n_r])
            start += sensor.n_r
            if len(rows):
                yield i, sensor.is_measured, rows

    def _distance(self, update: Update, S: Array, rows: NDArray[np.intp]) -> float:
        S = S[np.ix_(rows, rows)]
        return squared_distance(update.innovation[rows], S, S, 0.0)[0]

    def _gated(self, given: Array, update: Update, used: Array, doubt: Array, dt: float) -> Array:
        """Take rows of sensors whose readings are too far off out of `used`, as filter.c does.

        Returns
        -------
        (n_sensors,) 1 where a gate opens, else 0
        """
        assert self._gate is not None
        opens, seen = np.zeros(len(self._model.sensors)), self.memory.view(given, "seen")
        count, time_s = doubt[0::2], doubt[1::2]
        time_s[count > 0] += dt
        for i, is_measured, rows in list(self._rows(used)):
            limit = self._gate[i, len(rows)]
            is_far = self._distance(update, update.innovation_covariance, rows) > limit
            if not is_far or (is_measured and seen[i] == 0):
                count[i] = time_s[i] = 0
            elif count[i] >= OUTLIERS["GATE_REJECTIONS"] and time_s[i] >= OUTLIERS["GATE_DOUBT_S"]:
                count[i] = time_s[i] = 0
                opens[i] = 1
            else:
                count[i] += 1
                used[rows] = 0
        return opens

    def _widened(
        self, predicted: GaussianState, y: Array, update: Update, opens: Array
    ) -> tuple[GaussianState, Array]:
        """Return the prior, less certain where gates open, and its S; see filter.c."""
        S, present, share = update.innovation_covariance, update.present.astype(float), 0.0
        if not opens.any():
            return predicted, S
        wide = self._stage.update(self._doubted(predicted, 1.0), y, present).innovation_covariance
        for i, _measured, rows in self._rows(present):
            at, n = np.ix_(rows, rows), len(rows)
            if opens[i] == 0:
                continue
            if self._distance(update, wide, rows) > n:
                share = 1.0
            if share < 1:
                added = (wide - S)[at]
                share = max(share, needed(update.innovation[rows], S[at], added, float(n)))
        prior = self._doubted(predicted, min(share, 1.0))
        return prior, self._stage.update(prior, y, present).innovation_covariance

    def _doubted(self, gaussian: GaussianState, share: float) -> GaussianState:
        """Return a Gaussian with a share of the model's prior on top."""
        total = gaussian.covariance + share * self._model.prior.covariance
        if gaussian.root is None:
            return GaussianState(gaussian.mean, total)
        root = np.asarray(np.linalg.cholesky(total), dtype=np.float64)
        return kept(gaussian.mean, root)

    def _bound(self, given: Array, update: Update, S: Array, used: Array) -> None:
        """Give readings that are too far off less weight in `used`."""
        assert self._huber is not None
        seen, R = self.memory.view(given, "seen"), np.diag(self._model.noise_std**2)
        for i, is_measured, rows in self._rows(used):
            if is_measured and seen[i] == 0:
                continue
            v, at = update.innovation[rows], np.ix_(rows, rows)
            more = needed(v, S[at], R[at], self._huber[i] ** 2)
            if more > 0:
                used[rows] = np.sqrt(1 / (1 + more))


def _is_finite(gaussian: GaussianState) -> bool:
    return bool(np.isfinite(gaussian.mean).all() and np.isfinite(gaussian.covariance).all())
