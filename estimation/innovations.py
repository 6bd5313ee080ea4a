"""What is kept of innovations: their deviations, and NIS of the sets of rows that one asks for."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from estimation.mahalanobis import squared_distances
from models.arrays import Array
from models.frozen_mapping import FrozenMapping
from models.state_space import StateSpaceModel

Rows = NDArray[np.bool_]


def row_sets(model: StateSpaceModel) -> FrozenMapping[str, Rows]:
    """Return the rows (n_r,) of all that measures, of everything, and of each sensor by its name.

    A set that another one equals is left out.
    """
    sets = {"measured": model.measured_rows, "all": np.ones(model.n_r, dtype=bool)}
    start = 0
    for sensor in model.sensors:
        rows = np.zeros(model.n_r, dtype=bool)
        rows[start : start + sensor.n_r] = True
        sets.setdefault(sensor.name, rows)
        start += sensor.n_r
    unique: dict[str, Rows] = {}
    for name, rows in sets.items():
        if not any(np.array_equal(rows, other) for other in unique.values()):
            unique[name] = rows
    return FrozenMapping(unique)


def innovation_std(innovation: Array, covariance: Array) -> Array:
    """Return the standard deviations (n, n_r) of innovations, NaN where there is none."""
    std = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))
    return np.where(np.isnan(innovation), np.nan, std)


def squared_innovations(innovation: Array, covariance: Array, sets: Mapping[str, Rows]) -> Array:
    """Return vᵀ S⁻¹ v (n, len(sets)) over the rows of each set that have a reading.

    Parameters
    ----------
    innovation : (n, n_r), NaN without a reading
    covariance : (n, n_r, n_r) S
    """
    columns = []
    for rows in sets.values():
        v, S = innovation[:, rows], covariance[:, rows][:, :, rows]
        columns.append(squared_distances(v, S, ~np.isnan(v)))
    return np.array(columns).reshape(len(sets), len(innovation)).T
