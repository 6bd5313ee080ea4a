"""One Gauss-Newton step of a window whose trajectory need not obey its dynamics, densely.

Around a trajectory (x̃, w̃) the window is the least-squares problem

    min  ½‖L̄⁻¹ (x̃_0 + δ_0 - x̄)‖² + ½ Σ‖r_k + J_k δ_k‖² + ½ Σ‖w_k‖²
    s.t. x̃_{k+1} + δ_{k+1} = f(x̃_k, w̃_k) + F_k δ_k + G_k (w_k - w̃_k)

in δ_0 and the noises, solved with NumPy's least squares.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def gauss_newton_step(
    prior: tuple[Array, Array],
    trajectory: tuple[Array, Array],
    step: Callable[[int, Array, Array], tuple[Array, Array, Array]],
    readings: Callable[[int, Array], tuple[Array, Array]],
) -> tuple[Array, Array, Array]:
    """Return the linearised window's states, noises and covariance of the newest state.

    Parameters
    ----------
    prior : mean and covariance of the first state
    trajectory : states (N+1, n_x) and noises (N, n_w) to linearise at
    step : k, x, w → f, F, G
    readings : k, x → residual over its standard deviations, and its Jacobian
    """
    (mean, P), (x, w) = prior, trajectory
    n_x, n_w, n_z = len(mean), w.shape[1], len(mean) + w.size
    whiten = np.linalg.inv(np.linalg.cholesky(P))
    # δ_k = offset + X z, with z = (δ_0, w_0, w_1, …)
    offset, X = np.zeros(n_x), np.eye(n_x, n_z)
    rows, right, states = [whiten @ X], [whiten @ (mean - x[0])], []
    for k in range(len(x)):
        states.append((offset, X))
        r, J = readings(k, x[k])
        rows.append(J @ X)
        right.append(-r - J @ offset)
        if k == len(w):
            break
        reached, F, G = step(k, x[k], w[k])
        noise = np.eye(n_w, n_z, n_x + k * n_w)
        rows.append(noise)
        right.append(np.zeros(n_w))
        offset = reached - x[k + 1] + F @ offset - G @ w[k]
        X = F @ X + G @ noise
    A = np.vstack(rows)
    z = np.linalg.lstsq(A, np.concatenate(right), rcond=None)[0]
    half = np.linalg.inv(np.linalg.qr(A, mode="r"))
    newest = states[-1][1] @ half
    found = np.array([x[k] + d + D @ z for k, (d, D) in enumerate(states)])
    return found, z[n_x:].reshape(w.shape), newest @ newest.T
