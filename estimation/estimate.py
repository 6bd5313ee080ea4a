"""What an estimator says at one instant; of a whole run, `estimation.history` says it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from estimation.history import EstimateHistory as EstimateHistory  # many take both from here
from estimation.lagged import LaggedState
from estimation.status import Status as Status
from estimation.watch.flags import Flags, not_watched
from models.arrays import Array
from models.gaussian import GaussianState


@dataclass(frozen=True, eq=False)
class Window:
    """The trajectory of a moving horizon: times (N+1,), states (N+1, n_x)."""

    time_s: Array
    states: Array


@dataclass(frozen=True, eq=False)
class Estimate:
    """x_k|k: the state at one instant given all measurements up to it.

    Parameters
    ----------
    time_s : s
    state : mean (n_x,) and covariance (n_x, n_x)
    status : outcome of the step
    innovation : (n_r,) measurement minus prediction, NaN in rows without a reading
    innovation_covariance : (n_r, n_r) S
    iterations : of the solver; 1 for a filter
    window : the moving horizon, for estimators that have one; where `mhe-rti` keeps factors its
        older stages may be off by half of `MheRtiConfig.reuse_threshold` (those in `lagged` not)
    call_s : seconds within the loop's own call, without what Python adds; NaN where there is none
    kkt_residual : how far the window is from its optimality conditions, in standard deviations:
        length of the last pass' step, or what a row of bounds and inequalities is exceeded by,
        whichever is larger; NaN where there is none
    reused_stages : stages whose factors were kept from the step before
    derived, derived_std : (k,) outputs that are not states, with their standard deviations; see
        `estimation.outputs`; None where the estimator leaves them to the history
    lagged : of earlier instants, where the estimator was asked for them (``lag_samples``) and the
        window is that long already
    flagged : (n_sensors,) a bit mask of `estimation.watch.flags.Flag` for each of
        ``model.sensors``; of none where nobody watched
    """

    time_s: float
    state: GaussianState
    status: Status
    innovation: Array
    innovation_covariance: Array
    iterations: int = 1
    window: Window | None = None
    call_s: float = np.nan
    kkt_residual: float = np.nan
    reused_stages: int = 0
    derived: Array | None = None
    derived_std: Array | None = None
    lagged: tuple[LaggedState, ...] = ()
    flagged: Flags = field(default_factory=not_watched)
