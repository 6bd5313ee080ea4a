"""A start that is wrong by a known amount, told with the uncertainty that is asked for."""

from __future__ import annotations

from collections.abc import Mapping

import casadi as ca

from models import attitude
from models.arrays import Array
from models.errors import InputError
from models.free_pen import SIGMA, STATES
from models.gaussian import GaussianState
from models.given_prior import given_prior
from models.state_space import StateSpaceModel


def replaced_prior(model: StateSpaceModel, means: Mapping[str, float], std: float) -> GaussianState:
    """Return a model's prior with other means of some states, all with one deviation.

    Other states keep theirs; these ones become independent of them.

    Parameters
    ----------
    means : state name → mean, in its unit
    std : standard deviation of each of them

    Raises
    ------
    InputError
        If a state is unknown, a mean is not finite, or the deviation is not positive.
    """
    given = {name: (mean, std) for name, mean in means.items()}
    return given_prior(model.name, model.state_names, model.prior, given)


def replaced_attitude(model: StateSpaceModel, rotation: Array, std: float) -> GaussianState:
    """Return a free pen's prior with another attitude, known equally well about every axis.

    Other states keep theirs; the attitude becomes independent of them.

    Parameters
    ----------
    rotation : (3, 3) body to world
    std : standard deviation of a turn about an axis, rad

    Raises
    ------
    InputError
        If the model is none of a free pen.
    """
    names = [name for name, _ in STATES[SIGMA]]
    if model.state_names[SIGMA] != tuple(names):
        raise InputError(
            f"model {model.name} has no attitude, expected a pen with 6 degrees of freedom"
        )
    sigma = ca.evalf(attitude.from_matrix(ca.SX(ca.DM(rotation)))).full().ravel()
    return replaced_prior(model, dict(zip(names, sigma.tolist(), strict=True)), std)
