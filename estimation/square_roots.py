"""The Kalman stage in square roots, in NumPy: where P - W Wᵀ would be rounding.

    P = S Sᵀ,   [F S⁺, G D] Q = [S⁻, 0],   [[R^½, H S⁻], [0, S⁻]] Q = [[L, 0], [W, S⁺]]

with Q orthogonal and diagonals not negative; estimation/root_stage.c is the same in C.

References
----------
Kailath, Sayed, Hassibi (2000), Linear Estimation, chapter 12, for the array form.
Golub, Van Loan (2013), Matrix Computations, section 5.1, for the reflections.
Carlson (1973), Fast triangular formulation of the square root filter, AIAA J. 11(9), for the
order of the rotations.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimation.stage_limits import stage_limits
from models.arrays import Array
from models.gaussian import GaussianState

LIMITS = stage_limits(np.float64)
LOST, BEYOND = LIMITS["LOST"], LIMITS["BEYOND"]


@dataclass(frozen=True, eq=False)
class RootUpdate:
    """S⁺, W (n_x, n_r), L (n_r, n_r), and whether even roots have lost their digits."""

    S: Array
    W: Array
    L: Array
    digits_lost: bool


def root_of(gaussian: GaussianState) -> Array:
    """Return a lower triangular S; a variance that rounding has left below zero is none."""
    if gaussian.root is not None:
        return gaussian.root
    P, n = gaussian.covariance, len(gaussian.mean)
    S = np.zeros((n, n))
    for j in range(n):
        left = P[j, j] - _dot(S[j, :j], S[j, :j])
        if left > 0:
            S[j, j] = np.sqrt(left)
            for i in range(j + 1, n):
                S[i, j] = (P[i, j] - _dot(S[i, :j], S[j, :j])) / S[j, j]
    return S


def kept(mean: Array, S: Array) -> GaussianState:
    """Return a Gaussian by its covariance, and by its root where that has lost its digits.

    S_ii² is what is left of a variance P_ii when all states before are known.
    """
    n, P = len(S), np.zeros((len(S), len(S)))
    for i in range(n):
        for j in range(i + 1):
            P[i, j] = P[j, i] = _dot(S[i, : j + 1], S[j, : j + 1])
    if (LOST * np.diag(S) ** 2 >= np.diag(P)).all():
        return GaussianState(mean, P)
    marked = np.where(np.diag(S) > 0, -S, S)
    marked[0, 0] = -abs(marked[0, 0])  # the mark; see `estimation.stored`
    return GaussianState(mean, P, marked)


def predicted_root(S: Array, F: Array, noise: Array) -> Array:
    """Return S⁻ of S⁺, F and G D (n_x, n_w)."""
    n, unit = len(S), np.diag(F) == 1
    array = np.hstack([unit[:, None] * S, noise])
    for i in range(n):
        for j in range(n):
            if F[i, j] != 0 and not (i == j and unit[i]):
                array[i, :n] += F[i, j] * S[j]
    for row in range(n):
        _reflect(array, row)
    return np.tril(array[:, :n])


def updated_root(S: Array, H: Array, noise_std: Array, there: NDArray[np.bool_]) -> RootUpdate:
    """Return S⁺ and what comes with it.

    Parameters
    ----------
    S, H, noise_std : S⁻, the rows of the readings, and their noise (n_r,)
    there : (n_r,) the rows that have a reading
    """
    n_r, n = H.shape
    array = np.zeros((n_r + n, n_r + n))
    array[:n_r, :n_r] = np.diag(noise_std)
    for r in range(n_r):
        for j in np.flatnonzero(H[r]):
            array[r, n_r:] += H[r, j] * S[j]
    array[n_r:, n_r:] = S
    for row in np.flatnonzero(there).tolist():
        _absorb(array, row, n_r)
    L = np.tril(array[:n_r, :n_r])
    lost = bool(((np.diag(L) / noise_std) ** 2 > BEYOND).any())
    return RootUpdate(np.tril(array[n_r:, n_r:]), array[n_r:, :n_r], L, lost)


def spread_root(S: Array, v: Array) -> Array:
    """Return S Sᵀ v (n_x,)."""
    along = np.zeros(len(v))
    for i, factor in enumerate(v):
        along[: i + 1] += S[i, : i + 1] * factor
    return np.array([_dot(S[i, : i + 1], along[: i + 1]) for i in range(len(v))])


def _reflect(array: Array, row: int) -> None:
    """Turn the columns from `row` on so that this row's tail becomes zero and its head a length."""
    below, head = slice(row + 1, None), array[row, row]
    square, along = head * head, array[row + 1 :, row] * head
    columns = row + 1 + np.flatnonzero(array[row, row + 1 :])
    for c in columns:
        square += array[row, c] * array[row, c]
        along = along + array[below, c] * array[row, c]
    length = np.sqrt(square)
    if length == 0:
        return
    turned = along / length
    along = (turned + np.copysign(1.0, head) * array[below, row]) / (length + abs(head))
    array[below, row] = turned
    for c in columns:
        array[below, c] -= along * array[row, c]
    array[row, row] = length


def _absorb(array: Array, row: int, n_r: int) -> None:
    """Turn a row of H S⁻ into the row's own column, from the last on (Carlson 1973)."""
    own = array[:, row]
    for c in reversed(range(n_r, len(array))):
        u = array[row, c]
        if u == 0:
            continue
        length = np.sqrt(own[row] * own[row] + u * u)
        cosine, sine, column = own[row] / length, u / length, array[:, c]
        for part in (slice(row + 1, n_r), slice(c, None)):
            turned = cosine * own[part] + sine * column[part]
            column[part] = cosine * column[part] - sine * own[part]
            own[part] = turned
        own[row] = length


def _dot(a: Array, b: Array) -> float:
    """Return aᵀ b by four sums side by side, as estimation/arrays.c has it."""
    sums, whole = np.zeros(4), len(a) // 4 * 4
    for i in range(0, whole, 4):
        sums += a[i : i + 4] * b[i : i + 4]
    for i in range(whole, len(a)):
        sums[0] += a[i] * b[i]
    return float((sums[0] + sums[1]) + (sums[2] + sums[3]))
