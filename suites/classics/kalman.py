"""The textbook's Kalman filter of problem ``damped_spring``, in NumPy: what estimators must equal.

    x_{k+1} = F x_k + G (u_k + w_k),   ẋ = A x + B (u + w)

A Runge-Kutta step of order 4 is the exponential series up to order 4; Joseph form.
"""

from __future__ import annotations

from math import factorial

import numpy as np

from models.arrays import Array
from models.gaussian import GaussianState
from suites.classics.rates import Figures

A, B = np.array([[0.0, 1.0], [-1.0, -0.5]]), np.array([0.0, 1.0])
ORDER = 4


def filtered(prior: GaussianState, y: Array, force: Array, given: Figures) -> Array:
    """Return the means (n, 2) after each reading.

    Parameters
    ----------
    y : (n,) readings of the position
    force : (n,) held from each instant on
    """
    h = given["dt_s"]
    powers = [np.linalg.matrix_power(A, i) for i in range(ORDER + 1)]
    F = sum((h**i / factorial(i) * power for i, power in enumerate(powers)), np.zeros((2, 2)))
    G = B @ sum(
        (h ** (i + 1) / factorial(i + 1) * power.T for i, power in enumerate(powers[:-1])),
        np.zeros((2, 2)),
    )
    Q, R, H = np.outer(G, G) * given["w"] ** 2, given["r"] ** 2, np.array([1.0, 0.0])
    mean, P, means = prior.mean, prior.covariance, []
    for reading, u in zip(y, force, strict=True):
        K = P @ H / (H @ P @ H + R)
        rest = np.eye(2) - np.outer(K, H)
        mean, P = mean + K * (reading - H @ mean), rest @ P @ rest.T + R * np.outer(K, K)
        means.append(mean)
        mean, P = F @ mean + G * u, F @ P @ F.T + Q
    return np.array(means)
