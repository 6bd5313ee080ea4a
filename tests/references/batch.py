"""The full-length window as one least-squares problem, in plain NumPy and SciPy.

Unknown are the unit noises z = (z₋₁, w_0, …, w_{N-1}), the states follow:

    x_0 = x̄ + L̄ z₋₁,   x_{k+1} = F_k x_k + G_k w_k,   min ½‖z‖² + ½‖r(x_0, …, x_N)‖²

with r the readings' residuals in standard deviations. Everything is safe for
complex steps, so the Jacobian is exact.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.optimize import least_squares

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Solution:
    """States (N+1, n_x) at the optimum, their standard deviations, the noises z and the cost."""

    states: Array
    std: Array
    z: Array
    cost: float


@dataclass(frozen=True)
class BatchProblem:
    """A window with a linear transition.

    Parameters
    ----------
    mean, L : prior mean and lower Cholesky factor of its covariance
    F, G : N matrices each, x_{k+1} = F x_k + G w_k
    readings : states (N+1, n_x) → residuals over their standard deviations
    """

    mean: Array
    L: Array
    F: list[Array]
    G: list[Array]
    readings: Callable[[Array], Array]

    @property
    def n_z(self) -> int:
        return len(self.mean) + sum(G.shape[1] for G in self.G)

    def states(self, z: Array) -> Array:
        """Roll the states out."""
        n_x = len(self.mean)
        x, start = self.mean + self.L @ z[:n_x], n_x
        states = [x]
        for F, G in zip(self.F, self.G, strict=True):
            x = F @ x + G @ z[start : start + G.shape[1]]
            start += G.shape[1]
            states.append(x)
        return np.array(states)

    @cached_property
    def slopes(self) -> Array:
        """∂x/∂z (N+1, n_x, n_z), the same at every z."""
        linear = replace(self, mean=np.zeros(len(self.mean)))
        return np.array([linear.states(e) for e in np.eye(self.n_z)]).transpose(1, 2, 0)

    @cached_property
    def instants(self) -> NDArray[np.intp]:
        """(n_r,) the instant of each row of the readings: it is lost with that state."""
        states, lost = self.states(np.zeros(self.n_z)), []
        for k in range(len(states)):
            without = states.copy()
            without[k] = np.nan
            lost.append(np.isnan(self.readings(without)))
        assert (np.sum(lost, axis=0) == 1).all()
        return np.argmax(lost, axis=0)

    def noises(self, states: Array) -> Array:
        """Return the z that gives a trajectory; every G must be a lower triangle."""
        parts = [solve_triangular(self.L, states[0] - self.mean, lower=True)]
        for k, (F, G) in enumerate(zip(self.F, self.G, strict=True)):
            parts.append(solve_triangular(G, states[k + 1] - F @ states[k], lower=True))
        return np.concatenate(parts)

    def residual(self, z: Array) -> Array:
        """Return the whitened residual: its half sum of squares is the cost."""
        return np.concatenate([z, self.readings(self.states(z))])

    def cost(self, states: Array) -> float:
        """Return the cost of a trajectory."""
        return 0.5 * float(np.sum(self.residual(self.noises(states)) ** 2))

    def jacobian(self, z: Array) -> Array:
        """Return the residual's Jacobian, by complex steps of all instants' states at once."""
        step, states, n_x = 1e-100, self.states(z), len(self.mean)
        columns = [self.readings(states + 1j * step * e).imag / step for e in np.eye(n_x)]
        of_readings = np.einsum("ir,riz->rz", columns, self.slopes[self.instants])
        return np.vstack([np.eye(len(z)), of_readings])

    def solve(self) -> Solution:
        """Minimise from the prior mean without noise; standard deviations are Gauss-Newton's.

        SciPy stops when the cost stands still, which leaves up to 1e-7 standard
        deviations; one more Gauss-Newton step brings the rest.
        """
        found = least_squares(
            self.residual,
            np.zeros(self.n_z),
            jac=self.jacobian,
            xtol=1e-15,
            ftol=1e-15,
            gtol=1e-15,
            x_scale="jac",
        )
        J = self.jacobian(found.x)
        z = found.x - np.linalg.lstsq(J, self.residual(found.x), rcond=None)[0]
        half = np.linalg.inv(np.linalg.qr(self.jacobian(z), mode="r"))
        std = np.sqrt(np.sum((self.slopes @ half) ** 2, axis=2))
        cost = 0.5 * float(np.sum(self.residual(z) ** 2))
        return Solution(self.states(z), std, z, cost)


def linear_readings(y: Array, H: Array, noise_std: Array) -> Callable[[Array], Array]:
    """Return the residual of readings y (N+1, n_y) of y = H x, without the missing ones."""
    there = ~np.isnan(y)
    return lambda states: ((y - states @ H.T) / noise_std)[there]


def white_jerk_step(dt: float, densities: Array) -> tuple[Array, Array]:
    """Return F and G of constant acceleration under white jerk, one density per coordinate."""
    A = np.array([[1, dt, dt**2 / 2], [0, 1, dt], [0, 0, 1]])
    Q = np.array(
        [
            [dt**5 / 20, dt**4 / 8, dt**3 / 6],
            [dt**4 / 8, dt**3 / 3, dt**2 / 2],
            [dt**3 / 6, dt**2 / 2, dt],
        ]
    )
    # In units of a whole step the factorisation does not suffer from small dt.
    units = np.array([dt**2.5, dt**1.5, dt**0.5])
    C = np.linalg.cholesky(Q / np.outer(units, units))
    identity = np.eye(len(densities))
    return np.kron(A, identity), np.kron(units[:, None] * C, np.diag(densities))
