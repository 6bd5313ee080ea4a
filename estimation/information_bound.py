"""How well any estimator can do: the information bound along a known motion.

The Kalman stage, linearised at the true states, gives the covariance that the
readings, the process noise and the prior leave (the posterior Cramér-Rao
bound, evaluated at one trajectory). No estimator takes part.

References
----------
Tichavský, Muravchik, Nehorai (1998), Posterior Cramér-Rao bounds for
discrete-time nonlinear filtering, IEEE Trans. Signal Processing 46(5).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from estimation.kalman_stage import KalmanStage
from estimation.outputs import output_jacobian, outputs_of
from estimation.recording import Measurement
from models.arrays import Array
from models.state_space import StateSpaceModel

OBSERVABLE_FRACTION = 0.3
"""A state counts as observable when its bound falls below this part of the prior's
standard deviation; smaller is stricter."""


@dataclass(frozen=True, eq=False)
class InformationBound:
    """Lowest standard deviations (n, n_o) along a motion, beside the prior's (n_o,).

    Of what people read, `estimation.outputs.outputs_of`; the prior's are at the first state.
    """

    names: tuple[str, ...]
    std: Array
    prior_std: Array


def information_bound(
    model: StateSpaceModel,
    measurements: Iterable[Measurement],
    states: Array,
) -> InformationBound:
    """Return the bound along known states.

    Parameters
    ----------
    measurements : only their times and which rows are present matter, and, for
        sensors whose residual is curved, where they are linearised
    states : (n, n_x) the true states, one per measurement
    """
    given, jacobian = list(measurements), output_jacobian(model)
    times, y = np.array([m.time_s for m in given]), np.array([m.y for m in given])
    covariances = KalmanStage(model).sweep(model.prior, times, states, y)
    J = jacobian(states.T).full().reshape(-1, *states.shape).transpose(1, 0, 2)
    names = outputs_of(model).names
    return InformationBound(names, _std(J, covariances), _std(J[0], model.prior.covariance))


def _std(J: Array, covariance: Array) -> Array:
    """Return standard deviations (…, n_o) of outputs with Jacobians J (…, n_o, n_x)."""
    std: Array = np.sqrt(((J @ covariance) * J).sum(axis=-1))
    return std
