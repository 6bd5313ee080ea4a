"""One window as a dense least-squares problem in its unit noises, in plain NumPy.

Unknown is z = (w₋₁, w_0, …, w_{N-1}); the states follow from it:

    x_0 = x̄ ⊞ L̄ w₋₁,   x_{k+1} = f(x_k, w_k, Δt_k),   min ½‖z‖² + ½‖r(x_0, …, x_N)‖²

with r the residuals of the readings that are there, in standard deviations. CasADi gives
the Jacobians of one stage, the chain rule the rest. Solved by Gauss-Newton steps
JᵀJ p = -Jᵀr, each halved until the cost falls.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from estimation.recording import Measurement
from estimation.status import Status
from mhe.trajectory import Trajectory, WindowSolution
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel

Array = NDArray[np.float64]

ARMIJO = 1e-4
SMALLEST_STEP = 2.0**-30
CONVERGED = 1e-10
"""Length of a Gauss-Newton step, in standard deviations of its own posterior."""
ROUNDING = 1e-13
"""Of a cost, relative: a step that promises less is taken unseen."""


@dataclass(frozen=True)
class Solution:
    """Where a solver ended: z, its trajectory and cost, iterations, and whether it converged.

    `decrement` is the length of the Gauss-Newton step that would come next, in standard
    deviations.
    """

    z: Array
    trajectory: Trajectory
    cost: float
    iterations: int
    converged: bool
    decrement: float


@cache
def _stage(model: StateSpaceModel) -> tuple[ca.Function, ca.Function, ca.Function]:
    """Return the prior's tangent, the step and the readings of a model with their Jacobians."""
    n_x = model.n_x
    x, w, dt = ca.SX.sym("x", n_x), ca.SX.sym("w", model.n_w), ca.SX.sym("dt")
    y, delta, about = ca.SX.sym("y", model.n_y), ca.SX.sym("delta", n_x), ca.SX.sym("about", n_x)
    zero = ca.SX.zeros(n_x)
    moved = model.retract(x, delta)
    arrived = model.difference(moved, about)
    T = ca.substitute(ca.jacobian(arrived, delta), about, moved)
    prior = ca.Function("prior", [x, delta], [moved, T])
    reached = model.f(moved, w, dt)
    difference = model.difference(reached, about)
    F, G = (
        ca.substitute(ca.substitute(ca.jacobian(difference, of), about, reached), delta, zero)
        for of in (delta, w)
    )
    step = ca.Function("step", [x, w, dt], [model.f(x, w, dt), F, G])
    parts, start = [], 0
    for sensor in model.sensors:
        parts.append(sensor.residual(y[start : start + sensor.n_y], moved) / sensor.noise_std)
        start += sensor.n_y
    r = ca.vertcat(*parts)
    readings = ca.Function(
        "readings", [x, y], [ca.substitute(e, delta, zero) for e in (r, ca.jacobian(r, delta))]
    )
    return prior, step, readings


