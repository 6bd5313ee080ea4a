"""The estimator interface and the one loop that drives every estimator."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Iterable
from typing import Protocol, TypeVar, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from estimation.collect import BATCH_STEPS, collected
from estimation.estimate import Estimate, EstimateHistory
from estimation.recording import Measurement, Recording
from estimation.status import REGULARITY_LIMIT, Status
from models.arrays import Array
from models.errors import InputError
from models.gaussian import GaussianState
from models.given_prior import Prior, given_prior
from models.state_space import StateSpaceModel

StateT = TypeVar("StateT")


class Estimator(Protocol[StateT]):
    """An estimator: a state that is returned, never changed in place.

    An instance owns its solver's workspace: one per thread, or threads take turns.
    """

    @property
    def name(self) -> str:
        """One of the vocabulary: ``ekf``, ``mhe-ipopt``, …"""

    @property
    def model(self) -> StateSpaceModel:
        """The model that it estimates."""

    def init(self, prior: Prior | None = None) -> StateT:
        """Return the state before the first measurement, from the model's prior or another."""

    def step(self, state: StateT, measurement: Measurement) -> tuple[StateT, Estimate]:
        """Take one measurement; return the new state and the estimate x_k|k."""


@runtime_checkable
class BatchEstimator(Protocol[StateT]):
    """An estimator that also takes many measurements in one compiled call."""

    def batch(
        self,
        state: StateT,
        time_s: Array,
        y: Array,
        *,
        covariances: bool = False,
        on_progress: Callable[[int], None] | None = None,
    ) -> tuple[StateT, EstimateHistory]:
        """Take n measurements, (n,) and (n, n_y); the same as n steps; see `run`."""


@runtime_checkable
class LookingBack(Protocol):
    """An estimator whose steps may tell of earlier instants too."""

    @property
    def lags(self) -> tuple[int, ...]:
        """How many samples before the newest, ascending."""


def run(
    estimator: Estimator[StateT],
    recording: Recording,
    *,
    on_step: Callable[[Estimate], None] | None = None,
    on_progress: Callable[[int], None] | None = None,
    prior: Prior | None = None,
    covariances: bool = False,
    causal: bool = False,
) -> EstimateHistory:
    """Drive an estimator over a recording, in compiled batches where it has them.

    Parameters
    ----------
    on_step : called with every estimate, for a look at windows: step by step then
    on_progress : called with the number of steps made since the last call
    prior : of the first state; None takes the model's. One estimator, built once, serves
        many starts
    covariances : keep them in full, (n, n_x, n_x) and (n, n_r, n_r), not only their standard
        deviations: what `estimation.consistency.nees` needs
    causal : give readings in the order in which they arrive, so that an estimate uses what had
        arrived and never more; see `Recording.as_arrived`. False takes each at its capture

    Raises
    ------
    InputError
        If it is given no estimator or no recording, or one that does not fit its model.
    """
    if not hasattr(estimator, "step") or not isinstance(recording, Recording):
        given = f"{type(estimator).__name__} and {type(recording).__name__}"
        raise InputError(f"run is given {given}, expected an estimator and a recording")
    if on_step is None and isinstance(estimator, BatchEstimator):
        time_s, y, *arrival_s = (recording.as_arrived if causal else recording.stacked)(
            estimator.model
        )
        start = estimator.init(prior)
        _, history = estimator.batch(
            start, time_s, y, covariances=covariances, on_progress=on_progress
        )
        return dataclasses.replace(history, arrival_s=arrival_s[0]) if arrival_s else history

    def told(estimate: Estimate) -> None:
        if on_step:
            on_step(estimate)
        if on_progress:
            on_progress(1)

    measurements = recording.measurements(estimator.model, causal=causal)
    return run_measurements(
        estimator, measurements, on_step=told, prior=prior, covariances=covariances
    )


def run_measurements(
    estimator: Estimator[StateT],
    measurements: Iterable[Measurement],
    *,
    on_step: Callable[[Estimate], None] | None = None,
    prior: Prior | None = None,
    covariances: bool = False,
) -> EstimateHistory:
    """Drive an estimator over any stream of measurements, a live one included; see `run`.

    They are taken in the order in which they come: that of their arrival.
    """
    start = estimator.init(prior)
    return stepped_through(
        estimator, start, measurements, on_step=on_step, covariances=covariances
    )[1]


def stepped_through(
    estimator: Estimator[StateT],
    state: StateT,
    measurements: Iterable[Measurement],
    *,
    on_step: Callable[[Estimate], None] | None = None,
    covariances: bool = False,
) -> tuple[StateT, EstimateHistory]:
    """Step from a state through measurements; return the state behind them, and the history."""
    lags = estimator.lags if isinstance(estimator, LookingBack) else ()
    parts: list[EstimateHistory] = []
    estimates: list[Estimate] = []
    step_times: list[float] = []
    arrivals: list[float] = []

    def reduce() -> None:
        part = collected(
            estimator.name,
            estimator.model,
            estimates,
            step_times,
            covariances=covariances,
            lags=lags,
        )
        parts.append(dataclasses.replace(part, arrival_s=np.array(arrivals)))
        for kept in (estimates, step_times, arrivals):
            kept.clear()

    for measurement in measurements:
        start = time.perf_counter()
        state, estimate = estimator.step(state, measurement)
        step_times.append(time.perf_counter() - start)
        estimates.append(estimate)
        arrival_s = measurement.arrival_s
        arrivals.append(estimate.time_s if arrival_s is None else arrival_s)
        if on_step:
            on_step(estimate)
        if len(estimates) == BATCH_STEPS:
            reduce()
    if estimates or not parts:
        reduce()
    return state, EstimateHistory.joined(parts)


def first_state(model: StateSpaceModel, prior: Prior | None) -> GaussianState:
    """Return the prior to start from, the model's where none is given; see `given_prior`.

    Its covariance is made symmetric to the last bit, which rounding may have left it without.

    Raises
    ------
    InputError
        If the prior is none of the model's states.
    """
    given = model.prior if prior is None else prior
    return given_prior(model.name, model.state_names, model.prior, given)


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
    y : (n_row,) the readings of the step, and inputs behind them
    used : (n_r,) the rows of the residual that were used
    """
    status = Status.SOLVED if used[model.measured_rows].any() else Status.NO_READING
    y = y[: model.n_y]
    if np.isinf(y).any():
        status |= Status.INFINITE_READING
    if (np.isfinite(y) & (np.abs(y) >= model.saturation)).any():
        status |= Status.SATURATED
    if abs(float(model.regularity(state.mean))) < REGULARITY_LIMIT:
        status |= Status.NEAR_SINGULAR
    if model.reach is not None and (np.diag(state.covariance) > model.reach**2).any():
        status |= Status.OUT_OF_REACH
    return status
