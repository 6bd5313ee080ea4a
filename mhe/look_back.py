"""What a window says of its earlier stages, in Python; mhe/compiled/lagged.c says how.

Both tell P_s, the covariance of a stage given all readings of the window, linearised where the
trajectory is; what bounds hold does not narrow it, as everywhere.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from estimation.function_call import FunctionCall
from estimation.kalman_stage import Prediction, Update
from estimation.lagged import LaggedState
from estimation.square_roots import spread_root
from estimation.stage_limits import stage_limits
from models.arrays import Array
from models.gaussian import GaussianState

LEAST_SHARE = stage_limits(np.float64)["LEAST_SHARE"]


def told_stages(lags: Sequence[int], count: int) -> list[tuple[int, int]]:
    """Return (lag, stage) of those lags that a window of `count` stages reaches."""
    return [(lag, count - 1 - lag) for lag in lags if lag < count]


def look_back(
    lags: Sequence[int],
    times: Sequence[float] | Array,
    states: Sequence[Array] | Array,
    covariances: Mapping[int, Array],
) -> tuple[LaggedState, ...]:
    """Return what a window says at its lags.

    Parameters
    ----------
    states : (n, n_x)
    covariances : stage → P_s; NaN where there is none
    """
    unknown = np.full((len(states[0]), len(states[0])), np.nan)
    return tuple(
        LaggedState(
            lag, float(times[at]), GaussianState(states[at].copy(), covariances.get(at, unknown))
        )
        for lag, at in told_stages(lags, len(times))
    )


class Smoother:
    """Smoothed covariances from the factors of a forward pass; mhe/compiled/smoothed_covariance.c.

    Parameters
    ----------
    call : the functions of `mhe.stage_functions.pass_functions` by name
    """

    def __init__(self, call: Mapping[str, FunctionCall]) -> None:
        self._call = call

    def covariances(
        self, lags: Sequence[int], updates: Sequence[Update], predictions: Sequence[Prediction]
    ) -> dict[int, Array]:
        """Return stage → P_s (n_x, n_x) for each lag."""
        told, found = {at for _, at in told_stages(lags, len(updates))}, dict[int, Array]()
        Lambda = np.zeros_like(updates[-1].state.covariance)
        for k in reversed(range(min(told, default=len(updates)), len(updates))):
            if k in told:
                found[k] = _smoothed(updates[k].state.covariance, Lambda)
            if k > min(told):
                Lambda = _in_front(updates[k], Lambda)
                Lambda = _through(predictions[k - 1].F, _through(predictions[k - 1].F, Lambda))
        return found

    def spread(self, gaussian: GaussianState, v: Array) -> Array:
        """Return P v (n_x,)."""
        if gaussian.root is not None:
            return spread_root(gaussian.root, v)
        return self._call["spread"](gaussian.covariance, v)[0]


def _smoothed(P: Array, Lambda: Array) -> Array:
    """Return P⁺ - P⁺ Λ̂ P⁺."""
    nothing = np.zeros_like(P)
    left = _added(P, -_added(nothing, P, Lambda), P)
    P_s: Array = (left + left.T) / 2
    own = np.diag_indices(len(P))
    P_s[own] = np.maximum(P_s[own], LEAST_SHARE * np.diag(P))
    return P_s


def _in_front(u: Update, Lambda: Array) -> Array:
    """Return Λ of a stage from its Λ̂."""
    n_r = len(u.e)
    M = u.H.copy()
    for r in range(n_r):
        for q in range(r):
            M[r] -= u.L[r, q] * M[q]
        M[r] /= u.L[r, r]
    A = _added(np.zeros_like(M), u.W.T, Lambda)
    C = -0.5 * _added(np.eye(n_r), A, u.W)
    taken = _added(np.zeros_like(Lambda), M.T, _added(A, C, M))
    front: Array = Lambda - (taken + taken.T)
    return front


def _through(F: Array, Lambda: Array) -> Array:
    """Return the transpose of Fᵀ Λ, ones on F's diagonal first."""
    unit = np.diag(np.diag(F) == 1)
    return _added(np.where(np.diag(unit)[:, None], Lambda, 0.0), np.where(unit, 0, F).T, Lambda).T


def _added(start: Array, A: Array, B: Array) -> Array:
    """Return start + A B, products added from the first on, as C does it."""
    total = start.copy()
    for column, row in zip(A.T, B, strict=True):
        total += column[:, None] * row
    return total
