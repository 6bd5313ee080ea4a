"""A contender, whoever it is, and what it says of a recording."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol, Self

import numpy as np
from numpy.typing import NDArray

from estimation.estimator import run
from estimation.history import EstimateHistory
from estimation.recording import Recording
from models.arrays import Array
from models.gaussian import GaussianState
from pen_mhe.estimators import create_estimator, settings_read
from suites.classics.recordings import model_of, settings


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


class ClassicContender(Protocol):
    """Built once for a problem, whatever becomes of its recordings."""

    def estimates(self, recording: Recording, prior: GaussianState) -> Estimates:
        """Return what it makes of a recording, from a prior."""


class OwnContender:
    """An estimator of the product with the problem's N, and settings beside it."""

    def __init__(self, name: str, case: str, **more: Any) -> None:
        chosen = settings_read(name, settings(case))
        self._estimator = create_estimator(name, model_of(case), **chosen, **more)

    def estimates(self, recording: Recording, prior: GaussianState) -> Estimates:
        """Return what it makes of a recording."""
        return Estimates.of(run(self._estimator, recording, prior=prior))
