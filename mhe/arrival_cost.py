"""Arrival costs: what the window is told about the time before it.

Each is a function of the same arguments, listed in `ARRIVAL_COSTS`.

``none``
    A diffuse prior, the same for every window: the model's prior mean with
    `DIFFUSE_FACTOR` times its standard deviations. The window forgets all that
    came before it.
``constant``
    The model's prior covariance around the estimate of the first stage from
    all measurements before it.
``smoothed``, the default
    The dropped stage is eliminated by one update and one prediction, linearised at the
    window's estimate, which knows the readings behind it: the smoothed estimate. Only the
    linearisation is smoothed. The Gaussian holds no reading of the window, so none is counted twice
    (a smoothed mean and covariance as the prior would hold all of them). On a linear
    model the MHE is then the Kalman filter.
``filtered``
    The same with the dropped stage always linearised at the Gaussian's own mean: what an EKF
    carries. Behind such a prior an MHE fails where an EKF fails, also where only the
    transition is curved. docs/arrival_cost.md has both side by side.

References
----------
Rao, Rawlings, Mayne (2003), Constrained state estimation for nonlinear discrete-time systems,
IEEE Trans. Automatic Control 48(2), for arrival costs. Haseltine, Rawlings (2005), Critical
evaluation of extended Kalman filtering and moving-horizon estimation, Ind. Eng. Chem. Res.
44(8), for where the EKF's fails.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from estimation.kalman_stage import KalmanStage
from estimation.recording import Measurement
from mhe.domain import inside
from mhe.trajectory import Trajectory
from models.arrays import Array
from models.gaussian import GaussianState

DIFFUSE_FACTOR = 10.0


@dataclass(frozen=True, eq=False)
class Slide:
    """What is known when a window drops its oldest stage.

    Parameters
    ----------
    prior : of the dropped stage, given all measurements before it
    dropped, first : measurements of the dropped stage and of the first that stays
    trajectory : of the window, starting at the dropped stage
    predicted : (n_x,) x_k|k-1 of the first stage that stays, when it was the newest
    row_scale, noise_scale : (n_r,), (n_w,) by which the dropped stage's readings and noises
        count; see `mhe.weights`
    """

    prior: GaussianState
    dropped: Measurement
    first: Measurement
    trajectory: Trajectory
    predicted: Array
    row_scale: Array
    noise_scale: Array


ArrivalCost = Callable[[KalmanStage, Slide], GaussianState]


def diffuse(prior: GaussianState) -> GaussianState:
    """Return the documented diffuse prior: `DIFFUSE_FACTOR` times a prior's deviations."""
    return GaussianState(prior.mean, DIFFUSE_FACTOR**2 * prior.covariance)


def _none(stage: KalmanStage, slide: Slide) -> GaussianState:
    return diffuse(stage.model.prior)


def _constant(stage: KalmanStage, slide: Slide) -> GaussianState:
    return GaussianState(slide.predicted, stage.model.prior.covariance)


def _filtered(stage: KalmanStage, slide: Slide) -> GaussianState:
    x_lin = inside(stage.model, slide.prior.mean)
    updated = stage.update(slide.prior, slide.dropped.y, slide.row_scale, x_lin=x_lin)
    x = inside(stage.model, updated.state.mean)
    dt = slide.first.time_s - slide.dropped.time_s
    inputs = stage.model.step_inputs(slide.dropped.y, slide.first.y)
    at = x, None, slide.noise_scale, stage.difference(updated.state.mean, x)
    return stage.predict(updated.state, dt, *at, inputs=inputs).state


def _smoothed(stage: KalmanStage, slide: Slide) -> GaussianState:
    x, w = slide.trajectory.states[0], slide.trajectory.noises[0]
    updated = stage.update(slide.prior, slide.dropped.y, slide.row_scale, x_lin=x)
    dt = slide.first.time_s - slide.dropped.time_s
    inputs = stage.model.step_inputs(slide.dropped.y, slide.first.y)
    at = x, w, slide.noise_scale, updated.deviation
    return stage.predict(updated.state, dt, *at, inputs=inputs).state


ARRIVAL_COSTS: Mapping[str, ArrivalCost] = MappingProxyType(
    {"none": _none, "constant": _constant, "filtered": _filtered, "smoothed": _smoothed}
)
"""Name → function of the Kalman stage and a slide that returns the new window's prior."""
