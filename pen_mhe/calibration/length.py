"""A sensor's bias, scale and misalignment from a vector whose length is known.

With a reading y_p of a vector f_p along its axes, ``y_p = S f_p + b`` with ``|f_p| = g``:

    r_p = |S⁻¹ (y_p - b)| - g,    minimised:  Σ_p (r_p / σ_p)²,

with σ_p² the variance of y_p along the direction in which it changes r_p. A turn of all of it
changes no length, and is not found: S is symmetric, which leaves the sensor's axes where they
are on the mean. Its diagonal are the scales, beside it stands the misalignment.

The covariance is (JᵀJ)⁻¹, times χ²/(readings - parameters) where that is more than one: then
readings contradict each other by more than their noise, and that is in the deviations, too.

References
----------
Tedaldi, Pretto, Menegatti (2014), A robust and easy to implement method for IMU calibration
without external equipments, ICRA: the cost, with a triangular matrix instead.
Vasconcelos, Elkaim, Silvestre, Oliveira, Cardeira (2011), Geometric approach to strapdown
magnetometer calibration in sensor frame, IEEE Trans. AES 47(2): the same of a magnetic field.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from models.arrays import Array
from models.errors import InputError

PARAMETERS = (
    *(f"bias {axis}" for axis in "xyz"),
    *(f"scale {axis}" for axis in "xyz"),
    *(f"misalignment {axes}" for axes in ("xy", "xz", "yz")),
)
N_BIAS, N_SCALE = 3, 6
"""How many parameters are found with the biases, and with the scales."""
ENTRIES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
"""Of S, for the parameters behind the bias."""

SMALLEST = 0.05
"""Least singular value of the directions, over the root of their number: 0.37 where they are
everywhere. Below, an error of a pose is twenty times that in some parameter."""
ROUNDS = 3
"""Of weights from the last solution."""


@dataclass(frozen=True, eq=False)
class LengthFit:
    """What readings of a known length say of a sensor.

    Parameters
    ----------
    count : number of parameters that were found, the first of `PARAMETERS`
    bias : (3,)
    sensitivity : (3, 3) S
    covariance : (count, count) of the parameters; biases in its unit
    before, after : (p,) |f| - g with the numbers that it began from, and with these
    expected_std : root mean square of what noise makes of `after`
    inflation : by which the deviations are larger than noise alone makes them
    """

    count: int
    bias: Array
    sensitivity: Array
    covariance: Array
    before: Array
    after: Array
    expected_std: float
    inflation: float

    @property
    def std(self) -> Array:
        """(count,) standard deviations."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    @property
    def values(self) -> Array:
        """(count,) the parameters; scales as their distance from 1."""
        off = self.sensitivity - np.eye(3)
        return np.concatenate([self.bias, [off[i, j] for i, j in ENTRIES]])[: self.count]

    @property
    def misfit_std(self) -> float:
        """By how much readings differ beyond their noise."""
        spare = len(self.after) - self.count
        excess = np.sum(self.after**2) / spare - self.expected_std**2
        return float(np.sqrt(max(excess, 0.0)))


def lengths(means: Array, bias: Array, sensitivity: Array) -> Array:
    """Return |S⁻¹ (y - b)| (p,) of mean readings (p, 3)."""
    force = np.linalg.solve(sensitivity, (means - bias).T).T
    return np.asarray(np.linalg.norm(force, axis=1))


def fit_length(
    means: Array,
    variances: Array,
    length: float,
    count: int,
    *,
    bias: Array,
    sensitivity: Array,
    too_similar: str,
) -> LengthFit:
    """Find a sensor's parameters from readings of a vector of known length.

    Parameters
    ----------
    means : (p, 3) readings, or means of some
    variances : (p, 3) of the means, by noise alone
    count : how many of `PARAMETERS`, from the first; what is not found stays as it is
    bias, sensitivity : (3,), (3, 3) to begin from
    too_similar : what to say where readings do not tell parameters apart, with ``{0}`` and ``{1}``
        for two of them

    Raises
    ------
    InputError
        If they do not.
    """
    base = np.eye(3) if count > N_SCALE else sensitivity.copy()

    def unpacked(theta: Array) -> tuple[Array, Array]:
        S = base.copy()
        for value, (i, j) in zip(theta[N_BIAS:], ENTRIES, strict=False):
            S[i, j] = S[j, i] = value + (i == j)
        return theta[:N_BIAS], S

    def parts(theta: Array) -> tuple[Array, Array, Array]:
        """Return r (p,), its gradient by y (p, 3), and J (p, count)."""
        b, S = unpacked(theta)
        force = np.linalg.solve(S, (means - b).T).T
        size = np.linalg.norm(force, axis=1)
        w = np.linalg.solve(S.T, (force / size[:, None]).T).T
        columns = [-w[:, i] for i in range(N_BIAS)]
        for i, j in ENTRIES:
            across = w[:, j] * force[:, i] if i != j else 0.0
            columns.append(-(w[:, i] * force[:, j] + across))
        return size - length, w, np.column_stack(columns[:count])

    def weighted(theta: Array, sigma: Array) -> Array:
        return np.asarray(parts(theta)[0] / sigma)

    def weighted_jacobian(theta: Array, sigma: Array) -> Array:
        return np.asarray(parts(theta)[2] / sigma[:, None])

    started = np.concatenate([bias, [sensitivity[i, j] - (i == j) for i, j in ENTRIES]])[:count]
    _check_directions(parts(started)[2], length, too_similar)
    theta = started
    for _ in range(ROUNDS):
        sigma = np.sqrt((parts(theta)[1] ** 2 * variances).sum(axis=1))
        theta = least_squares(
            weighted,
            theta,
            jac=weighted_jacobian,
            method="lm",
            x_scale=np.where(np.arange(count) < N_BIAS, length, 1.0),
            args=(sigma,),
        ).x
    r, _, J = parts(theta)
    inflation = float(np.sqrt(max(1.0, np.sum((r / sigma) ** 2) / (len(r) - count))))
    whitened = J / sigma[:, None]
    b, S = unpacked(theta)
    return LengthFit(
        count=count,
        bias=b,
        sensitivity=S,
        covariance=inflation**2 * np.linalg.inv(whitened.T @ whitened),
        before=lengths(means, bias, sensitivity) - length,
        after=r,
        expected_std=float(np.sqrt(np.mean(sigma**2))),
        inflation=inflation,
    )


def _check_directions(J: Array, length: float, too_similar: str) -> None:
    scaled = J.copy()
    scaled[:, N_BIAS:] /= length
    _, singular, right = np.linalg.svd(scaled / np.sqrt(len(J)), full_matrices=False)
    if singular[-1] < SMALLEST:
        alike = [PARAMETERS[i] for i in np.argsort(-np.abs(right[-1]))[:2]]
        raise InputError(too_similar.format(*alike))
