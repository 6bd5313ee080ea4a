"""Discretisation of a linear system by SciPy's matrix exponential.

Van Loan (1978), Computing integrals involving the matrix exponential, IEEE Trans. Automatic
Control 23(3).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

Array = NDArray[np.float64]


def discretised(A: Array, B: Array, Q: Array, dt: float) -> tuple[Array, Array, Array]:
    """Return F, the gain of inputs held over a step, and the covariance of its noise."""
    n, m = B.shape
    held = expm(dt * np.block([[A, B], [np.zeros((m, n + m))]]))
    both = expm(dt * np.block([[-A, Q], [np.zeros((n, n)), A.T]]))
    F = held[:n, :n]
    return F, held[:n, n:], F @ both[:n, n:]
