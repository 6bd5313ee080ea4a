"""What follows an alarm: the simplest hypothesis that fits the last seconds is adopted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from estimation.estimate import Estimate
from estimation.watch.adopting import QUIET_S, Adopting
from estimation.watch.config import WatchConfig
from estimation.watch.energy import is_livelier, is_only_energy
from estimation.watch.hypotheses import Causes, Hypothesis
from estimation.watch.past import Anchor
from estimation.watch.replay import FITS, Replayed, Replays
from estimation.watch.returning import Returning
from estimation.watch.state import WatchState
from estimation.watch.statistics import Statistics

WAIT_S = 0.1
"""So long an alarm by nothing but energy waits: a motion that begins is soon told from a fault."""
JOLT_S = 0.04
"""An alarm by energy that is over so soon was a jolt."""
ONSET_ROWS = 4
"""What is sudden began at most so many rows before its alarm."""
BEGINNING = 0.5
"""Share of the usual energy from which a motion is livelier where rows begin: what is wrong there
has been so all along, and a sensor that is blamed for nothing does not come back."""
AWAY_S, RETURNED_S = 1.0, 0.15
"""Where a sensor was not read for so long, nothing is judged for so long when it is again: what it
shows was hardly known, and is linearised far from where it is."""
FREED_AGAIN_S = 4.0
"""So long a bias is not freed again."""


class Following:
    """Explains the alarms of a watch."""

    def __init__(
        self,
        causes: Causes,
        replays: Replays,
        adopting: Adopting,
        returning: Returning,
        statistics: Statistics,
        *,
        config: WatchConfig,
    ) -> None:
        self._config, self._causes, self._replays = config, causes, replays
        self._adopting, self._returning, self._statistics = adopting, returning, statistics

    def explained(
        self, state: WatchState, t: float, estimate: Estimate
    ) -> tuple[WatchState, Estimate]:
        """Follow an alarm: adopt the simplest hypothesis that fits the last seconds."""
        scores = self._statistics.scores(state.memory)
        for i in state.left_out:
            scores[i] = 0.0
        if max(scores) > 1 and self._has_returned(state, t):
            return state, estimate
        if max(scores) > 1 and t < state.alarm_s and self._waits(state):
            return self._waiting(state, t), estimate
        is_burst = max(scores) <= 1 or (
            state.level + 1 == self._causes.n_levels
            and is_only_energy(self._statistics, state.memory, state.left_out)
        )
        if is_burst and t >= state.alarm_s and state.level > 0:
            return replace(state, alarm_s=np.inf), estimate  # of what is livelier anyway
        if max(scores) <= 1 and t < state.alarm_s:
            if state.is_unexplained and max(scores) < FITS:
                state = replace(state, is_unexplained=False)
            return self._returning.calmer(state, t, estimate)
        counts = self._statistics.layout.view(state.memory, "outliers")
        undropped = frozenset(
            each.index
            for each in self._statistics.sensors
            if counts[each.index] >= each.limits.outliers
        )
        whole = self._replays.start(state.past, state.level, self._config.replay_s)
        begins = state.past.anchors[0].time_s is None
        moves_more = is_livelier(
            self._statistics, state.memory, state.left_out, share=BEGINNING if begins else 1.0
        )
        may_free = [
            i
            for i in range(self._statistics.n_sensors)
            if t - state.freed_s[i] > FREED_AGAIN_S and not (begins and moves_more)
        ]
        tiers = self._causes.tiers(
            state.left_out,
            state.level,
            may_free=may_free,
            may_restart=self._config.on_lost == "restart",
            is_livelier=moves_more,
        )
        for tier in tiers:
            if any(each.is_sudden for each in tier):
                found, is_over = self._sudden(state, t, tier, undropped)
                if is_over is not None and not any(each.fits for each in found):
                    memory = self._adopting.with_repeats(is_over.memory, state)
                    return replace(state, memory=memory, alarm_s=np.inf), estimate
            else:
                replays = (self._adopting.replay(state, whole, each, undropped) for each in tier)
                found = [each for each in replays if each is not None]
            fitting = [each for each in found if each.fits]
            if fitting:
                best = min(fitting, key=lambda each: each.score)
                return self._adopting.adopted(state, t, best), best.estimate
        is_alarm = max(scores) > 1
        return replace(
            state, is_unexplained=is_alarm, quiet_s=t + QUIET_S, alarm_s=np.inf
        ), estimate

    def _sudden(
        self, state: WatchState, t: float, tier: list[Hypothesis], undropped: frozenset[int]
    ) -> tuple[list[Replayed], Replayed | None]:
        """Return replays from where what is sudden may have begun, unless nothing at all fits too.

        And that of nothing at all from behind an alarm that has waited, if that fits: a jolt.
        """
        nothing, found = replace(tier[0], freed=frozenset[int]()), list[Replayed]()
        for start in self._onsets(state, t, undropped):
            without = self._adopting.replay(state, start, nothing, undropped)
            if without is not None and without.fits:
                continue
            replays = [self._adopting.replay(state, start, each, undropped) for each in tier]
            found += [each for each in replays if each is not None]
        lately = state.past.since(state.past.first_since(t - 3 * WAIT_S))
        if not np.isfinite(state.alarm_s) or any(row.unused for row in lately):
            return found, None
        number = state.past.first_since(state.alarm_s - WAIT_S + JOLT_S)
        behind = self._replays.before(state.past, state.level, number)
        over = self._adopting.replay(state, behind, replace(nothing, is_sudden=False), undropped)
        return found, over if over is not None and over.fits else None

    def _onsets(self, state: WatchState, t: float, undropped: frozenset[int]) -> list[Anchor]:
        """Return what was known in front of the rows at which what is sudden may have begun."""
        past = state.past
        newest = past.first_since(min(t, state.alarm_s - WAIT_S))
        for row in reversed(past.rows):
            if not undropped <= row.unused and any(
                self._replays.has_reading(row.y, i) and i not in row.unused for i in undropped
            ):
                break
            newest -= 1 if undropped else 0
        return [self._replays.before(past, state.level, newest - k) for k in range(ONSET_ROWS)]

    def _has_returned(self, state: WatchState, t: float) -> bool:
        """Whether a sensor is read again, since a moment, that was not for long."""
        rows = state.past.rows
        for sensor in self._statistics.sensors:
            read_s = [
                row.time_s
                for row in rows
                if sensor.index not in row.unused and self._replays.has_reading(row.y, sensor.index)
            ]
            before_s = [rows[0].time_s, *read_s]
            if any(
                after_s - last_s > AWAY_S and t - after_s <= RETURNED_S
                for last_s, after_s in zip(before_s, read_s, strict=False)
            ):
                return True
        return False

    def _waits(self, state: WatchState) -> bool:
        """Whether an alarm may be a motion that begins: more will be clear a moment later.

        Where the motion is livelier it may always be a burst of that.
        """
        return state.level > 0 or is_only_energy(self._statistics, state.memory, state.left_out)

    def _waiting(self, state: WatchState, t: float) -> WatchState:
        return state if np.isfinite(state.alarm_s) else replace(state, alarm_s=t + WAIT_S)
