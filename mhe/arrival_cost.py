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
    The Gaussian that an EKF carries: the dropped stage is eliminated by one update
    and one prediction. The update is linearised at the Gaussian's own mean, as an
    EKF's; where that would misjudge a reading at the window's estimate by more than
    `RELINEARISATION_LIMIT` of its standard deviations (a bad start), at the window's
    estimate instead. The Gaussian itself never sees a later measurement: nothing is
    counted twice. On a linear model the MHE is then the Kalman filter.

``smoothed``
    The same with the dropped stage always linearised at the window's estimate, which knows
    the readings behind it: the smoothed estimate. Only the linearisation is smoothed. The
    Gaussian holds no reading of the window, so none is counted twice (a smoothed mean and
    covariance as the prior would hold all of them).

    Relinearising always is simpler and often worse: the window's estimate depends on
    the noise of the very reading that is linearised there. On the D-POINT recording
    with its camera at 3 Hz it added about 0.007 mm of ink distance (1.5 %), while never
    relinearising lost a bad start for good.

References
----------
Kaess et al. (2012), iSAM2: incremental smoothing and mapping using the Bayes tree,
Int. J. Robotics Research 31(2), for relinearising only what has moved far enough.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from estimation.kalman_stage import KalmanStage, Update
from estimation.recording import Measurement
from mhe.trajectory import Trajectory
from models.arrays import Array
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel

DIFFUSE_FACTOR = 10.0
RELINEARISATION_LIMIT = 1.0


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
    prior, y, x = slide.prior, slide.dropped.y, slide.trajectory.states[0]
    at_mean = stage.update(prior, y, slide.row_scale)
    at_window = stage.update(prior, y, slide.row_scale, x_lin=x)
    if _misjudged(stage.model, prior.mean, at_mean, x, at_window) > RELINEARISATION_LIMIT:
        return _smoothed(stage, slide)
    dt = slide.first.time_s - slide.dropped.time_s
    inputs = stage.model.step_inputs(slide.dropped.y, slide.first.y)
    known, scale = at_mean.state, slide.noise_scale
    return stage.predict(known, dt, noise_scale=scale, inputs=inputs).state


def _smoothed(stage: KalmanStage, slide: Slide) -> GaussianState:
    x, w = slide.trajectory.states[0], slide.trajectory.noises[0]
    updated = stage.update(slide.prior, slide.dropped.y, slide.row_scale, x_lin=x)
    dt = slide.first.time_s - slide.dropped.time_s
    inputs = stage.model.step_inputs(slide.dropped.y, slide.first.y)
    at = x, w, slide.noise_scale, updated.deviation
    return stage.predict(updated.state, dt, *at, inputs=inputs).state


def _misjudged(
    model: StateSpaceModel, mean: Array, at_mean: Update, x: Array, at_window: Update
) -> float:
    """Return by how many standard deviations a linearisation at the mean is off at x.

    ``r(x)`` is the residual itself, ``r(x̄) - H (x ⊟ x̄)`` what the mean says of it.
    """
    residual = at_window.innovation + at_window.H @ _difference(model, mean, x)
    expected = at_mean.innovation - at_mean.H @ _difference(model, x, mean)
    return float(np.abs((residual - expected) / model.noise_std).max(initial=0.0))


def _difference(model: StateSpaceModel, to: Array, origin: Array) -> Array:
    return np.asarray(model.difference(to, origin)).ravel()


ARRIVAL_COSTS: Mapping[str, ArrivalCost] = MappingProxyType(
    {"none": _none, "constant": _constant, "filtered": _filtered, "smoothed": _smoothed}
)
"""Name → function of the Kalman stage and a slide that returns the new window's prior."""
