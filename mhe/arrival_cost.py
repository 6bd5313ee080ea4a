"""Arrival costs: what the window is told about the time before it.

Each is a function of the same arguments, listed in `ARRIVAL_COSTS`.

``none``
    A diffuse prior, the same for every window: the model's prior mean with
    `DIFFUSE_FACTOR` times its standard deviations. The window forgets all that
    came before it.
``constant``
    The model's prior covariance around the estimate of the first stage from
    all measurements before it.
``filtered``
    The Gaussian that the Kalman stage carries: the dropped stage is eliminated
    by one update and one prediction, linearised at the window's trajectory.
    The linearisation point knows later measurements, the Gaussian does not:
    nothing is counted twice. On a linear model the MHE is then the Kalman filter.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

from estimation.kalman_stage import KalmanStage
from estimation.recording import Measurement
from mhe.window import Trajectory
from models.state_space import Array, GaussianState, StateSpaceModel

DIFFUSE_FACTOR = 10.0

ArrivalCost = Callable[
    [KalmanStage, GaussianState, Measurement, Measurement, Trajectory, Array], GaussianState
]


def diffuse_prior(model: StateSpaceModel) -> GaussianState:
    """Return the documented diffuse prior: `DIFFUSE_FACTOR` times the prior's deviations."""
    return GaussianState(model.prior.mean, DIFFUSE_FACTOR**2 * model.prior.covariance)


def _none(
    stage: KalmanStage,
    prior: GaussianState,
    dropped: Measurement,
    first: Measurement,
    trajectory: Trajectory,
    predicted: Array,
) -> GaussianState:
    return diffuse_prior(stage.model)


def _constant(
    stage: KalmanStage,
    prior: GaussianState,
    dropped: Measurement,
    first: Measurement,
    trajectory: Trajectory,
    predicted: Array,
) -> GaussianState:
    return GaussianState(predicted, stage.model.prior.covariance)


def _filtered(
    stage: KalmanStage,
    prior: GaussianState,
    dropped: Measurement,
    first: Measurement,
    trajectory: Trajectory,
    predicted: Array,
) -> GaussianState:
    x, w = trajectory.states[0], trajectory.noises[0]
    updated = stage.update(prior, dropped.y, x_lin=x).state
    return stage.predict(updated, first.time_s - dropped.time_s, x_lin=x, w_lin=w)


ARRIVAL_COSTS: Mapping[str, ArrivalCost] = MappingProxyType(
    {"none": _none, "constant": _constant, "filtered": _filtered}
)
"""Name → function of (stage, the window's prior, the dropped measurement, the first
that stays, the window's trajectory, the prediction x_k|k-1 (n_x,) made for the first
stage that stays when it was the newest) → the new window's prior."""
