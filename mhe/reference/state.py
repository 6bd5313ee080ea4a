"""A window's state between two measurements, for the estimator that IPOPT solves."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from estimation.recording import Measurement
from mhe.trajectory import Trajectory
from models.arrays import Array
from models.gaussian import GaussianState


@dataclass(frozen=True, eq=False)
class MheState:
    """The window before the next measurement.

    Parameters
    ----------
    prior : of the window's first stage, given all measurements before it
    measurements : the window's stages, at most N + 1
    predictions : per stage, (n_x,): x_k|k-1 when it was the newest
    trajectory : the last solution; None before the first measurement
    newest : the last estimate, or the prior before the first measurement
    rest : what the detector of rest remembers, see `estimation.rest.rest_blocks`
    wait : samples that the next second start waits, see `mhe.second_start`
    """

    prior: GaussianState
    measurements: tuple[Measurement, ...]
    predictions: tuple[Array, ...]
    trajectory: Trajectory | None
    newest: GaussianState
    rest: Array = field(default_factory=lambda: np.zeros(0))
    wait: int = 0
