"""What the EKF does with readings that are far from their prediction: gates, and bounded influence.

Of a sensor's innovation v (all rows that are there), S = H P⁻ Hᵀ + R and d² = vᵀ S⁻¹ v:

*Gate*: a reading with d² beyond a χ² quantile is dropped.

*Bounded influence*: where d is beyond a threshold k, the noise counts as R / ω with the ω < 1 for
which vᵀ (H P⁻ Hᵀ + R / ω)⁻¹ v = k². So no reading moves the state by more than k of the
state's own standard deviations, however far off it is and however little was known (R d / k would
not do: where P⁻ is large beside R, a slow camera's, it bounds nothing), and what is claimed
afterwards is that of a reading of this noise.

A gate that rejects everything has lost the track: then the state is doubted, not the sensor. After
some readings in a row and some time (`OUTLIERS`) the next one is taken. Before it is, a share β
of the model's prior comes on top of what is known, P⁻ + β P̄, as much as it takes for d² to be what
one expects of so many rows, and all of it at most; so what is claimed stays honest in every
direction. The update is iterated, as with first readings. A single far reading never opens a gate;
and none is closed before a reading of its sensor was ever used, for until then only the prior
speaks against it.

References
----------
Chang (2014), Robust Kalman filtering based on Mahalanobis distance as outlier judging criterion,
Journal of Geodesy 88: the noise enlarged to where the distance is what it may be.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from estimation.chi_square import quantile
from models.arrays import Array
from models.state_space import StateSpaceModel

OUTLIERS: Mapping[str, float] = MappingProxyType(
    {
        "GATE_REJECTIONS": 1,  # in a row, before a gate may open
        "GATE_DOUBT_S": 0.05,  # since the first of them, before it does
        "NEWTON_STEPS": 30,  # for 1 / ω, and for the prior's share; it takes 2 to 6
        "NEWTON_SETTLED": 1e-9,  # by how much d² may then be larger than asked for, of that
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
    limits = np.full((len(model.sensors), model.n_r + 1), np.inf)
    for row, sensor in zip(limits, model.sensors, strict=True):
        if sensor.name in gates:
            count = np.arange(1, sensor.n_r + 1)
            row[count] = quantile(gates[sensor.name], count)
    return limits


def squared_distance(v: Array, S: Array, added: Array, more: float) -> tuple[float, float]:
    """Return s = vᵀ M⁻¹ v of M = S + more · added, and -ds/dmore.

    In the order of filter.c.

    Parameters
    ----------
    v, S, added : (n,), (n, n), (n, n)
    """
    n, total, slope = len(v), 0.0, 0.0
    L, z = np.zeros((n, n)), np.zeros(n)
    for i in range(n):
        left = v[i]
        for j in range(i + 1):
            s = S[i, j] + more * added[i, j] if more > 0 else S[i, j]
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
    for i in range(n):
        for j in range(n):
            slope += z[i] * added[i, j] * z[j]
    return float(total), float(slope)


def needed(v: Array, S: Array, added: Array, most: float) -> float:
    """Return how much of a covariance has to come on top of S for an s of at most `most`.

    0 where none has to, or no number says. Newton's method on 1 / s, which is linear in what is
    added for one row and concave for several: it comes from below.
    """
    more = 0.0
    for _ in range(int(OUTLIERS["NEWTON_STEPS"])):
        s, slope = squared_distance(v, S, added, more)
        if not s > most * (1 + OUTLIERS["NEWTON_SETTLED"]):
            break
        more += s / slope * (s / most - 1)
        if not np.isfinite(more):
            return 0.0
    return more