class DenseWindow:
    """The least-squares problem of one window.

    Parameters
    ----------
    model, prior, measurements : of the window
    """

    def __init__(
        self, model: StateSpaceModel, prior: GaussianState, measurements: Sequence[Measurement]
    ) -> None:
        self.model, self.mean = model, prior.mean
        self.L = np.linalg.cholesky(prior.covariance)
        self.dt = np.diff([m.time_s for m in measurements])
        self._prior, self._step, self._readings = _stage(model)
        self.y = np.array([m.y for m in measurements])
        # A row counts if all that it needs is finite and within its sensor's range.
        usable = np.isfinite(self.y) & (np.abs(np.nan_to_num(self.y)) < model.saturation)
        needs = model.row_needs.astype(int)
        self.there = (~usable).astype(int) @ needs.T == 0
        self.y = np.where(np.isfinite(self.y), self.y, 0.0)
        self.n_z = model.n_x + len(self.dt) * model.n_w

    def start(self, guess: Trajectory) -> Array:
        """Return the z of a trajectory that obeys the dynamics."""
        away = np.asarray(self.model.difference(guess.states[0], self.mean)).ravel()
        return np.concatenate([np.linalg.solve(self.L, away), guess.noises.ravel()])

    def trajectory(self, z: Array) -> Trajectory:
        """Roll the states out."""
        w = z[self.model.n_x :].reshape(len(self.dt), self.model.n_w)
        states = [self._prior(self.mean, self.L @ z[: self.model.n_x])[0].full().ravel()]
        for k, dt in enumerate(self.dt):
            states.append(self.model.f(states[-1], w[k], dt).full().ravel())
        return Trajectory(np.array(states), w)

    def cost(self, z: Array) -> float:
        """Return ½ the sum of squares."""
        total = float(z @ z)
        for x, y, there in zip(self.trajectory(z).states, self.y, self.there, strict=True):
            rows = self._readings(x, y)[0].full().ravel()[there]
            total += float(rows @ rows)
        return total / 2

    def linearised(self, z: Array) -> tuple[Array, Array, Array]:
        """Return residual (n,), its Jacobian (n, n_z) and dx_N/dz (n_x, n_z)."""
        n_x, n_w = self.model.n_x, self.model.n_w
        w = z[n_x:].reshape(len(self.dt), n_w)
        X = np.zeros((n_x, self.n_z))
        x, T = (v.full() for v in self._prior(self.mean, self.L @ z[:n_x]))
        X[:, :n_x] = T @ self.L
        residual, J = [z], [np.eye(self.n_z)]
        for k, (y, there) in enumerate(zip(self.y, self.there, strict=True)):
            r, H = (v.full() for v in self._readings(x, y))
            residual.append(r.ravel()[there])
            J.append((H @ X)[there])
            if k < len(self.dt):
                x, F, G = (v.full() for v in self._step(x, w[k], self.dt[k]))
                X = F @ X
                columns = slice(n_x + k * n_w, n_x + (k + 1) * n_w)
                X[:, columns] += G
        return np.concatenate(residual), np.vstack(J), X


class DenseGaussNewton:
    """The window solver of `suites.optimum.run.WindowSolver` made of the above."""

    def __init__(self, model: StateSpaceModel) -> None:
        self.model = model

    def solve(
        self, prior: GaussianState, measurements: tuple[Measurement, ...], guess: Trajectory
    ) -> WindowSolution:
        window = DenseWindow(self.model, prior, measurements)
        found = line_search(window, window.start(guess))
        _, J, X = window.linearised(found.z)
        covariance = X @ cho_solve(cho_factor(J.T @ J), X.T)
        newest = GaussianState(found.trajectory.states[-1], covariance)
        status = Status.SOLVED if found.converged else Status.ITERATION_LIMIT
        return WindowSolution(found.trajectory, newest, found.cost, status, found.iterations)


def line_search(window: DenseWindow, z: Array, max_iterations: int = 300) -> Solution:
    """Gauss-Newton steps, each halved until the cost falls enough."""
    cost, length, iteration = window.cost(z), np.inf, 0
    for iteration in range(max_iterations):
        r, J, _ = window.linearised(z)
        p = gauss_newton_step(r, J)
        slope = -float((J @ p) @ (J @ p))
        length = np.sqrt(-slope)
        if length < CONVERGED:
            return _solution(window, z, cost, iteration, True, length)
        step, tried = 1.0, window.cost(z + p)
        if -slope > ROUNDING * max(1.0, cost):
            while not tried <= cost + ARMIJO * step * slope:
                step /= 2
                if step < SMALLEST_STEP:
                    return _solution(window, z, cost, iteration, False, length)
                tried = window.cost(z + step * p)
        z, cost = z + step * p, tried
    return _solution(window, z, cost, iteration + 1, False, length)


def gauss_newton_step(r: Array, J: Array) -> Array:
    """Solve JᵀJ p = -Jᵀr; J holds an identity, so JᵀJ ≥ I."""
    return cho_solve(cho_factor(J.T @ J), -J.T @ r)


def _solution(
    window: DenseWindow, z: Array, cost: float, iterations: int, converged: bool, length: float
) -> Solution:
    return Solution(z, window.trajectory(z), cost, iterations, converged, length)
