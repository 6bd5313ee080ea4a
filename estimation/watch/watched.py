"""An estimator that is watched: what it is told is tested, and so is whether it still knows."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from estimation.collect import collected
from estimation.estimate import Estimate, EstimateHistory
from estimation.estimator import Estimator, LookingBack, first_state
from estimation.exclusive import Exclusive, in_turn
from estimation.recording import Measurement
from estimation.settings import checked_config
from estimation.status import Status
from estimation.watch.adopting import Adopting
from estimation.watch.clean_rows import CleanRows
from estimation.watch.config import WatchConfig
from estimation.watch.deadline import Clock, Spending, TimedLevels
from estimation.watch.flags import Flag
from estimation.watch.following import Following
from estimation.watch.hypotheses import Causes
from estimation.watch.in_chunks import in_chunks
from estimation.watch.in_time import InTime, Look
from estimation.watch.limits import limits_of
from estimation.watch.livelier import MotionLevels
from estimation.watch.lost import CALM_S, LostAndFound
from estimation.watch.one_call import CleanState
from estimation.watch.past import Anchor, Past, PastRow
from estimation.watch.reach import Reach
from estimation.watch.remembered import RememberedReplays
from estimation.watch.replay import Replays
from estimation.watch.returning import Returning
from estimation.watch.state import RETRY_S, WatchState
from estimation.watch.statistics import Statistics
from estimation.watch.taking import Taking
from models.arrays import Array
from models.given_prior import Prior


class Watched(Exclusive):
    """An estimator and its watch; itself an estimator, of the same name.

    Parameters
    ----------
    estimator : any `estimation.estimator.Estimator`
    config : see `WatchConfig`
    clock : s, of its deadline; the machine's own by default
    """

    def __init__(
        self,
        estimator: Estimator[Any],
        config: WatchConfig | None = None,
        *,
        clock: Clock = time.perf_counter,
    ) -> None:
        self.estimator, self.model, self.name = estimator, estimator.model, estimator.name
        config = self.config = checked_config("watch", config, WatchConfig)
        super().__init__(estimator, config, clock=clock)
        self.lags = estimator.lags if isinstance(estimator, LookingBack) else ()
        levels, statistics = MotionLevels(estimator), Statistics(self.model, limits_of(self.model))
        self._statistics, self._reach = statistics, Reach(self.model)
        self._look: Look = self._looked_at
        replays: Any = Replays(self.model, levels, statistics)
        if config.deadline_s is not None:
            spending = Spending(config.deadline_s, clock)
            timed: Any = TimedLevels(levels, spending)
            replays = RememberedReplays(Replays(self.model, timed, statistics), timed, spending)
            longest_s = config.replay_s
            self._look = InTime(self._looked_at, replays, spending, longest_s=longest_s).look
        adopting = Adopting(replays, statistics, self._reach)
        causes = Causes(self.model, levels.count)
        self._clean = CleanRows(self.model, levels, statistics, self._reach, config.replay_s)
        self._taking = Taking(self.model, levels, statistics, replays)
        self._lost = LostAndFound(levels, statistics, self._reach, replays, config=config)
        self._returning = Returning(causes, replays, adopting, statistics, config=config)
        self._following = Following(
            causes, replays, adopting, self._returning, statistics, config=config
        )
        self._n = len(self.model.sensors)

    def init(self, prior: Prior | None = None) -> WatchState:
        """Return the state before the first measurement, from the model's prior or another."""
        known, inner = first_state(self.model, prior), self.estimator.init(prior)
        return WatchState(
            inner=inner,
            prior=known,
            memory=self._statistics.first(),
            past=Past((Anchor(0, inner, None, known),)),
            known=known.std < self._reach.found,
            std=known.std,
            freed_s=np.full(self._n, -np.inf),
            doubted_s=np.full(self._n, -np.inf),
            blamed=((-np.inf, RETRY_S),) * self._n,
        )

    @in_turn
    def step(
        self, state: WatchState | CleanState, measurement: Measurement
    ) -> tuple[WatchState | CleanState, Estimate]:
        """Take one measurement; return the new state and the estimate x_k|k."""
        taken: tuple[WatchState | CleanState, Estimate] | None = None
        if isinstance(state, CleanState):
            taken = self._clean.calls[state.since.level].step(state, measurement)
        elif self._clean.may_take(state):
            taken = self._clean.one(state, measurement)
        return taken or self._look(self._whole(state), measurement)

    def _whole(self, state: WatchState | CleanState) -> WatchState:
        return self._clean.whole(state) if isinstance(state, CleanState) else state

    def _looked_at(
        self, state: WatchState, measurement: Measurement
    ) -> tuple[WatchState, Estimate]:
        """Take a measurement in which something stands out, or behind one."""
        t, y = float(measurement.time_s), self._taking.with_inputs(state, measurement.y)
        is_late = state.time_s is not None and t < state.time_s
        if state.time_s is None:
            state = replace(state, calm_s=t + CALM_S)
        begun = state.past.anchors
        if not is_late and self._lost.may_be_lost(state, t):
            state = self._lost.restarted(state, t, y)
        is_begun = state.past.anchors is not begun
        state = replace(state, memory=state.memory.copy(), time_s=state.time_s if is_late else t)
        stuck = frozenset[int]()
        if not is_late:
            stuck = frozenset(self._statistics.repeats(state.memory, t, y))
        state, estimate, outliers = self._taking.taken(state, t, y, stuck)
        if is_begun and estimate.window is not None:
            state, estimate = self._lost.settled(state, t, y, estimate)
        state = replace(
            state,
            past=state.past.after((PastRow(t, y, outliers, stuck, state.left_out),)),
            std=estimate.state.std,
        )
        for i in sorted(stuck - state.left_out):
            state = self._taking.stuck_long(state, t, i)
        if any(t >= each.retry_s for each in state.out) and not is_late:
            state, estimate = self._returning.tried_again(state, t, estimate)
        if t >= state.quiet_s and t >= state.calm_s:
            state, estimate = self._following.explained(state, t, estimate)
        state = self._lost.known(state)
        if state.past.is_due() and not is_late:
            past = state.past.anchored(state.inner, t, self.config.replay_s)
            state = replace(state, past=past)
        told = self._told(state, t, estimate, stuck, outliers)
        return state, replace(told, status=told.status | Status.LOST) if is_begun else told

    def _told(
        self,
        state: WatchState,
        t: float,
        estimate: Estimate,
        stuck: frozenset[int],
        outliers: frozenset[int],
    ) -> Estimate:
        """Return the estimate with all that the watch says."""
        status, flagged = estimate.status, np.zeros(self._n, dtype=np.uint8)
        for i in stuck:
            flagged[i] |= int(Flag.STUCK)
        for i in outliers:
            flagged[i] |= int(Flag.OUTLIER)
        for i in state.left_out:
            flagged[i] |= int(Flag.INCONSISTENT | Flag.LEFT_OUT)
        flagged[state.doubted_s > t] |= np.uint8(Flag.INCONSISTENT)
        if stuck:
            status |= Status.STUCK
        if outliers:
            status |= Status.OUTLIER
        if state.level:
            status |= Status.LIVELIER
        if state.is_lost:
            status |= Status.LOST
        if state.is_unexplained:
            status |= Status.INCONSISTENT
        return replace(estimate, status=status, flagged=flagged)

    @in_turn
    def batch(
        self,
        state: WatchState | CleanState,
        time_s: Array,
        y: Array,
        *,
        covariances: bool = False,
        on_progress: Callable[[int], None] | None = None,
    ) -> tuple[WatchState, EstimateHistory]:
        """Take n measurements; the same as n steps.

        Parameters
        ----------
        time_s, y : (n,), (n, n_row), as of `estimation.recording.Recording.stacked`
        covariances, on_progress : see `estimation.estimator.run`
        """
        collect = partial(collected, self.name, self.model, covariances=covariances, lags=self.lags)
        return in_chunks(
            self._whole(state),
            time_s,
            y,
            clean=self._clean,
            look=self._look,
            collect=collect,
            covariances=covariances,
            on_progress=on_progress,
        )
