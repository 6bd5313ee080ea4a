"""A history of what the steps said of the instants some samples before."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from estimation.covariances import Covariances
from estimation.lagged import LaggedEstimates
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
        lagged: Mapping[int, LaggedEstimates]

    def at_lag(self, lag: int) -> Self:
        """Return the estimates of the instants `lag` samples before each step's newest.

        Each row bears the time that it speaks of, and knows all readings of `lag` further samples
        (instants of the recording, of any sensor). The last `lag` instants have no row, for they
        were never followed by so many; neither have instants that a late measurement or a
        window begun anew took the lag from. Status and times are those of the step that says it. A
        smoothed estimate has seen its readings: it has no innovation.

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
        rows, earlier = whole[told], self.lagged[lag].changed(lambda array: array[told])
        P, S = earlier.covariance, rows.covariances
        at_lag: Self = dataclasses.replace(
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
        return at_lag
