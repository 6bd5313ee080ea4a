"""Rows in which nothing stands out, many in one call of the estimator."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from estimation.estimate import Estimate, EstimateHistory
from estimation.estimator import BatchEstimator
from estimation.frozen import changed
from estimation.inputs import rows_with_inputs
from estimation.recording import Measurement
from estimation.status import Status
from estimation.watch.asked import NEVER_CALMER, Calmer, Known
from estimation.watch.livelier import MotionLevels, factor_down
from estimation.watch.one_call import GAP_S, CleanState, OneCall, can_be_one_call
from estimation.watch.past import NONE_DROPPED, CleanPart, PastRow
from estimation.watch.quiet import Quiet
from estimation.watch.reach import Reach
from estimation.watch.state import WatchState
from estimation.watch.statistics import Statistics
from models.arrays import Array
from models.state_space import StateSpaceModel

LEVEL_S = 3.0
"""So long a level of motion is kept at least."""


class CleanRows:
    """Takes rows of an estimator that is watched, as far as a step would do no more with them."""

    def __init__(
        self,
        model: StateSpaceModel,
        levels: MotionLevels,
        statistics: Statistics,
        reach: Reach,
        replay_s: float,
    ) -> None:
        self._model, self._levels, self._quiet = model, levels, Quiet(statistics)
        self._statistics, self.calls = statistics, dict[int, OneCall]()  # by level of motion
        self._is_one_call = can_be_one_call(levels[0])
        self._reach, self._replay_s = reach, replay_s
        self._components = reach.components
        self._limit = np.full(model.n_x, np.nan)
        self._limit[reach.components] = reach.found[reach.components]
        self._none_flagged = np.zeros(len(model.sensors), dtype=np.uint8)
        self._none_flagged.flags.writeable = False
        self._call(0)  # not in a step
        self._sensor_names = tuple(sensor.name for sensor in model.sensors)

    def may_take(self, state: WatchState) -> bool:
        """Whether nothing is left out, lost or doubted."""
        newest_s = state.time_s
        return (
            newest_s is not None
            and not (state.out or state.is_lost or state.is_unexplained)
            and state.alarm_s == math.inf
            and newest_s >= state.calm_s
            and newest_s >= state.quiet_s
            and newest_s >= state.spoken_s
        )

    def one(
        self, state: WatchState, measurement: Measurement
    ) -> tuple[WatchState | CleanState, Estimate] | None:
        """Take one row; None where a step has to look at it."""
        if (call := self._call(state.level)) is not None:
            return call.step(call.begun(state, _calmer(state)), measurement)
        time_s, y, newest_s = float(measurement.time_s), measurement.y, state.time_s
        if newest_s is None or not 0 <= time_s - newest_s <= GAP_S or self._model.n_u:
            return None
        inner, estimate = self._levels[state.level].step(state.inner, measurement)
        v, S = estimate.innovation, estimate.innovation_covariance
        known = Known(self._limit, state.known, state.std, estimate.state.covariance)
        found = self._quiet.one(state.memory, time_s, y, v, S, calmer=_calmer(state), known=known)
        if found is None:
            return None
        memory, std = found
        past = state.past.after((PastRow(time_s, y.copy(), NONE_DROPPED),))
        if past.is_due():
            past = past.anchored(inner, time_s, self._replay_s)
        status = estimate.status | Status.LIVELIER if state.level else estimate.status
        return (
            changed(state, inner=inner, memory=memory, past=past, std=std, time_s=time_s),
            changed(estimate, status=status, flagged=self._none_flagged),
        )

    def whole(self, state: CleanState) -> WatchState:
        """Return a state in full."""
        return self.calls[state.since.level].whole(state)

    def _call(self, level: int) -> OneCall | None:
        """Return what makes a step at a level in one call; None where that cannot be."""
        if self._is_one_call and level not in self.calls:
            self.calls[level] = OneCall(
                self._levels[level],
                self._statistics,
                limit=self._limit,
                level=level,
                replay_s=self._replay_s,
                flagged=self._none_flagged,
            )
        return self.calls.get(level)

    def taken(
        self, state: WatchState, time_s: Array, y: Array, covariances: bool
    ) -> tuple[WatchState, EstimateHistory | None]:
        """Take rows up to the first that a step has to look at; None where that is the first.

        Parameters
        ----------
        time_s, y, covariances : see `estimation.watch.watched.Watched.batch`
        """
        estimator = self._levels[state.level]
        if not isinstance(estimator, BatchEstimator):
            return state, None
        inner, history = estimator.batch(state.inner, time_s, y, covariances=True)
        count, memory, known = self._count(state, time_s, y, history)
        if count == 0:
            return state, None
        if count < len(time_s):
            inner, _ = estimator.batch(state.inner, time_s[:count], y[:count])
            history = history[:count]
        assert state.time_s is not None
        newest_s = max(state.time_s, float(time_s[:count].max()))
        given = self._kept(state, y[:count])
        times = time_s[:count].copy()
        past = state.past.after_part(CleanPart(count, (times, given), float(times.min())))
        if past.is_due():
            past = past.anchored(inner, newest_s, self._replay_s)
        state = changed(
            state,
            inner=inner,
            memory=memory,
            known=known,
            past=past,
            std=history.std[-1].copy(),
            time_s=newest_s,
        )
        status = history.status
        if state.level:
            status = tuple(each | Status.LIVELIER for each in status)
        return state, replace(
            history,
            status=status,
            covariances=history.covariances if covariances else None,
            sensor_names=self._sensor_names,
            flagged=np.zeros((count, len(self._sensor_names)), dtype=np.uint8),
        )

    def _count(
        self, state: WatchState, time_s: Array, y: Array, history: EstimateHistory
    ) -> tuple[int, Array, NDArray[np.bool_]]:
        """Return how many rows need no look, and the statistics and what is known behind them."""
        assert state.time_s is not None
        most, known = self._sure(state, time_s, history.std[:, self._components])
        memory, rows = state.memory.copy(), slice(most)
        v, S = history.innovation, history.innovation_covariance
        count = self._quiet.clean(
            memory,
            time_s[rows],
            y[rows],
            v[rows],
            S[rows],
            newest_s=state.time_s,
            calmer=_calmer(state),
        )
        if known is None:
            return count, memory, state.known
        whole = state.known.copy()
        whole[self._components] = known[count]
        return count, memory, whole

    def _sure(
        self, state: WatchState, time_s: Array, std: Array
    ) -> tuple[int, NDArray[np.bool_] | None]:
        """Return before how many rows nothing can be lost, and what is known in front of each.

        The second is None where that is always what it was.

        Parameters
        ----------
        time_s : (n,) of the rows
        std : (n, k) deviations of the components that may be lost
        """
        components, found = self._components, self._reach.found[self._components]
        stds = np.concatenate([state.std[None, components], std])
        is_found, was_known = stds < found, state.known[components]
        newest = np.maximum.accumulate(np.concatenate([[state.time_s], time_s]))
        gaps = time_s - newest[:-1]
        if (is_found == was_known).all() and gaps.max() <= GAP_S:
            return len(time_s), None
        known = np.logical_or.accumulate(np.concatenate([was_known[None], is_found[1:]]))
        unsure = known[:-1].any(axis=1) & (
            (gaps > GAP_S) | (known[:-1] & ~is_found[:-1]).any(axis=1)
        )
        is_lost = (known[:-1] & (std > self._reach.lost[components])).any(axis=1)
        looked_at = np.flatnonzero((unsure & (gaps >= 0)) | is_lost)
        return int(looked_at[0]) if len(looked_at) else len(time_s), known

    def _kept(self, state: WatchState, y: Array) -> Sequence[Array] | Array:
        """Return copies of rows, with the inputs that were known before where they have none."""
        rows = y.copy()  # whoever gave them may write the next ones there
        if not self._model.n_u:
            return rows
        return rows_with_inputs(self._model, list(rows), last=state.past.newest)


def _calmer(state: WatchState) -> Calmer:
    if state.level == 0:
        return NEVER_CALMER
    return Calmer(state.level_s, LEVEL_S, factor_down(state.level))
