"""The way back: a sensor that is left out is tried again, and a motion may be calmer by now."""

from __future__ import annotations

from dataclasses import replace

from estimation.estimate import Estimate
from estimation.watch.adopting import Adopting
from estimation.watch.clean_rows import LEVEL_S
from estimation.watch.config import WatchConfig
from estimation.watch.energy import is_calm
from estimation.watch.hypotheses import Causes, Hypothesis
from estimation.watch.livelier import factor_down
from estimation.watch.replay import Replays
from estimation.watch.state import WatchState
from estimation.watch.statistics import Statistics

RETURN_S, RETURNS = 1.0, 0.6
"""A sensor that is left out is taken back when so many seconds with it fit so well."""
AGAIN_S = 0.5
"""So long after it did not, that is tried again."""
FREED_TRIES = 4
"""Each so manieth time its bias may be anything, and the state is begun again."""


class Returning:
    """Undoes what an alarm has changed, where all fits without it."""

    def __init__(
        self,
        causes: Causes,
        replays: Replays,
        adopting: Adopting,
        statistics: Statistics,
        *,
        config: WatchConfig,
    ) -> None:
        self._config, self._causes, self._replays = config, causes, replays
        self._adopting, self._statistics = adopting, statistics

    def tried_again(
        self, state: WatchState, t: float, estimate: Estimate
    ) -> tuple[WatchState, Estimate]:
        """Replay with a sensor that is left out; take it back where all fits."""
        out = next(each for each in state.out if t >= each.retry_s)
        has_freed = (out.tries + 1) % FREED_TRIES == 0
        back_s = self._config.replay_s if has_freed else min(RETURN_S, self._config.replay_s)
        start = self._replays.start(state.past, state.level, back_s)
        hypotheses = self._causes.returning(
            state.left_out - {out.sensor},
            out.sensor,
            state.level,
            has_freed=has_freed,
            may_restart=self._config.on_lost == "restart",
        )
        for hypothesis in hypotheses:
            found = self._adopting.replay(state, start, hypothesis, frozenset({out.sensor}))
            if found is not None and found.score < RETURNS:
                return self._adopting.adopted(state, t, found), found.estimate
        again = replace(out, retry_s=t + AGAIN_S, tries=out.tries + 1)
        rest = tuple(again if each is out else each for each in state.out)
        return replace(state, out=rest), estimate

    def calmer(
        self, state: WatchState, t: float, estimate: Estimate
    ) -> tuple[WatchState, Estimate]:
        """Go down a level of motion where all that moves would fit there."""
        if state.level == 0 or t - state.level_s < LEVEL_S:
            return state, estimate
        factor = factor_down(state.level)
        if not is_calm(self._statistics, state.memory, factor, left_out=state.left_out):
            return state, estimate
        start = self._replays.start(state.past, state.level, self._config.replay_s)
        hypothesis = Hypothesis(state.left_out, level=state.level - 1)
        found = self._adopting.replay(state, start, hypothesis, frozenset())
        if found is not None and found.fits:
            return self._adopting.adopted(state, t, found), found.estimate
        return replace(state, level_s=t), estimate
