"""What a sensor configuration can see, along a motion, noise aside.

The information about the first state that all readings hold together,

    O = Σ_k (H_k Φ_k)ᵀ R⁻¹ (H_k Φ_k),   Φ_k = F_{k-1} … F_0,

is compared with what the prior already holds: a direction about which the
readings say less than the prior is not observable in practice.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from estimation.kalman_stage import KalmanStage
from estimation.recording import Measurement
from models.state_space import Array, StateSpaceModel

LEAKAGE = 0.05


@dataclass(frozen=True, eq=False)
class Observability:
    """The verdict on a model, its sensors and a motion.

    Parameters
    ----------
    state_names : (n_x,)
    directions : (n_x, k) orthonormal unobservable directions, states scaled by the prior's
        standard deviations
    """

    state_names: tuple[str, ...]
    directions: Array

    @property
    def rank(self) -> int:
        """Number of observable directions."""
        return len(self.state_names) - self.directions.shape[1]

    def sees(self, state: str) -> bool:
        """Whether a state takes no part in any unobservable direction."""
        row = self.directions[self.state_names.index(state)]
        return bool(np.linalg.norm(row) < LEAKAGE)


def observability(
    model: StateSpaceModel,
    measurements: Iterable[Measurement],
    states: Array,
    threshold: float = 1.0,
) -> Observability:
    """Judge what the readings say about the first state, along known states.

    Parameters
    ----------
    states : (n, n_x) the motion, one state per measurement
    threshold : information relative to the prior's below which a direction
        counts as unobservable; larger is stricter
    """
    stage, scale = KalmanStage(model), model.prior.std
    transition, information = np.eye(model.n_x), np.zeros((model.n_x, model.n_x))
    previous: tuple[float, Array] | None = None
    for measurement, x in zip(measurements, states, strict=True):
        if previous is not None:
            time_s, x_before = previous
            F, _ = stage.derivatives(x_before, measurement.time_s - time_s)
            transition = F @ transition
        previous = (measurement.time_s, x)
        update = stage.update(model.prior, measurement.y, x_lin=x)
        whitened = (update.H / model.noise_std[:, None]) @ transition * scale
        information += whitened.T @ whitened
    values, vectors = np.linalg.eigh(information)
    return Observability(model.state_names, vectors[:, values < threshold])
