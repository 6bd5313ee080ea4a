"""What a step says, written into its flat array by engines in Python."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from estimation.kalman_stage import Update
from estimation.lagged import LaggedState
from estimation.layout import Layout
from estimation.outputs import Derived
from estimation.status import Status
from models.arrays import Array
from models.gaussian import GaussianState


def report(
    layout: Layout,
    derived: Derived,
    time_s: float,
    state: GaussianState,
    update: Update | None,
    status: Status,
    iterations: int = 1,
    cost: float = np.nan,
    kkt: float = np.nan,
    lagged: Sequence[LaggedState] = (),
    lags: Sequence[int] = (),
) -> Array:
    """Return a step's flat array; without an update it has no innovation."""
    result = np.full(layout.size, np.nan)
    layout.view(result, "time_s")[...] = time_s
    layout.view(result, "mean")[:] = state.mean
    layout.view(result, "covariance")[:] = state.covariance
    values, std = derived.values(state.mean[None], state.covariance[None])
    layout.view(result, "derived")[:] = values[0]
    layout.view(result, "derived_std")[:] = std[0]
    if update is not None:
        innovation = np.where(update.present, update.innovation, np.nan)
        layout.view(result, "innovation")[:] = innovation
        layout.view(result, "innovation_covariance")[:] = update.innovation_covariance
    layout.view(result, "status")[...] = status.value
    layout.view(result, "iterations")[...] = iterations
    layout.view(result, "cost")[...] = cost
    layout.view(result, "kkt")[...] = kkt
    layout.view(result, "reused")[...] = 0
    tell_lagged(layout, derived, result, lags, lagged)
    return result


def tell_lagged(
    layout: Layout,
    derived: Derived,
    result: Array,
    lags: Sequence[int],
    lagged: Sequence[LaggedState],
) -> None:
    """Write what is known of earlier instants into a step's flat array."""
    for earlier in lagged:
        i = lags.index(earlier.lag)
        layout.view(result, "lagged_time")[i] = earlier.time_s
        layout.view(result, "lagged_mean")[i] = earlier.state.mean
        P = layout.view(result, "lagged_covariance")[i] = earlier.state.covariance
        values, std = derived.values(earlier.state.mean[None], P[None])
        layout.view(result, "lagged_derived")[i] = values[0]
        layout.view(result, "lagged_derived_std")[i] = np.where(np.isnan(P[0, 0]), np.nan, std[0])
