"""What a contender says of a recording, whoever it is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from estimation.history import EstimateHistory
from models.arrays import Array


@dataclass(frozen=True, eq=False)
class Estimates:
    """Estimates at the instants of a recording.

    Parameters
    ----------
    mean, std : (n, n_x) states and their claimed deviations, NaN of what claims none
    is_solved : (n,) whether the step was
    step_time_s : (n,)
    claims : whether it claims deviations
    """

    mean: Array
    std: Array
    is_solved: NDArray[np.bool_]
    step_time_s: Array
    claims: bool = True

    @classmethod
    def of(cls, history: EstimateHistory) -> Self:
        """Return an estimator's."""
        is_solved = np.array([status.is_solved for status in history.status])
        return cls(history.mean, history.std, is_solved, history.step_time_s)

    @property
    def is_finite(self) -> NDArray[np.bool_]:
        """(n,) whether all that it says is a number."""
        said = (self.mean, self.std) if self.claims else (self.mean,)
        return np.asarray(np.all([np.isfinite(values).all(axis=1) for values in said], axis=0))
