"""A start that is wrong by a known amount, told with the uncertainty that is asked for."""

from __future__ import annotations

from collections.abc import Mapping

from models.gaussian import GaussianState
from models.state_space import StateSpaceModel


def replaced_prior(model: StateSpaceModel, means: Mapping[str, float], std: float) -> GaussianState:
    """Return a model's prior with other means of some states, all with one deviation.

    Other states keep theirs; these ones become independent of them.

    Parameters
    ----------
    means : state name → mean, in its unit
    std : standard deviation of each of them
    """
    mean, covariance = model.prior.mean.copy(), model.prior.covariance.copy()
    index = [model.state_names.index(name) for name in means]
    mean[index] = list(means.values())
    covariance[index, :] = 0.0
    covariance[:, index] = 0.0
    covariance[index, index] = std**2
    return GaussianState(mean, covariance)
