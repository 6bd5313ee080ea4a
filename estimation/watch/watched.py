"""An estimator that is watched: what it is told is tested, and so is whether it still knows."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from estimation.collect import BATCH_STEPS, collected
from estimation.estimate import Estimate, EstimateHistory
from estimation.estimator import Estimator, LookingBack, first_state
from estimation.inputs import with_inputs
from estimation.recording import Measurement
from estimation.settings import checked_config
from estimation.status import Status
from estimation.watch.clean_rows import GAP_S, LEVEL_S, CleanRows
from estimation.watch.config import WatchConfig
from estimation.watch.flags import Flag, Flags
from estimation.watch.hypotheses import Causes, Hypothesis
from estimation.watch.limits import limits_of
from estimation.watch.livelier import LEVELS, Levels
from estimation.watch.past import Anchor, Past, Row
from estimation.watch.reach import Reach
from estimation.watch.replay import FITS, Replayed, Replays
from estimation.watch.state import LeftOut, WatchState
from estimation.watch.statistics import REPEATED, Flat, Statistics
from models.arrays import Array
from models.given_prior import Prior

CALM_S = 0.15
"""From a start on nothing is judged so long."""
WAIT_S = 0.1
"""So long an alarm by nothing but energy waits: a motion that begins is soon told from a fault."""
JOLT_S = 0.04
"""An alarm by energy that is over so soon was a jolt."""
ONSET_ROWS = 4
"""What is sudden began at most so many rows before its alarm."""
QUIET_S = 0.3
"""So long no second alarm is followed."""
SPOKEN_S = 1.0
"""So long a sensor is flagged whose bias was freed, or that has just been taken back."""
FREED_AGAIN_S = 4.0
"""So long a bias is not freed again."""
RETURN_S, RETURNS = 1.0, 0.6
"""A sensor that is left out is taken back when so many seconds with it fit so well."""
RETRY_S, LONGEST_RETRY_S, AGAIN_S = 1.0, 8.0, 0.5
"""That is first tried after so long, each time that it is blamed again twice that, and so often."""
STUCK_S = 0.3
"""So long a gyroscope is stuck before it is left out."""
FREED_TRIES = 4
"""Each so manieth time its bias may be anything, and the state is begun again."""
FORGIVEN_S = 10.0
"""A sensor that has been right for so long has never been blamed."""
SETTLING = 3
"""Passes over a window that begins again, behind its first."""
SHORTEST_CHUNK = 16
"""Rows of the first chunk behind something that was found."""


class Watched:
    """An estimator and its watch; itself an estimator, of the same name.

    Parameters
    ----------
    estimator : any `estimation.estimator.Estimator`
    config : see `WatchConfig`
    """

    def __init__(self, estimator: Estimator[Any], config: WatchConfig | None = None) -> None:
        self.estimator, self.model, self.name = estimator, estimator.model, estimator.name
        self.config = checked_config("watch", config, WatchConfig)
        self.lags = estimator.lags if isinstance(estimator, LookingBack) else ()
        self._levels = Levels(estimator)
        self._statistics = Statistics(self.model, limits_of(self.model))
        self._reach = Reach(self.model)
        self._causes = Causes(self.model, self._levels.count)
        self._replays = Replays(self.model, self._levels, self._statistics)
        self._clean = CleanRows(
            self.model, self._levels, self._statistics, self._reach, self.config.replay_s
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

    def step(self, state: WatchState, measurement: Measurement) -> tuple[WatchState, Estimate]:
        """Take one measurement; return the new state and the estimate x_k|k."""
        if self._clean.may_take(state):
            taken = self._clean.one(state, float(measurement.time_s), measurement.y)
            if taken is not None:
                return taken
        return self._looked_at(state, measurement)

    def _looked_at(
        self, state: WatchState, measurement: Measurement
    ) -> tuple[WatchState, Estimate]:
        """Take a measurement in which something stands out, or behind one."""
        t, y = float(measurement.time_s), self._with_inputs(state, measurement.y)
        is_late = state.time_s is not None and t < state.time_s
        if state.time_s is None:
            state = replace(state, calm_s=t + CALM_S)
        begun = state.past.anchors
        if not is_late and self._may_be_lost(state, t):
            state = self._restarted(state, t, y)
        is_begun = state.past.anchors is not begun
        state = replace(state, memory=state.memory.copy(), time_s=state.time_s if is_late else t)
        stuck = [] if is_late else self._statistics.repeats(state.memory, t, y)
        dropped = frozenset(stuck) - state.left_out
        state, estimate, outliers = self._taken(state, t, y, dropped)
        if is_begun and estimate.window is not None:
            state, estimate = self._settled(state, t, y, estimate)
        state = replace(
            state, past=state.past.after((Row(t, y, dropped | outliers),)), std=estimate.state.std
        )
        for i in sorted(dropped & frozenset(stuck)):
            state = self._stuck_long(state, t, i)
        if any(t >= each.retry_s for each in state.out) and not is_late:
            state, estimate = self._tried_again(state, t, estimate)
        if t >= state.quiet_s and t >= state.calm_s:
            state, estimate = self._explained(state, t, estimate)
        state = self._known(state)
        if state.past.is_due() and not is_late:
            past = state.past.anchored(state.inner, t, self.config.replay_s)
            state = replace(state, past=past)
        told = self._told(state, t, estimate, frozenset(stuck), outliers)
        return state, replace(told, status=told.status | Status.LOST) if is_begun else told

    def _with_inputs(self, state: WatchState, y: Array) -> Array:
        if not self.model.n_u:
            return y.copy()  # it is kept, and whoever gave it may write the next one there
        rows = state.past.rows
        return with_inputs(self.model, rows[-1].y[self.model.n_y :] if rows else None, y)

    def _may_be_lost(self, state: WatchState, t: float) -> bool:
        if state.time_s is None or not state.known.any():
            return False
        unsure = bool((state.known & (state.std > self._reach.found)).any())
        return unsure or t - state.time_s > GAP_S

    def _restarted(self, state: WatchState, t: float, y: Array) -> WatchState:
        """Return the state from which a row is taken: begun again where it is lost by then."""
        has_reading = any(
            self._replays.has_reading(y, each.index) for each in self._statistics.sensors
        )
        if not has_reading:
            return state
        estimator = self._levels[state.level]
        empty = y.copy()
        empty[: self.model.n_y] = np.nan
        inner, estimate = estimator.step(state.inner, Measurement(t, empty))
        if not self._reach.is_beyond(estimate.state.std, state.known):
            return state
        state = replace(state, is_lost=True)
        if self.config.on_lost == "hold":
            return state
        begun = self._reach.restarted(estimate.state, state.prior)
        inner, _ = estimator.step(estimator.init(begun), Measurement(t, empty))
        memory = state.memory.copy()
        for each in self._statistics.sensors:
            self._statistics.forget(memory, each.index)
        past = Past((Anchor(state.past.count, inner, t, begun),))
        return replace(
            state, inner=inner, memory=memory, past=past, calm_s=t + CALM_S, alarm_s=np.inf, tried=0
        )

    def _taken(
        self, state: WatchState, t: float, y: Array, dropped: frozenset[int]
    ) -> tuple[WatchState, Estimate, frozenset[int]]:
        """Take a row; what is an outlier is not used. `state.memory` is changed in place."""
        estimator, without = self._levels[state.level], self._replays.without
        skipped = dropped | state.left_out
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

    def _settled(
        self, state: WatchState, t: float, y: Array, estimate: Estimate
    ) -> tuple[WatchState, Estimate]:
        """Pass over a window that has just begun again: far from where it was linearised."""
        inner, empty = state.inner, y.copy()
        empty[: self.model.n_y] = np.nan
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

    def _stuck_long(self, state: WatchState, t: float, sensor: int) -> WatchState:
        """Leave out a gyroscope that has been stuck so long that its return is no trifle.

        Without it an attitude is soon worse than it seems. Without an accelerometer it is not.
        """
        if not self.model.sensors[sensor].reads_rate:
            return state
        since_s = t
        for row in reversed(state.past.rows):
            if sensor in row.dropped:
                since_s = row.time_s
            elif self._replays.has_reading(row.y, sensor):
                break
        if t - since_s < STUCK_S:
            return state
        return replace(state, out=(*state.out, LeftOut(sensor, t + RETRY_S)))

    def _tried_again(
        self, state: WatchState, t: float, estimate: Estimate
    ) -> tuple[WatchState, Estimate]:
        """Replay with a sensor that is left out; take it back where all fits."""
        out = next(each for each in state.out if t >= each.retry_s)
        has_freed = (out.tries + 1) % FREED_TRIES == 0
        back_s = self.config.replay_s if has_freed else min(RETURN_S, self.config.replay_s)
        start = self._replays.start(state.past, state.level, back_s)
        hypotheses = self._causes.returning(
            state.left_out - {out.sensor},
            out.sensor,
            state.level,
            has_freed=has_freed,
            may_restart=self.config.on_lost == "restart",
        )
        for hypothesis in hypotheses:
            found = self._replay(state, start, hypothesis, frozenset({out.sensor}))
            if found is not None and found.score < RETURNS:
                return self._adopted(state, t, found), found.estimate
        again = replace(out, retry_s=t + AGAIN_S, tries=out.tries + 1)
        rest = tuple(again if each is out else each for each in state.out)
        return replace(state, out=rest), estimate

    def _replay(
        self, state: WatchState, start: Anchor, hypothesis: Hypothesis, undropped: frozenset[int]
    ) -> Replayed | None:
        return self._replays.replayed(
            state.past,
            start,
            hypothesis,
            reach=self._reach,
            prior=state.prior,
            level=state.level,
            undropped=undropped,
        )

    def _explained(
        self, state: WatchState, t: float, estimate: Estimate
    ) -> tuple[WatchState, Estimate]:
        """Follow an alarm: adopt the simplest hypothesis that fits the last seconds."""
        scores = self._statistics.scores(state.memory)
        for i in state.left_out:
            scores[i] = 0.0
        if max(scores) > 1 and t < state.alarm_s and self._waits(state):
            return self._waiting(state, t), estimate
        is_burst = max(scores) <= 1 or (
            state.level + 1 == self._levels.count and self._waits(state)
        )
        if is_burst and t >= state.alarm_s and state.level > 0:
            return replace(state, alarm_s=np.inf), estimate  # of what is livelier anyway
        if max(scores) <= 1 and t < state.alarm_s:
            if state.is_unexplained and max(scores) < FITS:
                state = replace(state, is_unexplained=False)
            return self._calmer(state, t, estimate)
        counts = self._statistics.layout.view(state.memory, "outliers")
        undropped = frozenset(
            each.index
            for each in self._statistics.sensors
            if counts[each.index] >= each.limits.outliers
        )
        whole = self._replays.start(state.past, state.level, self.config.replay_s)
        may_free = [i for i in range(self._n) if t - state.freed_s[i] > FREED_AGAIN_S]
        began, tried, longest_s = time.perf_counter(), 0, 0.0
        tiers = self._causes.tiers(
            state.left_out,
            state.level,
            may_free=may_free,
            may_restart=self.config.on_lost == "restart",
            is_livelier=state.level > 0
            or self._statistics.is_livelier(state.memory, state.left_out),
        )
        for tier in tiers:
            tried += 1
            if tried <= state.tried:
                continue
            spent_s = time.perf_counter() - began
            if tried > state.tried + 1 and spent_s + longest_s > (self.config.deadline_s or np.inf):
                return replace(state, tried=tried - 1), estimate
            if any(each.is_sudden for each in tier):
                found, is_over = self._sudden(state, t, tier, undropped)
                if is_over is not None and not any(each.fits for each in found):
                    memory = self._with_repeats(is_over.memory, state)
                    return replace(state, memory=memory, alarm_s=np.inf), estimate
            else:
                replays = (self._replay(state, whole, each, undropped) for each in tier)
                found = [each for each in replays if each is not None]
            fitting = [each for each in found if each.fits]
            if fitting:
                best = min(fitting, key=lambda each: each.score)
                return self._adopted(state, t, best), best.estimate
            longest_s = max(longest_s, time.perf_counter() - began - spent_s)
        is_alarm = max(scores) > 1
        return replace(
            state, is_unexplained=is_alarm, quiet_s=t + QUIET_S, alarm_s=np.inf, tried=0
        ), estimate

    def _sudden(
        self, state: WatchState, t: float, tier: list[Hypothesis], undropped: frozenset[int]
    ) -> tuple[list[Replayed], Replayed | None]:
        """Return replays from where what is sudden may have begun, unless nothing at all fits too.

        And that of nothing at all from behind an alarm that has waited, if that fits: a jolt.
        """
        nothing, found = replace(tier[0], freed=frozenset[int]()), list[Replayed]()
        for start in self._onsets(state, t, undropped):
            without = self._replay(state, start, nothing, undropped)
            if without is not None and without.fits:
                continue
            replays = [self._replay(state, start, each, undropped) for each in tier]
            found += [each for each in replays if each is not None]
        lately = state.past.since(state.past.first_since(t - 3 * WAIT_S))
        if not np.isfinite(state.alarm_s) or any(row.dropped for row in lately):
            return found, None
        number = state.past.first_since(state.alarm_s - WAIT_S + JOLT_S)
        behind = self._replays.before(state.past, state.level, number)
        over = self._replay(state, behind, replace(nothing, is_sudden=False), undropped)
        return found, over if over is not None and over.fits else None

    def _with_repeats(self, memory: Array, state: WatchState) -> Array:
        """Return a memory with what readings alone have changed."""
        memory, view = memory.copy(), self._statistics.layout.view
        for block in REPEATED:
            view(memory, block)[:] = view(state.memory, block)
        return memory

    def _onsets(self, state: WatchState, t: float, undropped: frozenset[int]) -> list[Anchor]:
        """Return what was known in front of the rows at which what is sudden may have begun."""
        past = state.past
        newest = past.first_since(min(t, state.alarm_s - WAIT_S))
        for row in reversed(past.rows):
            if not undropped <= row.dropped and any(
                self._replays.has_reading(row.y, i) and i not in row.dropped for i in undropped
            ):
                break
            newest -= 1 if undropped else 0
        return [self._replays.before(past, state.level, newest - k) for k in range(ONSET_ROWS)]

    def _waits(self, state: WatchState) -> bool:
        """Whether an alarm may be a motion that begins: more will be clear a moment later."""
        return self._statistics.is_only_energy(state.memory, state.left_out)

    def _waiting(self, state: WatchState, t: float) -> WatchState:
        return state if np.isfinite(state.alarm_s) else replace(state, alarm_s=t + WAIT_S)

    def _adopted(self, state: WatchState, t: float, found: Replayed) -> WatchState:
        """Return the state behind a replay: what it found, it goes on with."""
        hypothesis = found.hypothesis
        freed, doubted = state.freed_s.copy(), state.doubted_s.copy()
        blamed = list(state.blamed)
        for i in hypothesis.freed:
            freed[i], doubted[i] = t, t + SPOKEN_S
        memory = self._with_repeats(found.memory, state)
        doubted[list(state.left_out - hypothesis.left_out)] = t + SPOKEN_S
        out = [each for each in state.out if each.sensor in hypothesis.left_out]
        for i in sorted(hypothesis.left_out - state.left_out):
            last_s, wait_s = blamed[i]
            wait_s = RETRY_S if t - last_s > FORGIVEN_S else min(2 * wait_s, LONGEST_RETRY_S)
            out.append(LeftOut(i, t + wait_s))
            blamed[i] = (t, wait_s)
        past = Past((found.anchor,), state.past.since(found.anchor.number))
        return replace(
            state,
            inner=found.inner,
            level=hypothesis.level,
            level_s=t if hypothesis.level != state.level else state.level_s,
            memory=memory,
            past=past,
            out=tuple(out),
            std=found.estimate.state.std,
            is_lost=state.is_lost or hypothesis.is_restart,
            is_unexplained=False,
            freed_s=freed,
            doubted_s=doubted,
            blamed=tuple(blamed),
            quiet_s=t + QUIET_S,
            alarm_s=np.inf,
            tried=0,
        )

    def _calmer(
        self, state: WatchState, t: float, estimate: Estimate
    ) -> tuple[WatchState, Estimate]:
        """Go down a level of motion where all that moves would fit there."""
        if not self._may_calm(state, state.memory, t):
            return state, estimate
        start = self._replays.start(state.past, state.level, self.config.replay_s)
        hypothesis = Hypothesis(state.left_out, level=state.level - 1)
        found = self._replay(state, start, hypothesis, frozenset())
        if found is not None and found.fits:
            return self._adopted(state, t, found), found.estimate
        return replace(state, level_s=t), estimate

    def _may_calm(self, state: WatchState, memory: Flat, t: float) -> bool:
        if state.level == 0 or t - state.level_s < LEVEL_S:
            return False
        factor = (LEVELS[state.level] / LEVELS[state.level - 1]) ** 2
        values = self._statistics.values(memory)
        return all(
            factor * values[each.index][3] <= each.limits.usual[3]
            for each in self._statistics.sensors
            if each.index in self._causes.inertial and each.index not in state.left_out
        )

    def _known(self, state: WatchState) -> WatchState:
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

    def _told(
        self,
        state: WatchState,
        t: float,
        estimate: Estimate,
        stuck: frozenset[int],
        outliers: frozenset[int],
    ) -> Estimate:
        """Return the estimate with all that the watch says."""
        status, flagged = estimate.status, self._nothing()
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

    def _distances(self, estimate: Estimate) -> tuple[list[float], list[float]]:
        S = estimate.innovation_covariance
        return self._statistics.distances(estimate.innovation.tolist(), S.tolist())

    def _nothing(self) -> Flags:
        return np.zeros(self._n, dtype=np.uint8)

    def batch(
        self,
        state: WatchState,
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
        n, after = len(time_s), state

        def parts() -> Iterator[EstimateHistory]:
            nonlocal after
            estimates, times, done, size = list[Estimate](), list[float](), 0, SHORTEST_CHUNK
            while done < n:
                before, rows = done, slice(done, min(done + size, n))
                if self._clean.may_take(after):
                    after, part = self._clean.taken(after, time_s[rows], y[rows], covariances)
                    if part is not None:
                        if estimates:
                            yield self._collected(estimates, times, covariances)
                        yield part
                        done += len(part)
                    size = min(2 * size, BATCH_STEPS)
                if done < rows.stop:
                    began = time.perf_counter()
                    row = Measurement(float(time_s[done]), y[done])
                    after, estimate = self._looked_at(after, row)
                    times.append(time.perf_counter() - began)
                    estimates.append(estimate)
                    done, size = done + 1, SHORTEST_CHUNK
                    if len(estimates) == BATCH_STEPS:
                        yield self._collected(estimates, times, covariances)
                if on_progress:
                    on_progress(done - before)
            if estimates or not n:
                yield self._collected(estimates, times, covariances)

        history = EstimateHistory.joined(parts(), n)
        return after, history

    def _collected(
        self, estimates: list[Estimate], times: list[float], covariances: bool
    ) -> EstimateHistory:
        """Return the history of estimates, which are then forgotten."""
        found = collected(
            self.name, self.model, estimates, times, covariances=covariances, lags=self.lags
        )
        estimates.clear()
        times.clear()
        return found
