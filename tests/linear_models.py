"""Linear state-space models, with the matrices that a textbook filter needs for them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from estimation.recording import Measurement
from models.arrays import Array
from models.gaussian import GaussianState
from models.manifold import additive_manifold, always_regular, no_inequality
from models.process_noise import constant_acceleration, white_jerk_factor
from models.sensor_model import SensorModel
from models.state_space import StateSpaceModel
from tests.references import kalman


@dataclass(frozen=True, eq=False)
class LinearSystem:
    """A model and, typed independently of CasADi, its F(Δt), Q(Δt), H and R."""

    model: StateSpaceModel
    F: Callable[[float], Array]
    Q: Callable[[float], Array]
    H: Array
    R: Array

    def steps(self, times: Array) -> list[tuple[Array, Array]]:
        """F and a lower factor of Q for every step between times."""
        return [(self.F(dt), np.linalg.cholesky(self.Q(dt))) for dt in np.diff(times)]

    def textbook(self, measurements: Sequence[Measurement]) -> list[kalman.Posterior]:
        """Return the textbook filter's posterior for every measurement."""
        prior = self.model.prior
        return kalman.run(
            (prior.mean, prior.covariance),
            [measurement.time_s for measurement in measurements],
            [measurement.y for measurement in measurements],
            self.F,
            self.Q,
            self.H,
            self.R,
        )

    def simulate(
        self, times: Array, rng: np.random.Generator, missing: float = 0.3
    ) -> list[Measurement]:
        """Draw a trajectory from the prior and its readings, each row missing at random."""
        prior, n_x = self.model.prior, self.model.n_x
        x = prior.mean + np.linalg.cholesky(prior.covariance) @ rng.standard_normal(n_x)
        measurements = []
        for k, time_s in enumerate(times):
            if k:
                dt = time_s - times[k - 1]
                x = self.F(dt) @ x + np.linalg.cholesky(self.Q(dt)) @ rng.standard_normal(n_x)
            noise = np.sqrt(np.diag(self.R)) * rng.standard_normal(len(self.H))
            y = np.where(rng.uniform(size=len(self.H)) < missing, np.nan, self.H @ x + noise)
            measurements.append(Measurement(float(time_s), y))
        return measurements


def linear_system(
    f: ca.Function,
    sensors: dict[str, tuple[Array, Array]],
    prior: GaussianState,
    F: Callable[[float], Array],
    Q: Callable[[float], Array],
) -> LinearSystem:
    """Put a linear system together; sensors: name → (H, standard deviations)."""
    n_x = len(prior.mean)
    x = ca.SX.sym("x", n_x)
    models = []
    for name, (H, std) in sensors.items():
        y, h = ca.SX.sym("y", len(H)), ca.densify(ca.DM(H) @ x)
        units = ("m",) * len(H)
        models.append(
            SensorModel(
                name=name,
                kind="linear",
                axes=tuple(str(i) for i in range(len(H))),
                unit_of_axis=units,
                h=ca.Function(f"h_{name}", [x], [h]),
                residual=ca.Function(f"residual_{name}", [y, x], [y - h]),
                noise_std=std,
                unit_of_row=units,
            )
        )
    retract, difference = additive_manifold([False] * n_x)
    model = StateSpaceModel(
        name="linear",
        state_names=tuple(f"s{i}_m" for i in range(n_x)),
        state_units=("m",) * n_x,
        f=f,
        sensors=tuple(models),
        prior=prior,
        retract=retract,
        difference=difference,
        lower=np.full(n_x, -np.inf),
        upper=np.full(n_x, np.inf),
        inequality=no_inequality(n_x),
        regularity=always_regular(n_x),
    )
    H = np.vstack([H for H, _ in sensors.values()])
    std = np.concatenate([std for _, std in sensors.values()])
    return LinearSystem(model, F, Q, H, np.diag(std**2))


