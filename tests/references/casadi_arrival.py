"""The arrival cost of CasADi's own MHE example, mistakes and all, on a linear model.

NumPy only, one least-squares problem per window. Its two mistakes (casadi
issue 4226): the gain is made with R, a weight, where a covariance belongs, and the
scalar process noise is added to every entry of a 2 × 2 covariance. What that
example calls P is weighted with its inverse, as there.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def newest_states(
    F: Array,
    G: Array,
    H: Array,
    y: Array,
    x_prior: Array,
    P: Array,
    noise_std: float,
    disturbance_std: float,
    n_nodes: int,
) -> Array:
    """Return the newest state (n, n_x) of every full window; rows before the first are NaN.

    Parameters
    ----------
    F, G, H : (n_x, n_x), (n_x, 1), (1, n_x): x_{k+1} = F x_k + G d_k, y_k = H x_k
    y : (n,)
    x_prior, P : (n_x,), (n_x, n_x)
    disturbance_std : of d
    """
    n_x, found = len(F), np.full((len(y), len(F)), np.nan)
    weight_y, weight_d = 1 / noise_std**2, 1 / disturbance_std**2
    for first in range(len(y) - n_nodes + 1):
        window = y[first : first + n_nodes]
        columns = n_x + n_nodes - 1
        S = np.linalg.cholesky(np.linalg.inv(P)).T
        rows, right = [np.hstack([S, np.zeros((n_x, n_nodes - 1))])], [S @ x_prior]
        to_state = np.hstack([np.eye(n_x), np.zeros((n_x, n_nodes - 1))])
        trajectory = []
        for k in range(n_nodes):
            trajectory.append(to_state)
            rows.append(np.sqrt(weight_y) * H @ to_state)
            right.append(np.sqrt(weight_y) * window[k : k + 1])
            if k < n_nodes - 1:
                disturbance = np.zeros((1, columns))
                disturbance[0, n_x + k] = 1
                rows.append(np.sqrt(weight_d) * disturbance)
                right.append(np.zeros(1))
                to_state = F @ to_state + G @ disturbance
        solution = np.linalg.lstsq(np.vstack(rows), np.concatenate(right), rcond=None)[0]
        found[first + n_nodes - 1] = trajectory[-1] @ solution
        K = P @ H.T / (H @ P @ H.T + weight_y)
        P = (np.eye(n_x) - K @ H) @ P
        x_prior = x_prior + (K * (window[0] - H @ x_prior)).ravel()
        x_prior = F @ x_prior + (G * solution[n_x]).ravel()
        P = F @ P @ F.T + disturbance_std**2
    return found
