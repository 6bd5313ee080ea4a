"""What a replay has found is gone on with."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from estimation.watch.hypotheses import Hypothesis
from estimation.watch.past import Anchor, Past
from estimation.watch.reach import Reach
from estimation.watch.replay import Replayed, Replays
from estimation.watch.state import RETRY_S, LeftOut, WatchState
from estimation.watch.statistics import REPEATED, Statistics
from models.arrays import Array

QUIET_S = 0.3
"""So long no second alarm is followed."""
SPOKEN_S = 1.0
"""So long a sensor is flagged whose bias was freed, or that has just been taken back."""
LONGEST_RETRY_S = 8.0
"""A sensor is first tried after `RETRY_S`, each time that it is blamed again twice that."""
FORGIVEN_S = 10.0
"""A sensor that has been right for so long has never been blamed."""


class Adopting:
    """Replays the past of a watch, and adopts what becomes of it."""

    def __init__(self, replays: Replays, statistics: Statistics, reach: Reach) -> None:
        self._replays, self._statistics, self._reach = replays, statistics, reach

    def replay(
        self, state: WatchState, start: Anchor, hypothesis: Hypothesis, undropped: frozenset[int]
    ) -> Replayed | None:
        """Return what becomes of a state's rows, see `Replays.replayed`."""
        return self._replays.replayed(
            state.past,
            start,
            hypothesis,
            reach=self._reach,
            prior=state.prior,
            level=state.level,
            undropped=undropped,
        )

    def adopted(self, state: WatchState, t: float, found: Replayed) -> WatchState:
        """Return the state behind a replay: what it found, it goes on with."""
        hypothesis = found.hypothesis
        freed, doubted = state.freed_s.copy(), state.doubted_s.copy()
        blamed = list(state.blamed)
        for i in hypothesis.freed:
            freed[i], doubted[i] = t, t + SPOKEN_S
        memory = self.with_repeats(found.memory, state)
        doubted[list(state.left_out - hypothesis.left_out)] = t + SPOKEN_S
        out = [each for each in state.out if each.sensor in hypothesis.left_out]
        for i in sorted(hypothesis.left_out - state.left_out):
            last_s, wait_s = blamed[i]
            wait_s = RETRY_S if t - last_s > FORGIVEN_S else min(2 * wait_s, LONGEST_RETRY_S)
            out.append(LeftOut(i, t + wait_s))
            blamed[i] = (t, wait_s)
        past = Past((found.anchor,), found.rows)
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
        )

    def with_repeats(self, memory: Array, state: WatchState) -> Array:
        """Return a memory with what readings alone have changed."""
        memory, view = memory.copy(), self._statistics.layout.view
        for block in REPEATED:
            view(memory, block)[:] = view(state.memory, block)
        return memory
