"""What a step says of an instant before its newest: an estimate at a fixed lag."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from models.arrays import Array
from models.gaussian import GaussianState


@dataclass(frozen=True, eq=False)
class LaggedState:
    """x_k-L|k: the state some samples before the newest, given all readings up to the newest.

    Parameters
    ----------
    lag : L, in samples
    time_s : of which it speaks, s
    state : mean (n_x,) and covariance (n_x, n_x), smoothed; NaN in the covariance where a deadline
        left no time for a pass
    """

    lag: int
    time_s: float
    state: GaussianState


@dataclass(frozen=True, eq=False)
class LaggedEstimates:
    """What the n steps of a run said at one lag, NaN in steps that had no such instant yet.

    Parameters
    ----------
    time_s : (n,) of which they speak, s
    mean, std : (n, n_x)
    derived, derived_std : (n, k), see `estimation.outputs`
    covariance : (n, n_x, n_x), where the run kept them
    """

    time_s: Array
    mean: Array
    std: Array
    derived: Array
    derived_std: Array
    covariance: Array | None = None

    def arrays(self) -> list[Array]:
        """Return all arrays, each with an entry per step."""
        plain = [self.time_s, self.mean, self.std, self.derived, self.derived_std]
        return plain if self.covariance is None else [*plain, self.covariance]

    def changed(self, change: Callable[[Array], Array]) -> LaggedEstimates:
        """Return a copy with each array changed."""
        return replace(
            self,
            time_s=change(self.time_s),
            mean=change(self.mean),
            std=change(self.std),
            derived=change(self.derived),
            derived_std=change(self.derived_std),
            covariance=None if self.covariance is None else change(self.covariance),
        )


def chosen(offered: Sequence[LaggedEstimates], which: NDArray[np.intp]) -> LaggedEstimates:
    """Return in each row (n,) what one of several lags says there."""
    rows = np.arange(len(which))
    columns = zip(*(each.arrays() for each in offered), strict=True)
    return LaggedEstimates(*(np.array(arrays)[which, rows] for arrays in columns))
