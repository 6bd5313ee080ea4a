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
from models.arrays import Array
from models.gaussian import GaussianState

LEAST_SHARE = 1e-13
"""Of the variance P⁺ before later readings: P_s is a difference, and told is no less than what
rounding leaves of that."""


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
    """Smoothed covariances from the factors of a forward pass.

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
        stages = told_stages(lags, len(updates))
        return {at: self._covariance(updates, predictions, at) for _, at in stages}

    def _covariance(
        self, updates: Sequence[Update], predictions: Sequence[Prediction], at: int
    ) -> Array:
        known = updates[at].state
        P = np.array(
            [
                self.spread(known, unit + self._echo(updates, predictions, at, unit))
                for unit in np.eye(len(known.mean))
            ]
        )
        P = (P + P.T) / 2
        own = np.diag_indices(len(P))
        P[own] = np.maximum(P[own], LEAST_SHARE * np.diag(known.covariance))
        return P

    def _echo(
        self, updates: Sequence[Update], predictions: Sequence[Prediction], at: int, unit: Array
    ) -> Array:
        """Return λ̂ that comes back from a shift of the stage's mean by -P⁺ times `unit`."""
        shift, e = -self.spread(updates[at].state, unit), []
        for ahead, u in zip(predictions[at:], updates[at + 1 :], strict=True):
            e_shift, shift = self._call["propagate"](shift, ahead.F, u.W, u.L, u.H)
            e.append(e_shift)
        lam_hat = np.zeros(len(unit))
        for k in reversed(range(at + 1, len(updates))):
            u, ahead = updates[k], predictions[k - 1]
            [lam] = self._call["absorb"](lam_hat, u.W, e[k - at - 1], u.L, u.H)
            lam_hat, _ = self._call["retreat"](lam, ahead.F, ahead.G, np.ones(ahead.G.shape[1]))
        return lam_hat

    def spread(self, gaussian: GaussianState, v: Array) -> Array:
        """Return P v (n_x,)."""
        if gaussian.root is not None:
            return spread_root(gaussian.root, v)
        return self._call["spread"](gaussian.covariance, v)[0]
