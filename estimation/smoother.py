"""Over a whole recording, forth and back: what a filter said, by all that was read later.

Rauch, Tung and Striebel's smoother on the filter's own estimates, linearised where it predicted:

    C = P⁺ Fᵀ (P⁻)⁻¹,   x_s = x⁺ ⊞ C (x_s' ⊟ x⁻)
    P_s = (I - C F) P⁺ (I - C F)ᵀ + C (P_s' + G Gᵀ) Cᵀ

with x_s', P_s' of the next instant. In this form P_s is a sum: it stays a covariance whatever
rounding makes of C. It needs no readings, so gates, rest and a first update by parts are as the
filter had them.

References
----------
Särkkä (2013), Bayesian Filtering and Smoothing, Algorithm 9.1.
"""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
from scipy.linalg import LinAlgError, cho_factor, cho_solve, pinvh

from estimation.covariances import Covariances
from estimation.estimate import EstimateHistory
from estimation.history_lag import no_innovations
from estimation.inputs import all_with_inputs
from estimation.kalman_stage import KalmanStage, Prediction
from estimation.outputs import derived_outputs
from estimation.recording import Recording
from models.arrays import Array
from models.errors import InputError
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel


def smoothed(
    model: StateSpaceModel, recording: Recording, history: EstimateHistory
) -> EstimateHistory:
    """Return a filter's estimates, each by all readings of the recording.

    Parameters
    ----------
    history : of a filter over this recording, with its covariances; the last estimate stays

    Raises
    ------
    InputError
        If the history has no covariances, other instants than the recording, or is of a causal
        run with late readings.
    """
    P_plus = history.covariance
    if not np.array_equal(history.arrival_s, history.time_s):
        raise InputError(
            "a smoother goes back over estimates in order of capture, but late readings have made "
            "some of these, expected a run that is not causal"
        )
    if not np.array_equal(history.time_s, recording.time_s):
        raise InputError(
            f"a history of {len(history)} steps on a recording of {len(recording.time_s)} "
            "instants, expected one estimate at each of its instants"
        )
    stage, rows = KalmanStage(model), all_with_inputs(model, recording.measurements(model))
    mean, P, took = history.mean.copy(), P_plus.copy(), history.step_time_s.copy()
    for k in reversed(range(len(mean) - 1)):
        began = time.perf_counter()
        known = GaussianState(history.mean[k], P_plus[k])
        dt = float(history.time_s[k + 1] - history.time_s[k])
        inputs = model.step_inputs(rows[k].y, rows[k + 1].y)
        ahead = stage.predict(known, dt, inputs=inputs)
        later = GaussianState(mean[k + 1], P[k + 1])
        mean[k], P[k] = _back(stage, known, ahead, later)
        took[k] += time.perf_counter() - began
    outputs = derived_outputs(model).values(mean, P)
    return replace(
        history,
        estimator=f"{history.estimator} smoothed",
        mean=mean,
        std=np.sqrt(np.diagonal(P, axis1=1, axis2=2)),
        derived=outputs[0],
        derived_std=outputs[1],
        step_time_s=took,
        **no_innovations(history),
        covariances=Covariances(P, np.full_like(history.innovation_covariance, np.nan)),
    )


def _back(
    stage: KalmanStage, known: GaussianState, ahead: Prediction, later: GaussianState
) -> tuple[Array, Array]:
    """Return mean and covariance of an instant from what is known there, and of the next one."""
    P, F, G = known.covariance, ahead.F, ahead.G
    C = _times_inverse(P @ F.T, ahead.state.covariance)
    kept = np.eye(len(P)) - C @ F
    moved = C @ stage.difference(later.mean, ahead.state.mean)
    P_s = kept @ P @ kept.T + C @ (later.covariance + G @ G.T) @ C.T
    return stage.retract(known.mean, moved), (P_s + P_s.T) / 2


def _times_inverse(A: Array, P: Array) -> Array:
    """Return A P⁻¹, in units of the standard deviations of P."""
    std = np.sqrt(np.diag(P))
    std = np.where(std > 0, std, 1.0)
    R = P / np.outer(std, std)
    try:
        found = cho_solve(cho_factor(R), (A / std).T).T
    except LinAlgError:  # states that depend on each other
        found = (A / std) @ pinvh(R)
    result: Array = found / std
    return result
