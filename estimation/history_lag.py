"""A history of what the steps said of the instants some samples before."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from estimation.covariances import Covariances
from estimation.lagged import LaggedEstimates, chosen
from models.arrays import Array
from models.errors import InputError
from models.frozen_mapping import FrozenMapping


def no_innovations(history: Any) -> dict[str, Any]:
    """Return the innovations of a history, all NaN: a smoothed estimate has seen its readings."""
    names = ("innovation", "innovation_std", "squared_innovations")
    return {name: np.full_like(getattr(history, name), np.nan) for name in names}


class AtLag:
    """Estimates at a lag; the arrays are `estimation.history.EstimateHistory`'s."""

    if TYPE_CHECKING:
        estimator: str
        time_s: Array
        lagged: Mapping[int, LaggedEstimates]

        def at(self, time_s: Array) -> Self:
            """See `estimation.history_instants.AtInstants`."""

    def at_lag(self, lag: int) -> Self:
        """Return the estimates of the instants `lag` samples before each step's newest.

        Each row bears the time that it speaks of, and knows all readings of `lag` further samples
        (instants of the recording, of any sensor). The last `lag` instants have no row, for they
        were never followed by so many; neither have instants that a late measurement or a
        window begun anew took the lag from. Status and times are those of the step that says it. A
        smoothed estimate has seen its readings: it has no innovation.

        A reading that comes later than the instant that is spoken of has it told again, and surer:
        `first_told` has each instant once, as errors and figures do.

        Parameters
        ----------
        lag : one that the estimator was asked for, ``create_estimator(…, lag_samples=lag)``; 0 is
            this history

        Raises
        ------
        InputError
            If the history does not have this lag.
        """
        if lag == 0:
            return self
        if lag not in self.lagged:
            kept = ", ".join(map(str, (0, *self.lagged)))
            raise InputError(
                f"this history of {self.estimator} has no estimates at lag {lag!r}, expected one "
                f"of {kept}: others are asked for with lag_samples, which the moving-horizon "
                "estimators read"
            )
        whole: Any = self
        told = np.isfinite(self.lagged[lag].time_s)
        return _speaking(whole[told], self.lagged[lag].changed(lambda array: array[told]))

    def at_lag_of(self, lag: int, instants: Array) -> Self:
        """Return the estimates of instants, each as known when the `lag`-th after it arrived.

        The instants are those of one sensor, an IMU: `at_lag` counts stages of the window, of any
        sensor and as many as had arrived by then, this one counts theirs. A row is what was first
        told at the later instant, see `at`, by whichever of the history's lags speaks of the
        earlier one. The last `lag` have no row, nor has one that the window of that step did not
        hold.

        Parameters
        ----------
        lag : 0 or more
        instants : (n,) increasing, of the run, s

        Raises
        ------
        InputError
            If the lag is negative, there is no estimate at one of them, or one lies further back
            than the largest lag.
        """
        if lag < 0:
            raise InputError(f"a lag of {lag} samples, expected 0 or more")
        instants = np.asarray(instants, dtype=float)
        if lag == 0:
            return self.at(instants)
        known: Any = self.at(instants[lag:])
        spoken_of, lags = instants[: len(known)], sorted(self.lagged)
        offered = [_of_newest(known), *(known.lagged[each] for each in lags)]
        times = np.array([each.time_s for each in offered])
        beyond = times[-1] > spoken_of
        if beyond.any():
            row, most = int(np.argmax(beyond)), max(lags, default=0)
            raise InputError(
                f"{spoken_of[row]:g} s lies more than {most} instants of all sensors before "
                f"{instants[lag:][row]:g} s, expected larger lag_samples too (several may be given)"
            )
        found = (times == spoken_of).any(axis=0)
        which = (times == spoken_of).argmax(axis=0)
        return _speaking(known[found], chosen(offered, which).changed(lambda array: array[found]))


def _of_newest(history: Any) -> LaggedEstimates:
    """Return what the steps said of their newest instants, as if at lag 0."""
    kept = history.covariances
    return LaggedEstimates(
        history.time_s,
        history.mean,
        history.std,
        history.derived,
        history.derived_std,
        kept and kept.state,
    )


def _speaking(rows: Any, earlier: LaggedEstimates) -> Any:
    """Return a history whose rows speak of other instants: smoothed, so without innovations."""
    P, S = earlier.covariance, rows.covariances
    return dataclasses.replace(
        rows,
        time_s=earlier.time_s,
        mean=earlier.mean,
        std=earlier.std,
        derived=earlier.derived,
        derived_std=earlier.derived_std,
        **no_innovations(rows),
        covariances=None
        if P is None or S is None
        else Covariances(P, np.full_like(S.innovation, np.nan)),
        lagged=FrozenMapping(),
    )
