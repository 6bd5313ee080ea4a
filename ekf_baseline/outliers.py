"""What the EKF does with readings that are far from their prediction: gates, and bounded influence.

Of a sensor's innovation v (all rows that are there), S = H P⁻ Hᵀ + R and d² = vᵀ S⁻¹ v:

*Gate*: a reading with d² beyond a χ² quantile is dropped.

*Bounded influence*: where d is beyond a threshold k, the noise counts as R / ω with the ω < 1 for
which vᵀ (H P⁻ Hᵀ + R / ω)⁻¹ v = k². So no reading moves the state by more than k of the
state's own standard deviations, however far off it is and however little was known (R d / k would
not do: where P⁻ is large beside R, a slow camera's, it bounds nothing), and what is claimed
afterwards is that of a reading of this noise.

A gate that rejects everything has lost the track: then the state is doubted, not the sensor. After
`OUTLIERS` readings in a row, over a time, the next one is taken. Before it is, the state is known
less well: the standard deviations of all states grow by the same factor, but none beyond
the model's prior, until the reading is within the gate; so what is claimed stays honest. The
update is iterated, as with first readings. One far reading, or a few, never open a gate; and none
is closed before a reading of its sensor was ever used, for until then only the prior speaks
against it.

References
----------
Chang (2014), Robust Kalman filtering based on Mahalanobis distance as outlier judging criterion,
Journal of Geodesy 88: the noise enlarged to where the distance is what it may be.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from models.arrays import Array
from models.state_space import StateSpaceModel

OUTLIERS: Mapping[str, float] = MappingProxyType(
    {
        "GATE_REJECTIONS": 3,  # in a row, before a gate may open
        "GATE_DOUBT_S": 0.1,  # since the first of them: a knock on an inertial sensor is shorter
        "GATE_WIDENINGS": 10,  # of the prior, at most
        "BOUND_STEPS": 30,  # of Newton's method for 1 / ω; it takes 2 to 6
        "BOUND_SETTLED": 1e-9,  # by how much d² may then be beyond k², of it
    }
)
"""Limits, macros of filter.c."""


def gate_limits(model: StateSpaceModel, gates: Mapping[str, float]) -> Array | None:
    """Return the limits (n_sensors, n_r + 1) of d² by number of rows, inf without a gate.

    None where no sensor has one.

    Parameters
    ----------
    gates : sensor → probability of its χ² quantile
    """
    if not gates:
        return None
    from scipy.stats import chi2  # takes a second to import

    limits = np.full((len(model.sensors), model.n_r + 1), np.inf)
    for row, sensor in zip(limits, model.sensors, strict=True):
        if sensor.name in gates:
            count = np.arange(1, sensor.n_r + 1)
            row[count] = chi2.ppf(gates[sensor.name], count)
    return limits


def squared_distance(v: Array, S: Array, R: Array, more: float) -> tuple[float, float]:
    """Return s = vᵀ M⁻¹ v of M = S + more R, and -ds/dmore = (M⁻¹ v)ᵀ R (M⁻¹ v).

    In the order of filter.c, so that both loops say the same.

    Parameters
    ----------
    v, S, R : (n,), (n, n), (n,)
    """
    n, total, slope = len(v), 0.0, 0.0
    L, z = np.zeros((n, n)), np.zeros(n)
    for i in range(n):
        left = v[i]
        for j in range(i + 1):
            s = S[i, j] + more * R[i] if i == j else S[i, j]
            for k in range(j):
                s -= L[i, k] * L[j, k]
            L[i, j] = np.sqrt(s) if i == j else s / L[j, j]
        for j in range(i):
            left -= L[i, j] * z[j]
        z[i] = left / L[i, i]
        total += z[i] * z[i]
    for i in reversed(range(n)):
        for j in range(i + 1, n):
            z[i] -= L[j, i] * z[j]
        z[i] /= L[i, i]
        slope += R[i] * z[i] * z[i]
    return float(total), float(slope)


def bounded_weight(v: Array, S: Array, R: Array, threshold: float) -> float:
    """Return ω of a sensor's rows; 1 where they are near enough, or too far to say a number.

    Newton's method on 1 / s, which is linear in 1 / ω for one row and concave for several: it
    comes from below.
    """
    more, most = 0.0, threshold * threshold
    for _ in range(int(OUTLIERS["BOUND_STEPS"])):
        s, slope = squared_distance(v, S, R, more)
        if not s > most * (1 + OUTLIERS["BOUND_SETTLED"]):
            break
        more += s / slope * (s / most - 1)
        if not np.isfinite(more):
            return 1.0
    return 1 / (1 + more)
