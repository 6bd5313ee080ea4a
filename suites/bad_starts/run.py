"""Bad starts of a pen: who finds the truth within the first second, and who never does.

An estimator is told a start whose attitude is wrong by a known angle about a drawn axis, and a
standard deviation that says so. Gravity then shows the truth, but not linearly: at a tilt δ the
reading is off by about g δ²/2 (1.3 m/s² at 30°) from what a linearised update expects. An EKF
hands that remainder to whatever else may explain it, accelerations of the tip and biases, and
is sure of them from then on. An MHE looks at its first readings again, from where it has got to.
What is left of its error does not depend on the start: it is what the sensors can say, given
what else may happen (`suites.bad_starts.cases.KNOWLEDGE`).

Judged is the direction of up, seen from the body: the heading is seen by nothing but a camera.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from estimation.estimate import EstimateHistory
from estimation.estimator import Estimator, run
from models.arrays import Array
from models.free_pen import SIGMA
from models.gaussian import GaussianState
from models.pen_body import headings, rates_and_attitudes
from models.priors import replaced_attitude, replaced_prior
from models.random_streams import seed_sequence, stream
from models.state_space import StateSpaceModel
from pen_mhe.estimators import create_estimator
from suites.bad_starts.cases import BadStart, case_model, case_pen, case_recording

FIRST_S = 1.0
ELEVATION = "elevation_rad"


@dataclass(frozen=True, eq=False)
class BadStartRun:
    """One run of one estimator.

    Parameters
    ----------
    seed : of motion, noise, biases and the start's axis or sign
    start_error_rad : of the prior
    time_s : (n,)
    error, std : (n,) rad; the angle between true and estimated up, and its standard deviation
        as claimed, in the error's own direction
    rate_error : (n,) rad/s, length of the error of the judged body rates
    step_time_s : (n,)
    solved_fraction : of the steps
    """

    seed: int
    start_error_rad: float
    time_s: Array
    error: Array
    std: Array
    rate_error: Array
    step_time_s: Array
    solved_fraction: float

    @property
    def is_first(self) -> NDArray[np.bool_]:
        """Which samples (n,) are of the first second."""
        return self.time_s <= self.time_s[0] + FIRST_S

    def at(self, values: Array, after_s: float) -> float:
        """Return the value (n,) that long after the first sample; NaN where the run is over."""
        later = np.flatnonzero(self.time_s >= self.time_s[0] + after_s - 1e-9)
        return float(values[later[0]]) if len(later) else float("nan")


def run_bad_start(
    case: BadStart, estimator: str, seed: int, settings: Mapping[str, Any] | None = None
) -> BadStartRun:
    """Run one estimator from one wrong start.

    A seed is one recording and one start, the same for every estimator.
    """
    recording, pen, model = case_recording(case, seed), case_pen(case), case_model(case)
    truth = recording.truth
    assert truth is not None
    true = truth.states(model.state_names, recording.time_s)
    start_error, told = wrong_start(case, model, true[0], seed)
    blind = replace(recording, truth=None)  # no estimator is given the truth
    if settings is None:
        chosen = _kept(replace(case, label="", wrong_deg=0.0, told_std_deg=None), estimator)
    else:
        chosen = create_estimator(estimator, model, **settings)
    history = run(chosen, blind, prior=told, covariances=True)
    rates, B = rates_and_attitudes(pen, history.mean)
    true_rates, true_B = rates_and_attitudes(pen, true)
    tilt = tilt_vectors(B, true_B)
    judged = ["xyz".index(axis) for axis in case.rate_axes]
    return BadStartRun(
        seed,
        start_error,
        history.time_s,
        np.linalg.norm(tilt, axis=1),
        claimed_std(history, tilt),
        np.linalg.norm((rates - true_rates)[:, judged], axis=1),
        history.step_time_s,
        history.solved_fraction,
    )


def wrong_start(
    case: BadStart, model: StateSpaceModel, true: Array, seed: int
) -> tuple[float, GaussianState]:
    """Return the error of the start, rad, and the prior that says no more than it knows.

    Parameters
    ----------
    true : (n_x,) the first state
    """
    wrong_rad, root = float(np.radians(case.wrong_deg)), seed_sequence(seed)
    if model.outputs is None:
        sign = float(stream(root, "sign of the start").choice([-1.0, 1.0]))
        elevation = true[model.state_names.index(ELEVATION)] + sign * wrong_rad
        return sign * wrong_rad, replaced_prior(model, {ELEVATION: elevation}, case.std_rad)
    axis = stream(root, "axis of the start").standard_normal(3)
    _, B = rates_and_attitudes(case_pen(case), true[None])
    turn = Rotation.from_rotvec(wrong_rad * axis / np.linalg.norm(axis))
    return wrong_rad, replaced_attitude(model, B[0].T @ turn.as_matrix(), case.std_rad)


@lru_cache(maxsize=16)
def _kept(case: BadStart, estimator: str) -> Estimator[Any]:
    """Return an estimator that serves every start of a case: one is slow to build."""
    return create_estimator(estimator, case_model(case))


def tilt_vectors(B: Array, true_B: Array) -> Array:
    """Return the turn (n, 2) about the world's x and y that up is off by, rad.

    Its length is the angle between true and estimated up as the body sees them. R B_true e_z is
    where the estimate takes true up to be; it is e_z turned by τ, whatever the heading.

    Parameters
    ----------
    B, true_B : (n, 3, 3) world to body
    """
    seen = np.einsum("nji,nj->ni", B, true_B[:, :, 2])
    level = np.linalg.norm(seen[:, :2], axis=1)
    angle = np.arctan2(level, seen[:, 2])
    across = np.stack([-seen[:, 1], seen[:, 0]], axis=1)
    # Upside down every direction is as good as another.
    unit = np.where(level[:, None] > 0, across / np.maximum(level, 1e-300)[:, None], [1.0, 0.0])
    return np.asarray(angle[:, None] * unit)


def claimed_std(history: EstimateHistory, tilt: Array) -> Array:
    """Return the claimed standard deviation (n,), rad, of up in the direction of its error.

    Error over deviation is the Mahalanobis distance: the covariance of the attitude, in world
    axes, without the heading.
    """
    if history.outputs is None:
        return history.std_of(ELEVATION)
    N = headings(history.mean)
    P = (N @ history.covariance[:, SIGMA, SIGMA] @ N.transpose(0, 2, 1))[:, :2, :2]
    length = np.linalg.norm(tilt, axis=1)
    unit = np.where(length[:, None] > 0, tilt / np.maximum(length, 1e-300)[:, None], [1.0, 0.0])
    solved = np.linalg.solve(P, unit[:, :, None])[:, :, 0]
    return np.asarray(1 / np.sqrt((unit * solved).sum(axis=1)))
