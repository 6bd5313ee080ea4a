"""Noise levels of a sensor at rest, by its overlapping Allan variance.

Over cluster times τ of still stretches, pooled over stretches and axes,

    σ²(τ) = N²/τ + B² 2 ln 2/π + K² τ/3,

white noise of density N, bias instability B, a random walk of density K, fitted by non-negative
least squares, weighted by what chance makes of each σ². N shows within seconds; B and K only
where stretches are long enough for the curve to leave its first slope, and count as found
from `SURE` deviations on.

References
----------
IEEE Std 952-1997, annex C. Riley (2008), NIST Special Publication 1065: degrees of freedom.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from models.arrays import Array

LIBRARY, EXTRA = "allantools", "calibrate"
"""What computes the variances, and the extra of this package that installs it."""

FIRST_S = 0.04
"""Shorter clusters show the sensor's filter, not its white noise."""
FEWEST_CLUSTERS = 4.0
"""Degrees of freedom that a point of the curve has at least."""
NOISES = (0, -2)
"""Exponents of white noise and of a walk: the fewer degrees of freedom of both are taken."""
FLICKER = 2 * np.log(2) / np.pi
SURE = 3.0
ROUNDS = 4
"""Of weights from the last fit."""


@dataclass(frozen=True, eq=False)
class AllanCurve:
    """A pooled curve.

    Parameters
    ----------
    tau_s : (n,) cluster times
    variance : (n,) σ², the sensor's unit squared
    freedom : (n,) degrees of freedom of each
    """

    tau_s: Array
    variance: Array
    freedom: Array


@dataclass(frozen=True)
class NoiseLevels:
    """What a curve says, in the sensor's unit: (value, standard deviation).

    Parameters
    ----------
    density : N, per √Hz of a two-sided spectrum
    instability : B; None where the curve is too short to show it
    walk : K, per √s; None likewise
    longest_s : the longest cluster time
    """

    density: tuple[float, float]
    instability: tuple[float, float] | None
    walk: tuple[float, float] | None
    longest_s: float


def has_library() -> bool:
    """Whether the library that computes the variances is installed."""
    return importlib.util.find_spec(LIBRARY) is not None


def allan_curve(stretches: Sequence[Array], rate_hz: float) -> AllanCurve | None:
    """Return the pooled curve of stretches (n, n_axes); None where all are too short."""
    import allantools
    from allantools.ci import edf_simple

    first = max(1, round(FIRST_S * rate_hz))
    longest = max(len(stretch) for stretch in stretches)
    clusters = first * 2 ** np.arange(max(int(np.log2(longest / first)), 0))
    total, freedom = np.zeros(len(clusters)), np.zeros(len(clusters))
    for stretch in stretches:
        fit = clusters[2 * clusters + 2 <= len(stretch)]
        for axis in stretch.T if len(fit) else ():
            # Phases are sums: without the mean they keep their digits.
            tau, deviation, _, _ = allantools.oadev(
                axis - axis.mean(), rate=rate_hz, data_type="freq", taus=fit / rate_hz
            )
            for m, sigma in zip(np.round(tau * rate_hz).astype(int), deviation, strict=True):
                own = max(min(edf_simple(len(axis) + 1, m, alpha) for alpha in NOISES), 1.0)
                total[clusters == m] += own * sigma**2
                freedom[clusters == m] += own
    enough = freedom >= FEWEST_CLUSTERS
    if not enough.any():
        return None
    return AllanCurve(clusters[enough] / rate_hz, total[enough] / freedom[enough], freedom[enough])


def noise_levels(curve: AllanCurve) -> NoiseLevels | None:
    """Fit the three levels to a curve; None where the readings never change.

    Neighbouring points share readings: deviations count every point as half a one. They grow by
    what the curve is off its form.
    """
    tau, variance = curve.tau_s, curve.variance
    if not variance.max() > 0:
        return None
    A = np.column_stack([1 / tau, np.full(len(tau), FLICKER), tau / 3])
    model = variance
    for _ in range(ROUNDS):
        error = np.maximum(model, 1e-12 * variance.max()) * np.sqrt(2 / curve.freedom)
        scale = np.linalg.norm(A / error[:, None], axis=0)
        squares = nnls(A / error[:, None] / scale, variance / error)[0] / scale
        model = A @ squares
    kept = squares > 0
    weighted = (A / error[:, None])[:, kept]
    spare = max(len(tau) - int(kept.sum()), 1)
    off = max(1.0, float(np.sum(((variance - model) / error) ** 2)) / spare)
    std = np.zeros(3)
    std[kept] = np.sqrt(2 * off * np.diag(np.linalg.pinv(weighted.T @ weighted)))

    def level(i: int) -> tuple[float, float]:
        value = float(np.sqrt(squares[i]))
        return value, float(std[i] / (2 * value)) if value > 0 else float(np.sqrt(std[i]))

    def sure(i: int) -> tuple[float, float] | None:
        return level(i) if squares[i] > SURE * std[i] > 0 else None

    return NoiseLevels(level(0), sure(1), sure(2), float(tau[-1]))
