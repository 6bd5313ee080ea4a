"""Steps of a watch that keep to a deadline.

A step whose alarm is not through in time is made again in the next ones, from what it has found
out (`estimation.watch.deadline`). Meanwhile measurements are taken as they come, and no alarm is
followed. Once the step is through, the rows that have come since are taken again behind it: then
the watch knows what it would without a deadline. Where that lasts too long the alarm is given up,
and has no cause.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from estimation.estimate import Estimate
from estimation.frozen import changed
from estimation.recording import Measurement
from estimation.watch.adopting import QUIET_S
from estimation.watch.deadline import OutOfTimeError, Spending
from estimation.watch.remembered import RememberedReplays
from estimation.watch.state import RETRY_S, WatchState

Look = Callable[[WatchState, Measurement], tuple[WatchState, Estimate]]


@dataclass(frozen=True, eq=False)
class Pending:
    """What a watch has still to do.

    Parameters
    ----------
    state : before the first of these rows
    rows : the first is that of an alarm
    """

    state: WatchState
    rows: tuple[Measurement, ...]


class InTime:
    """Looks at rows, each within a deadline and a step.

    Parameters
    ----------
    look : takes a row, and follows its alarm
    replays : what alarms are followed with
    longest_s : that an alarm may last
    """

    def __init__(
        self, look: Look, replays: RememberedReplays, spending: Spending, *, longest_s: float
    ) -> None:
        self._look, self._replays, self._spending = look, replays, spending
        self._longest_s = longest_s

    def look(self, state: WatchState, measurement: Measurement) -> tuple[WatchState, Estimate]:
        """Take a row in which something stands out, or behind one."""
        self._spending.begin()
        measurement = dataclasses.replace(measurement, y=measurement.y.copy())
        meanwhile: tuple[WatchState, Estimate] | None = None
        exact, rows = state, tuple[Measurement, ...]((measurement,))
        if state.pending is not None:
            exact, rows = state.pending.state, (*state.pending.rows, measurement)
            meanwhile = self._meanwhile(state, measurement)
        try:
            while True:
                self._replays.ask_for(exact)
                exact, estimate = self._look(exact, rows[0])
                rows = rows[1:]
                if not rows:
                    return exact, estimate
                self._spending.check()
        except OutOfTimeError:
            state, estimate = meanwhile or self._meanwhile(state, measurement)
        newest_s = rows[-1].time_s
        if newest_s - rows[0].time_s <= self._longest_s:
            return changed(state, pending=Pending(exact, rows)), estimate
        out = tuple(dataclasses.replace(each, retry_s=newest_s + RETRY_S) for each in state.out)
        given_up = changed(state, pending=None, out=out, is_unexplained=True)
        return changed(given_up, quiet_s=newest_s + QUIET_S, alarm_s=np.inf), estimate

    def _meanwhile(
        self, state: WatchState, measurement: Measurement
    ) -> tuple[WatchState, Estimate]:
        """Take a row, and follow no alarm."""
        out = tuple(dataclasses.replace(each, retry_s=np.inf) for each in state.out)
        return self._look(changed(state, out=out, quiet_s=np.inf, pending=None), measurement)
