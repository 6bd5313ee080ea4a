"""An arrival cost of an EKF against one at the window's estimate: python docs/arrival_cost.py

Three problems of the field (two gases, A <-> B + C with 2B <-> C, Van der Pol), drawn anew for
every seed; the fraction of runs in which each estimator finds the truth.
"""

import sys

import casadi as ca
import numpy as np

import pen_mhe as pm
from estimation import run_measurements

HORIZON = 10
POSITIVE = (0, None)


def step(rate, density):
    """Return a transition by one Runge-Kutta step; noise of a density is added."""
    follow = pm.ode(lambda x, w: rate(x))
    return lambda x, w, dt: follow(x, w, dt) + density * ca.sqrt(dt) * w


def two_gases(x):
    """2A -> B."""
    return ca.vertcat(-2, 1) * 0.16 * x[0] ** 2


def three_gases(x):
    """A <-> B + C, 2B <-> C."""
    r1, r2 = 0.5 * x[0] - 0.05 * x[1] * x[2], 0.2 * x[1] ** 2 - 0.01 * x[2]
    return ca.vertcat(-r1, r1 - 2 * r2, r1 + r2)


def van_der_pol(x):
    """With its parameter as a state."""
    return ca.vertcat(x[1], x[2] * (1 - x[0] ** 2) * x[1] - x[0], 0)


def model(name, rate, density, states, reads, std, bounds=None):
    """Return a model whose one sensor reads an expression of its states."""
    sensor = pm.OwnSensor(reads, {"value": ""}, std)
    return pm.own_model(
        name, states, step(rate, density), len(states), {"y": sensor}, bounds=bounds or {}
    )


PROBLEMS = {
    "2A -> B": (
        lambda bounds: model(
            "2A", two_gases, 1e-3 / 0.1**0.5, {"pa": (0.1, 6), "pb": (4.5, 6)},
            lambda x: x[0] + x[1], 0.1,
            {"pa": POSITIVE, "pb": POSITIVE} if bounds else None,
        ), [3, 1], 0.1, 101, lambda m, s, x: rms(m[51:, 0] - x[51:, 0]) < 0.2,
    ),
    "A, B, C": (
        lambda bounds: model(
            "ABC", three_gases, 1e-3 / 0.25**0.5, {"a": (1, 0.5), "b": (0, 0.5), "c": (4, 0.5)},
            lambda x: 32.84 * (x[0] + x[1] + x[2]), 0.25,
            dict.fromkeys("abc", POSITIVE) if bounds else None,
        ), [0.5, 0.05, 0], 0.25, 121, lambda m, s, x: rms(m[60:, 2] - x[60:, 2]) < 0.01,
    ),
    "Van der Pol": (
        lambda bounds: model(
            "vdp", van_der_pol, 1e-3, {"x": (1, 0.5), "v": (0, 1), "mu": (3, 2)},
            lambda x: x[0], 0.05,
        ), [1, 0.5, 1], 0.1, 150, lambda m, s, x: rms((m[75:, 2] - x[75:, 2]) / s[75:, 2]) < 3,
    ),
}  # fmt: skip
"""Model with and without bounds, truth, step (s), samples, what succeeds."""


def rms(values):
    """Return the root of the mean square."""
    return np.sqrt(np.mean(np.square(values)))


def drawn(model, truth, dt, samples, seed):
    """Return readings of a truth that the model's own noise moves, and the states."""
    rng, x, states, readings = np.random.default_rng(seed), np.array(truth, float), [], []
    for k in range(samples):
        states.append(x)
        y = model.sensors[0].h(x).full().ravel()
        readings.append(pm.Measurement(k * dt, y + model.noise_std * rng.standard_normal(1)))
        x = model.f(x, rng.standard_normal(model.n_w), dt).full().ravel()
    return readings, np.array(states)


def main(seeds):
    """Print a row per problem and estimator."""
    for name, (build, truth, dt, samples, succeeds) in PROBLEMS.items():
        free, bounded = build(bounds=False), build(bounds=True)
        contenders = {"ekf": pm.create_estimator("ekf", free)}
        for arrival in ("filtered", "smoothed"):
            for label, estimator, more in (
                ("mhe-rti", "mhe-rti", {}),
                ("mhe-rti, full passes", "mhe-rti", {"reuse_threshold": 0.0}),
                ("mhe", "mhe", {}),
            ):
                contenders[f"{label}, {arrival}"] = pm.create_estimator(
                    estimator, bounded, horizon=HORIZON, arrival_cost=arrival, **more
                )
        for label, estimator in contenders.items():
            found = 0
            for seed in range(seeds):
                readings, states = drawn(free, truth, dt, samples, seed)
                history = run_measurements(estimator, readings)
                found += succeeds(history.mean, history.std, states)
            print(f"{name:12s} {label:32s} {found} of {seeds}", flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 100)
