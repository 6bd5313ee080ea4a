"""What a run in parts tells of instants: as `estimate_recording` does of a whole one.

Without a lag a row speaks of its newest instant, with one of an earlier instant. Of a causal run
only the instants of one sensor count, each as it was told first.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from estimation.estimate import EstimateHistory
from models.arrays import Array


class Telling(Protocol):
    """Takes the parts of a history and returns what they tell."""

    @property
    def since_s(self) -> float:
        """No later part speaks of an instant before this one."""

    def take(self, history: EstimateHistory, times: Array) -> EstimateHistory:
        """Return what the next part tells.

        Parameters
        ----------
        times : (n,) instants of the sensor, from `since_s` on to the newest of the part
        """


class InCaptureOrder:
    """Of a run in order of capture: all rows, at a lag."""

    def __init__(self, lag: int) -> None:
        self._lag, self._newest = lag, np.zeros(0)

    @property
    def since_s(self) -> float:
        """See `Telling`."""
        return float(self._newest[0]) if len(self._newest) else -np.inf

    def take(self, history: EstimateHistory, times: Array) -> EstimateHistory:
        """See `Telling`."""
        self._newest = np.append(self._newest, history.time_s)[-self._lag - 1 :]
        return history.at_lag(self._lag)


class AsArrived:
    """Of a causal run: one row per instant that was the newest when it arrived, at a lag."""

    def __init__(self, lag: int) -> None:
        self._lag, self._newest_s = lag, -np.inf
        self._unfollowed = np.zeros(0)

    @property
    def since_s(self) -> float:
        """See `Telling`."""
        return float(self._unfollowed[0]) if len(self._unfollowed) else self._newest_s

    def take(self, history: EstimateHistory, times: Array) -> EstimateHistory:
        """See `Telling`."""
        told = times[(times > self._newest_s) & np.isin(times, history.time_s)]
        self._newest_s = max(self._newest_s, float(history.time_s.max()))
        instants = np.append(self._unfollowed, told)
        self._unfollowed = instants[max(len(instants) - self._lag, 0) :]
        if len(instants) <= self._lag:
            return history[:0]
        return history.at_lag_of(self._lag, instants)
