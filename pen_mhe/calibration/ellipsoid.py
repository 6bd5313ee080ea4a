"""The ellipsoid nearest to readings of a turning vector, by linear least squares.

    yᵀ A y + aᵀ y = 1        A symmetric: nine numbers, linear

Its centre is the bias; with ``(y - b)ᵀ M (y - b) = 1`` and M = g⁻² S⁻² it is S = M^(-1/2) / g. What
it minimises is no distance, so it only begins `pen_mhe.calibration.length.fit_length`.

References
----------
Merayo, Brauer, Primdahl, Petersen, Nielsen (2000), Scalar calibration of vector magnetometers,
Measurement Science and Technology 11.
"""

from __future__ import annotations

import numpy as np

from models.arrays import Array

PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


def ellipsoid(readings: Array, length: float) -> tuple[Array, Array] | None:
    """Return bias (3,) and sensitivity (3, 3), symmetric; None where they lie on no ellipsoid.

    Parameters
    ----------
    readings : (n, 3)
    length : g, of the vector that they read
    """
    middle = readings.mean(axis=0)
    y = (readings - middle) / length
    columns = [y[:, i] * y[:, j] * (1 if i == j else 2) for i, j in PAIRS]
    design = np.column_stack([*columns, y])
    found, _, rank, _ = np.linalg.lstsq(design, np.ones(len(y)), rcond=None)
    if rank < design.shape[1]:
        return None
    A = np.zeros((3, 3))
    for value, (i, j) in zip(found, PAIRS, strict=False):
        A[i, j] = A[j, i] = value
    if np.linalg.eigvalsh(A).min() <= 0:
        return None
    centre = -np.linalg.solve(A, found[6:]) / 2
    M = A / (1 + centre @ A @ centre)
    values, axes = np.linalg.eigh(M)
    return middle + length * centre, (axes / np.sqrt(values)) @ axes.T
