"""How far an estimator's run is from the run of `mhe` on the same recording."""

from __future__ import annotations

import numpy as np

from benchmark.tasks.task import Quantity
from estimation.estimate import EstimateHistory
from mhe.realtime import Mhe
from mhe.reference.ipopt import MheIpopt
from models.arrays import Array
from models.state_space import StateSpaceModel

NEAR, REFERENCE = Mhe.name, MheIpopt.name
"""The estimator that is judged, and the one that says where the optimum is."""

DISTANCE, DEVIATIONS = "distance from mhe", "σ"


def distances(model: StateSpaceModel, history: EstimateHistory, other: EstimateHistory) -> Array:
    """Return max |x - x'| / σ over the states (n,): of the state that is farthest.

    Parameters
    ----------
    history : its covariances, in full, are the measure
    other : at the same instants
    """
    apart = model.difference(other.mean.T, history.mean.T).full()
    variances = np.diagonal(history.covariance, axis1=1, axis2=2).T
    return np.asarray(np.max(np.abs(apart) / np.sqrt(variances), axis=0))


def distance_quantity(
    model: StateSpaceModel, history: EstimateHistory, other: EstimateHistory
) -> Quantity:
    """Return `distances` as a quantity: root mean square and largest over the run."""
    return Quantity.of_errors(DISTANCE, DEVIATIONS, distances(model, history, other))
