"""The loop of ekf_baseline/filter.c and late.c in Python, for machines without a C compiler."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from ekf_baseline.interpreted_outliers import OutlierRules
from ekf_baseline.log import Log
from ekf_baseline.state import Kept, filter_memory
from estimation.estimator import remarks
from estimation.inputs import with_inputs
from estimation.kalman_stage import KalmanStage, Update, rows_present
from estimation.outputs import derived_outputs
from estimation.report import report
from estimation.rest_detector import RestDetector
from estimation.result import checked_input, result_layout, stepped
from estimation.status import Status
from estimation.stored import restored, store
from models.arrays import Array
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel

FIRST: Mapping[str, float] = MappingProxyType(
    {"FIRST_UPDATES": 20, "FIRST_SETTLED": 1e-3, "SETTLING_S": 0.3, "SETTLING_UPDATES": 5}
)
"""Macros of filter.c: how often an update is linearised anew at most, how far, in standard
deviations, its posterior then may be from where it was linearised; for how long after a
sensor's first reading updates are, s, and how often at most. Starts wrong by up to 90° and told so
take 3 to 12, by 170° some the whole number. Without a gyroscope they need not settle at all, and
more than five then cost elevation."""


@dataclass(frozen=True, eq=False)
class Step:
    """What became of a row.

    Parameters
    ----------
    first : the update with all its readings
    used : (n_r,) rows of the residual that were used in the end
    status : but for the remarks on the estimate
    """

    first: Update
    used: NDArray[np.bool_]
    status: Status
    updates: int


class InterpretedFilter:
    """The EKF's engine around the interpreted stage; see `estimation.result.Engine`.

    Parameters
    ----------
    past : how much of it a state keeps
    gate : limits of squared distances, see `ekf_baseline.outliers.gate_limits`; None has no gate
    huber : (n_sensors,) thresholds of bounded influence; None has none
    """

    def __init__(
        self, model: StateSpaceModel, past: Kept, gate: Array | None, huber: Array | None
    ) -> None:
        self.memory, self.result = filter_memory(model, past), result_layout(model)
        self._model, self._kept = model, past
        self._stage, self._derived = KalmanStage(model), derived_outputs(model)
        self._rules = OutlierRules(model, self._stage, gate, huber)
        self._rest = RestDetector(model)

    @np.errstate(over="ignore", invalid="ignore")  # an absurd reading: the status says it
    def step(self, given: Array, time_s: float, y: Array) -> tuple[Array, Array]:
        """Return the state after a measurement and what the step says; `given` stays."""
        start, at = time.perf_counter(), self.memory
        _, y = checked_input(at, self._model, given, np.asarray(time_s), y)
        memory, before = given.copy(), float(at.view(given, "time_s"))
        log = Log(self._model, self._kept, at, memory)
        own = memory[: at.slices["count"].start]
        if time_s < before:
            found = log.insert(time_s, y)
            if found is None:
                return memory, self._report(memory, None, Status.LATE, 0)
            step = self._replayed(log, own, *found)
        else:
            dt = 0.0 if np.isnan(before) else time_s - before
            log.append(own, time_s, dt, y)
            step = self._advance(own, time_s, dt, y)
        state = restored(at.view(memory, "mean"), at.view(memory, "covariance"))
        status = step.status | remarks(self._model, state, y, step.used)
        result = self._report(memory, step.first, status, step.updates)
        self.result.view(result, "step_time_s")[...] = time.perf_counter() - start
        return memory, result

    def _report(self, memory: Array, update: Update | None, status: Status, updates: int) -> Array:
        at = self.memory
        state = restored(at.view(memory, "mean"), at.view(memory, "covariance"))
        time_s = float(at.view(memory, "time_s"))
        return report(self.result, self._derived, time_s, state, update, status, updates)

    def _advance(self, own: Array, time_s: float, dt: float, y: Array) -> Step:
        """Take the filter's own state to a measurement `dt` later, in place."""
        model, at = self._model, self.memory
        state = restored(at.view(own, "mean").copy(), at.view(own, "covariance").copy())
        y = with_inputs(model, at.view(own, "inputs"), y)
        is_first = bool(np.isnan(at.view(own, "time_s")))
        known = y[model.n_y :] if is_first else at.view(own, "inputs")
        rest, y = self._rest.step(self._rest.part(at, own), dt, y)
        present, status = rows_present(model, y), Status.SOLVED
        inputs = (known, y[model.n_y :]) if model.n_u else ()
        predicted = self._stage.predict(state, dt, inputs=inputs).state
        first = update = self._stage.update(predicted, y, present)
        used, S = present.astype(float), update.innovation_covariance
        doubt, doubted, prior = at.view(own, "doubt").copy(), False, predicted
        if self._rules.gate is not None:
            opens = self._rules.gated(at.view(own, "seen"), update, used, doubt, dt)
            if (used != present).any():
                status |= Status.GATED
            doubted = bool((opens > 0).any())
            prior, S = self._rules.widened(predicted, y, update, opens)
        if self._rules.huber is not None:
            self._rules.bound(at.view(own, "seen"), update, S, used)
        if doubted or (used != present).any():
            update = self._stage.update(prior, y, used)
        seen, updates, gaussian = self._seen(own, update), 1, update.state
        is_new = bool((seen != at.view(own, "seen")).any())
        before_s = float(at.view(own, "settling_s"))
        settling_s = FIRST["SETTLING_S"] if is_new else max(before_s - dt, 0.0)
        if doubted or settling_s > 0:
            most = FIRST["FIRST_UPDATES" if is_new or doubted else "SETTLING_UPDATES"]
            gaussian, updates = self._settled(prior, y, update, used, most)
        if not gaussian.is_finite:
            status |= Status.NOT_FINITE
            gaussian = prior if prior.is_finite else state  # the last rung
            seen, doubt = at.view(own, "seen"), at.view(own, "doubt")
            settling_s = before_s
        at.view(own, "time_s")[...] = time_s
        at.view(own, "mean")[:] = gaussian.mean
        store(gaussian, at.view(own, "covariance"))
        at.view(own, "seen")[:] = seen
        at.view(own, "settling_s")[...] = settling_s
        at.view(own, "doubt")[:] = doubt
        at.view(own, "inputs")[:] = y[model.n_y :]
        self._rest.part(at, own)[:] = rest
        return Step(first, update.present, status | self._stage.remark(), updates)

    def _replayed(self, log: Log, own: Array, late: int, told: NDArray[np.bool_]) -> Step:
        """Make the states from the log's row `late` on again; `own` is then the newest.

        Parameters
        ----------
        told : (n_r,) rows of the residual that the late row may bring

        Returns
        -------
        The step of the late row, with those alone and with the newest row's status.
        """
        spacing = self._kept.spacing
        own[:] = log.checkpoints[late // spacing]
        for row in range(late // spacing * spacing, len(log)):
            if row % spacing == 0:
                log.checkpoints[row // spacing] = own
            step = self._advance(own, float(log.times[row]), float(log.steps[row]), log.rows[row])
            if row == late:
                found = step
        told = told & found.first.present
        used, first = told & found.used, found.first
        S = np.where(np.outer(told, told), first.innovation_covariance, 0.0)
        S[~told, ~told] = self._model.noise_std[~told] ** 2
        status = (found.status | step.status) & ~Status.GATED
        if (told & ~used).any():
            status |= Status.GATED
        return Step(
            replace(first, present=told, innovation_covariance=S), used, status, found.updates
        )

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
        self, predicted: GaussianState, y: Array, update: Update, used: Array, most: float
    ) -> tuple[GaussianState, int]:
        """Return an update linearised at its own posterior, and how many it took of `most`."""
        state, updates = update.state, 1
        while updates < most:
            d_minus = -self._stage.difference(state.mean, predicted.mean)
            again = self._stage.update(predicted, y, used, state.mean, d_minus)
            if not np.isfinite(again.deviation).all():
                break
            largest = np.fmax.reduce(np.abs(again.deviation) / state.std)  # 0 / 0 says nothing
            if not largest > FIRST["FIRST_SETTLED"]:
                break
            state, updates = again.state, updates + 1
        return state, updates
