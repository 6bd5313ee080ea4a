"""How far two estimates are from each other, in standard deviations."""

from __future__ import annotations

import numpy as np

from estimation.estimate import Estimate
from models.arrays import Array
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel


def mean_error(model: StateSpaceModel, mean: Array, wanted: GaussianState) -> float:
    """Largest deviation of a mean (n_x,), angles the short way round."""
    difference = np.asarray(model.difference(mean, wanted.mean)).ravel()
    return float(np.abs(difference / wanted.std).max())


def covariance_error(covariance: Array, wanted: Array) -> float:
    """Largest deviation in units of the standard deviations' outer product."""
    std = np.sqrt(np.diag(wanted))
    return float(np.abs((covariance - wanted) / np.outer(std, std)).max())


def innovation_error(estimate: Estimate, wanted: Estimate) -> float:
    """Largest deviation of innovations and their covariance; missing rows must agree."""
    v, wanted_v = estimate.innovation, wanted.innovation
    S, wanted_S = estimate.innovation_covariance, wanted.innovation_covariance
    std = np.sqrt(np.diag(wanted_S))
    np.testing.assert_array_equal(np.isnan(v), np.isnan(wanted_v))
    np.testing.assert_array_equal(np.isnan(S), np.isnan(wanted_S))
    errors = [np.abs((v - wanted_v) / std), np.abs((S - wanted_S) / np.outer(std, std))]
    return float(max(np.nan_to_num(error).max() for error in errors))


def estimate_error(model: StateSpaceModel, estimate: Estimate, wanted: Estimate) -> float:
    """Largest of all the above, the window's states included."""
    errors = [
        mean_error(model, estimate.state.mean, wanted.state),
        covariance_error(estimate.state.covariance, wanted.state.covariance),
        innovation_error(estimate, wanted),
    ]
    assert (estimate.window is None) == (wanted.window is None)
    if estimate.window is not None and wanted.window is not None:
        np.testing.assert_array_equal(estimate.window.time_s, wanted.window.time_s)
        for x, other in zip(estimate.window.states, wanted.window.states, strict=True):
            errors.append(mean_error(model, x, GaussianState(other, wanted.state.covariance)))
    return max(errors)
