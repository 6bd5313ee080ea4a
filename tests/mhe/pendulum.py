"""A pendulum whose transition is nonlinear in its state and in its noise, by hand.

θ⁺ = θ + ω Δt + a √Δt w₀
ω⁺ = ω - k sinθ Δt + b √Δt (w₁ + c w₁³)
"""

from __future__ import annotations

import casadi as ca
import numpy as np
from scipy.optimize import least_squares

from estimation.recording import Measurement
from models.arrays import Array
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel
from tests.linear_models import random_walk_system

K, A_NOISE, B_NOISE, CUBIC = 30.0, 0.05, 1.0, 0.3
SINE_STD, RATE_STD = 0.05, 0.5
PRIOR_MEAN, PRIOR_STD = np.array([0.5, 0.0]), np.array([1.0, 2.0])


def step(x: Array, w: Array, dt: float) -> Array:
    """Return f(x, w, Δt); complex steps pass through."""
    angle = x[0] + x[1] * dt + A_NOISE * np.sqrt(dt) * w[0]
    shaken = B_NOISE * np.sqrt(dt) * (w[1] + CUBIC * w[1] ** 3)
    return np.array([angle, x[1] - K * np.sin(x[0]) * dt + shaken])


def derivatives(x: Array, w: Array, dt: float) -> tuple[Array, Array]:
    """F and G, differentiated by hand."""
    F = np.array([[1.0, dt], [-K * np.cos(x[0]) * dt, 1.0]])
    return F, np.sqrt(dt) * np.diag([A_NOISE, B_NOISE * (1 + 3 * CUBIC * w[1] ** 2)])


def model() -> StateSpaceModel:
    """The pendulum; its sensors read sinθ and ω."""
    x, w, dt = ca.SX.sym("x", 2), ca.SX.sym("w", 2), ca.SX.sym("dt")
    shaken = B_NOISE * ca.sqrt(dt) * (w[1] + CUBIC * w[1] ** 3)
    angle = x[0] + x[1] * dt + A_NOISE * ca.sqrt(dt) * w[0]
    f = ca.Function("f", [x, w, dt], [ca.vertcat(angle, x[1] - K * ca.sin(x[0]) * dt + shaken)])
    y = ca.SX.sym("y", 2)
    h = ca.vertcat(ca.sin(x[0]), x[1])
    template = random_walk_system(2, q=1.0, r=1.0, p0=1.0).model
    (sensor,) = template.sensors
    readings = {
        "h": ca.Function("h", [x], [h]),
        "residual": ca.Function("residual", [y, x], [y - h]),
        "noise_std": np.array([SINE_STD, RATE_STD]),
    }
    return template.replace(
        f=f,
        sensors=(type(sensor)(**{**sensor.__dict__, **readings}),),
        prior=GaussianState(PRIOR_MEAN, np.diag(PRIOR_STD**2)),
    )


def simulate(n: int, seed: int) -> list[Measurement]:
    """Draw readings; a third of the rows is missing."""
    rng = np.random.default_rng(seed)
    times = np.cumsum(rng.uniform(0.01, 0.08, n))
    x, measurements = PRIOR_MEAN + PRIOR_STD * rng.standard_normal(2), []
    for k, time_s in enumerate(times):
        if k:
            x = step(x, rng.standard_normal(2), time_s - times[k - 1])
        y = np.array([np.sin(x[0]), x[1]]) + [SINE_STD, RATE_STD] * rng.standard_normal(2)
        y[rng.uniform(size=2) < 1 / 3] = np.nan
        measurements.append(Measurement(float(time_s), y))
    return measurements


def eliminate(
    prior: GaussianState, dropped: Measurement, dt: float, x_lin: Array, w_lin: Array | None
) -> GaussianState:
    """One update at x_lin and one prediction by hand; at the filter's own mean without w_lin."""
    there = ~np.isnan(dropped.y)
    H = np.array([[np.cos(x_lin[0]), 0.0], [0.0, 1.0]])[there]
    h = np.array([np.sin(x_lin[0]), x_lin[1]])[there]
    R = np.diag(np.square([SINE_STD, RATE_STD])[there])
    x, P = prior.mean, prior.covariance
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    x, P = x + K @ (dropped.y[there] - h - H @ (x - x_lin)), P - K @ H @ P
    if w_lin is None:
        x_lin, w_lin = x, np.zeros(2)
    F, G = derivatives(x_lin, w_lin, dt)
    reached = step(x_lin, w_lin, dt) + F @ (x - x_lin) - G @ w_lin
    return GaussianState(reached, F @ P @ F.T + G @ G.T)


class PendulumBatch:
    """The window's whitened residual in the unit noises z = (z₋₁, w_0, …)."""

    def __init__(
        self, measurements: list[Measurement], mean: Array = PRIOR_MEAN, L: Array | None = None
    ) -> None:
        self.mean, self.L = mean, np.diag(PRIOR_STD) if L is None else L
        self.steps = np.diff([m.time_s for m in measurements])
        self.y = np.array([m.y for m in measurements])

    def states(self, z: Array) -> Array:
        noises = z.reshape(-1, 2)
        states = [self.mean + self.L @ noises[0]]
        for w, dt in zip(noises[1:], self.steps, strict=True):
            states.append(step(states[-1], w, dt))
        return np.array(states)

    def residual(self, z: Array) -> Array:
        states = self.states(z)
        h = np.stack([np.sin(states[:, 0]), states[:, 1]], axis=1)
        return np.concatenate([z, ((self.y - h) / [SINE_STD, RATE_STD])[~np.isnan(self.y)]])

    def cost(self, z: Array) -> float:
        return 0.5 * float(np.sum(self.residual(z) ** 2))

    def jacobian(self, z: Array) -> Array:
        columns = [self.residual(z + 1e-100j * e).imag / 1e-100 for e in np.eye(len(z))]
        return np.array(columns).T

    def noises(self, states: Array) -> Array:
        """Return the z that gives a trajectory."""
        parts = [np.linalg.solve(self.L, states[0] - self.mean)]
        for k, dt in enumerate(self.steps):
            left = (states[k + 1] - step(states[k], np.zeros(2), dt)) / np.sqrt(dt)
            roots = np.roots([CUBIC, 0.0, 1.0, -left[1] / B_NOISE])
            parts.append(np.array([left[0] / A_NOISE, roots[np.argmin(np.abs(roots.imag))].real]))
        return np.concatenate(parts)

    def solve(self, start: Array) -> tuple[Array, Array]:
        """Return the optimal states and their standard deviations, from a start z."""
        tight = {"xtol": 1e-15, "ftol": 1e-15, "gtol": 1e-15, "x_scale": "jac"}
        z = least_squares(self.residual, start, jac=self.jacobian, **tight).x
        J = self.jacobian(z)
        T = [self.states(z + 1e-100j * e).imag / 1e-100 for e in np.eye(len(z))]
        half = np.linalg.inv(np.linalg.qr(J, mode="r"))
        std = np.sqrt(np.sum((np.array(T).transpose(1, 2, 0) @ half) ** 2, axis=2))
        return self.states(z), std