def constant_acceleration_system(n_axes: int, density: float = 1.0) -> LinearSystem:
    """White jerk on every axis; one sensor reads positions, one accelerations."""
    n_x, identity = 3 * n_axes, np.eye(n_axes)
    x, w, dt = ca.SX.sym("x", n_x), ca.SX.sym("w", n_x), ca.SX.sym("dt")
    A = ca.kron(constant_acceleration(dt), ca.SX.eye(n_axes))
    G = density * ca.kron(white_jerk_factor(dt), ca.SX.eye(n_axes))

    def F(dt: float) -> Array:
        return np.kron([[1, dt, dt**2 / 2], [0, 1, dt], [0, 0, 1]], identity)

    def Q(dt: float) -> Array:
        per_axis = [
            [dt**5 / 20, dt**4 / 8, dt**3 / 6],
            [dt**4 / 8, dt**3 / 3, dt**2 / 2],
            [dt**3 / 6, dt**2 / 2, dt],
        ]
        return density**2 * np.kron(per_axis, identity)

    sensors = {
        "position": (np.eye(n_axes, n_x), np.full(n_axes, 0.05)),
        "acceleration": (np.eye(n_axes, n_x, 2 * n_axes), np.full(n_axes, 0.3)),
    }
    mean = np.linspace(-0.5, 0.5, n_x)
    root = np.diag(np.repeat([1.0, 2.0, 3.0], n_axes)) + 0.2 * np.tri(n_x, k=-1)
    prior = GaussianState(mean, root @ root.T)
    return linear_system(ca.Function("f", [x, w, dt], [A @ x + G @ w]), sensors, prior, F, Q)


def coupled_system(seed: int) -> LinearSystem:
    """A random stable system of four states with two sensors, of one and of two rows.

    Four decaying modes, each driven by white noise of its own, seen in random
    coordinates: x = T m, so F and Q are dense.
    """
    rng = np.random.default_rng(seed)
    decay, strength = rng.uniform(0.2, 4.0, 4), rng.uniform(0.3, 2.0, 4)
    T = np.linalg.qr(rng.standard_normal((4, 4)))[0] @ np.diag(rng.uniform(0.5, 2.0, 4))
    T_inverse = np.linalg.inv(T)
    x, w, dt = ca.SX.sym("x", 4), ca.SX.sym("w", 4), ca.SX.sym("dt")
    rates = ca.DM(decay)
    modes = ca.diag(ca.exp(-rates * dt)) @ (ca.DM(T_inverse) @ x)
    shaken = ca.DM(strength) * ca.sqrt((1 - ca.exp(-2 * rates * dt)) / (2 * rates)) * w

    def F(dt: float) -> Array:
        return T @ np.diag(np.exp(-decay * dt)) @ T_inverse

    def Q(dt: float) -> Array:
        return T @ np.diag(strength**2 * (1 - np.exp(-2 * decay * dt)) / (2 * decay)) @ T.T

    sensors = {
        "first": (rng.standard_normal((1, 4)), np.array([0.2])),
        "second": (rng.standard_normal((2, 4)), np.array([0.1, 0.4])),
    }
    root = np.tril(rng.standard_normal((4, 4))) + 2 * np.eye(4)
    prior = GaussianState(rng.standard_normal(4), root @ root.T)
    f = ca.Function("f", [x, w, dt], [ca.DM(T) @ (modes + shaken)])
    return linear_system(f, sensors, prior, F, Q)


def random_walk_system(copies: int, q: float, r: float, p0: float) -> LinearSystem:
    """Independent copies of x⁺ = x + N(0, q Δt), y = x + N(0, r), x_0 ~ N(0, p0)."""
    x, w, dt = ca.SX.sym("x", copies), ca.SX.sym("w", copies), ca.SX.sym("dt")
    identity = np.eye(copies)
    sensors = {"level": (identity, np.full(copies, np.sqrt(r)))}
    f = ca.Function("f", [x, w, dt], [x + np.sqrt(q) * ca.sqrt(dt) * w])
    prior = GaussianState(np.zeros(copies), p0 * identity)
    return linear_system(f, sensors, prior, lambda dt: identity, lambda dt: q * dt * identity)


def irregular_times(n: int, rng: np.random.Generator) -> Array:
    """Time stamps between 1 and 60 ms apart, with one pair 1 µs apart and one gap of 0.5 s."""
    steps = rng.uniform(0.001, 0.06, n)
    steps[n // 3], steps[2 * n // 3] = 1e-6, 0.5
    return 3.0 + np.cumsum(steps)
