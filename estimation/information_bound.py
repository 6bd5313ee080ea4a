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
from models.errors import InputError
from models.gaussian import GaussianState
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


class BoundInParts:
    """The bound behind known states that come in parts, of a model without inputs."""

    def __init__(self, model: StateSpaceModel) -> None:
        self._model, self._stage, self._jacobian = model, KalmanStage(model), output_jacobian(model)
        self._known, self._last = model.prior, (np.zeros(0), np.zeros((0, model.n_x)))
        self._prior_std: Array | None = None

    def add(self, time_s: Array, y: Array, states: Array) -> None:
        """Go on through times (n,), rows (n, n_row) and true states (n, n_x)."""
        if self._prior_std is None:
            J = self._jacobian(states[0]).full()
            self._prior_std = _std(J, self._model.prior.covariance)
        # From the last state on, which has no further reading.
        before, x = self._last
        no_reading = np.full((len(before), y.shape[1]), np.nan)
        covariances = self._stage.sweep(
            self._known,
            np.append(before, time_s),
            np.concatenate([x, states]),
            np.concatenate([no_reading, y]),
        )
        self._last = time_s[-1:], states[-1:]
        self._known = GaussianState(states[-1], covariances[-1])

    def result(self) -> InformationBound:
        """Return the bound behind the last state, (1, n_o), beside the prior's at the first.

        Raises
        ------
        InputError
            If there was no state.
        """
        if self._prior_std is None:
            raise InputError("no known state to take the information bound along, expected one")
        J = self._jacobian(self._known.mean).full()
        std = _std(J, self._known.covariance)[None]
        return InformationBound(outputs_of(self._model).names, std, self._prior_std)


def _std(J: Array, covariance: Array) -> Array:
    """Return standard deviations (…, n_o) of outputs with Jacobians J (…, n_o, n_x)."""
    std: Array = np.sqrt(((J @ covariance) * J).sum(axis=-1))
    return std
