"""Which parts of a state can get lost, and what is left of it when one is."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimation.symmetry import direction, holds
from models.arrays import Array
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel

LOST_RAD, FOUND_RAD = 1.0, 0.35
"""Standard deviations of an angle from which it is not known any more, and from which it is."""
FAR, NEAR = 1e6, 1e3
"""A component wraps if so far out leads to a state that is no further away than that."""
ALONG = 0.5
"""Share of a symmetry's direction that makes a component one that no sensor shows."""


class Reach:
    """Components of a tangent vector that wrap, or have a reach, and that some sensor shows.

    A component wraps where going far out leads back (in rad). One along a symmetry that holds (the
    heading of a pen without a camera) is shown by no sensor, so it is not lost either.
    """

    def __init__(self, model: StateSpaceModel) -> None:
        reach = np.full(model.n_x, np.inf) if model.reach is None else np.asarray(model.reach)
        wraps, x = np.zeros(model.n_x, dtype=bool), model.prior.mean
        for i in range(model.n_x):
            away = np.zeros(model.n_x)
            away[i] = FAR
            back = model.difference(model.retract(x, away), x).full().ravel()
            wraps[i] = abs(back[i]) < NEAR
        for symmetry in model.symmetries:
            if holds(model, symmetry, x[None], 0.01):
                along = np.abs(direction(model, symmetry, x))
                wraps &= along < ALONG * along.max()
        self.wraps: NDArray[np.bool_] = wraps
        self.lost = np.where(wraps, LOST_RAD, reach)
        self.found = np.where(wraps, FOUND_RAD, FOUND_RAD / LOST_RAD * reach)
        self.components = np.flatnonzero(np.isfinite(self.lost))
        biases = {name for sensor in model.sensors for name in sensor.bias_states}
        self.is_bias = np.array([name in biases for name in model.state_names])
        self.moves: NDArray[np.bool_] = ~self.is_bias & ~np.isfinite(self.lost)

    def is_beyond(self, std: Array, known: NDArray[np.bool_]) -> bool:
        """Whether a component that was known is not any more; std and known (n_x,)."""
        return bool((known & (std > self.lost)).any())

    def restarted(self, known: GaussianState, prior: GaussianState) -> GaussianState:
        """Return the prior with what is known of biases."""
        keep, mean, P = self.is_bias, prior.mean.copy(), prior.covariance.copy()
        mean[keep] = known.mean[keep]
        P[keep, :] = 0.0
        P[:, keep] = 0.0
        P[np.ix_(keep, keep)] = known.covariance[np.ix_(keep, keep)]
        return GaussianState(mean, P)
