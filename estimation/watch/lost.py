"""Is what was known known still? Where it is not, the estimator begins again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from estimation.estimate import Estimate
from estimation.recording import Measurement
from estimation.watch.config import WatchConfig
from estimation.watch.livelier import MotionLevels
from estimation.watch.one_call import GAP_S
from estimation.watch.past import Anchor, Past
from estimation.watch.reach import Reach
from estimation.watch.replay import Replays
from estimation.watch.state import WatchState
from estimation.watch.statistics import Statistics
from models.arrays import Array

CALM_S = 0.15
"""From a start on nothing is judged so long."""
SETTLING = 3
"""Passes over a window that begins again, behind its first."""


class LostAndFound:
    """Says what is lost, begins again there, and says what is found."""

    def __init__(
        self,
        levels: MotionLevels,
        statistics: Statistics,
        reach: Reach,
        replays: Replays,
        *,
        config: WatchConfig,
    ) -> None:
        self._config, self._levels, self._statistics = config, levels, statistics
        self._reach, self._replays = reach, replays
        self._n_y = statistics.model.n_y

    def may_be_lost(self, state: WatchState, t: float) -> bool:
        """Whether what was known may not be by an instant."""
        if state.time_s is None or not state.known.any():
            return False
        unsure = bool((state.known & (state.std > self._reach.found)).any())
        return unsure or t - state.time_s > GAP_S

    def restarted(self, state: WatchState, t: float, y: Array) -> WatchState:
        """Return the state from which a row is taken: begun again where it is lost by then."""
        has_reading = any(
            self._replays.has_reading(y, each.index) for each in self._statistics.sensors
        )
        if not has_reading:
            return state
        estimator = self._levels[state.level]
        empty = y.copy()
        empty[: self._n_y] = np.nan
        inner, estimate = estimator.step(state.inner, Measurement(t, empty))
        if not self._reach.is_beyond(estimate.state.std, state.known):
            return state
        state = replace(state, is_lost=True)
        if self._config.on_lost == "hold":
            return state
        begun = self._reach.restarted(estimate.state, state.prior)
        inner, _ = estimator.step(estimator.init(begun), Measurement(t, empty))
        memory = state.memory.copy()
        for each in self._statistics.sensors:
            self._statistics.forget(memory, each.index)
        past = Past((Anchor(state.past.count, inner, t, begun),))
        return replace(
            state, inner=inner, memory=memory, past=past, calm_s=t + CALM_S, alarm_s=np.inf
        )

    def settled(
        self, state: WatchState, t: float, y: Array, estimate: Estimate
    ) -> tuple[WatchState, Estimate]:
        """Pass over a window that has just begun again: far from where it was linearised."""
        inner, empty = state.inner, y.copy()
        empty[: self._n_y] = np.nan
        for _ in range(SETTLING):
            inner, again = self._levels[state.level].step(inner, Measurement(t, empty))
        settled = replace(
            estimate,
            state=again.state,
            window=again.window,
            lagged=again.lagged,
            derived=again.derived,
            derived_std=again.derived_std,
        )
        return replace(state, inner=inner), settled

    def known(self, state: WatchState) -> WatchState:
        """Return the state with what is known by now, and whether it is lost."""
        components = self._reach.components
        std = state.std[components]
        found, lost = std < self._reach.found[components], std > self._reach.lost[components]
        known = state.known[components]
        is_lost = state.is_lost
        if is_lost and (found | ~known).all():
            is_lost = False
        elif not is_lost and (known & lost).any():
            is_lost = True
        if is_lost != state.is_lost or (found & ~known).any():
            now = state.known.copy()
            now[components] |= found
            return replace(state, known=now, is_lost=is_lost)
        return state
