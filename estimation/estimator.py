"""The estimator interface and the one loop that drives every estimator."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from estimation.estimate import Estimate, EstimateHistory
from estimation.recording import Measurement, Recording
from estimation.status import REGULARITY_LIMIT, Status
from models.arrays import Array
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel

StateT = TypeVar("StateT")


class Estimator(Protocol[StateT]):
    """An estimator: a state that is returned, never changed in place.

    An instance owns its solver's workspace: one per thread or process.
    """

    @property
    def name(self) -> str:
        """One of the vocabulary: ``ekf``, ``mhe-ipopt``, …"""

    @property
    def model(self) -> StateSpaceModel:
        """The model that it estimates."""

    def init(self) -> StateT:
        """Return the state before the first measurement, from the model's prior."""

    def step(self, state: StateT, measurement: Measurement) -> tuple[StateT, Estimate]:
        """Take one measurement; return the new state and the estimate x_k|k."""


def run(
    estimator: Estimator[StateT],
    recording: Recording,
    on_step: Callable[[Estimate], None] | None = None,
) -> EstimateHistory:
    """Drive an estimator over a recording.

    Parameters
    ----------
    on_step : called with every estimate, for progress and for a look at windows
    """
    return run_measurements(estimator, recording.measurements(estimator.model), on_step)


def run_measurements(
    estimator: Estimator[StateT],
    measurements: Iterable[Measurement],
    on_step: Callable[[Estimate], None] | None = None,
) -> EstimateHistory:
    """Drive an estimator over any stream of measurements, a live one included."""
    state = estimator.init()
    estimates, step_times = [], []
    for measurement in measurements:
        start = time.perf_counter()
        state, estimate = estimator.step(state, measurement)
        step_times.append(time.perf_counter() - start)
        estimates.append(estimate)
        if on_step:
            on_step(estimate)
    return EstimateHistory.collect(estimator.name, estimator.model, estimates, step_times)


def late_estimate(model: StateSpaceModel, time_s: float, state: GaussianState) -> Estimate:
    """Return the estimate of a step that was given a measurement older than its state."""
    missing = np.full((model.n_r, model.n_r), np.nan)
    return Estimate(time_s, state, Status.LATE, missing[:, 0], missing, iterations=0)


def remarks(
    model: StateSpaceModel, state: GaussianState, y: Array, used: NDArray[np.bool_]
) -> Status:
    """Return the remarks that any estimator makes on an estimate.

    Parameters
    ----------
    state : the estimate
    y : (n_y,) the readings of the step
    used : (n_r,) the rows of the residual that were used
    """
    status = Status.SOLVED if used[model.measured_rows].any() else Status.NO_READING
    if np.isinf(y).any():
        status |= Status.INFINITE_READING
    if (np.isfinite(y) & (np.abs(y) >= model.saturation)).any():
        status |= Status.SATURATED
    if abs(float(model.regularity(state.mean))) < REGULARITY_LIMIT:
        status |= Status.NEAR_SINGULAR
    if model.reach is not None and (np.diag(state.covariance) > model.reach**2).any():
        status |= Status.OUT_OF_REACH
    return status
