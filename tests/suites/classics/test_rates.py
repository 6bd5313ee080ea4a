"""The equations of the classics: what must hold of them, whoever wrote them down."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from models.arrays import Array
from suites.classics.kalman import filtered
from suites.classics.problems import figures_of, problem_named
from suites.classics.recordings import SENSOR, model_of, prior_of, recorded
from tests.references import kalman


def rate_of(case: str, x: Array, u: Array) -> Array:
    return np.array(ca.DM(problem_named(case).rate(ca.DM(x), ca.DM(u), figures_of(case)))).ravel()


def test_the_discs_lose_energy_by_their_dampers_alone() -> None:
    """Motors held: d/dt (½ Σ θ_i φ_i'² + ½ Σ c_i (φ_i - φ_{i-1})²) = -Σ d_i φ_i'²."""
    given, rng = figures_of("rotating_masses"), np.random.default_rng(0)
    x = np.append(rng.normal(size=8), 3e-4)
    angles, turns, motors = x[:3], x[3:6], x[6:8]
    theta = np.array([x[8], given["theta_2_3"], given["theta_2_3"]])
    moved = rate_of("rotating_masses", x, motors)
    stretched = np.diff([motors[0], *angles, motors[1]])
    stretching = np.diff([0, *turns, 0])
    power = theta * turns @ moved[3:6] + given["spring_c"] * stretched @ stretching
    assert power == pytest.approx(-np.array(given["damping_d"]) @ turns**2)
    assert moved[:3] == pytest.approx(turns)
    assert moved[6:] == pytest.approx(0)


def test_a_motor_follows_its_set_point() -> None:
    lag = figures_of("rotating_masses")["motor_lag_s"]
    moved = rate_of("rotating_masses", np.append(np.zeros(8), 2e-4), np.array([0.5, -0.1]))
    assert moved[6:8] == pytest.approx([0.5 / lag, -0.1 / lag])


def test_the_pendulum_keeps_its_energy_but_for_the_force() -> None:
    """T + V of cart and ball, which is at (x - l sin θ, l cos θ): its rate is force × v."""
    given, rng = figures_of("pendulum_on_cart"), np.random.default_rng(1)
    (cart, ball), g = given["masses_kg"], given["gravity_m_s2"]
    x, force = np.append(rng.normal(size=4), 0.7), 3.0
    moved = rate_of("pendulum_on_cart", x, np.array([force]))

    def energy(s: Array) -> float:
        _, theta, v, omega, length = s
        across = v - length * np.cos(theta) * omega
        down = -length * np.sin(theta) * omega
        kinetic = cart * v**2 + ball * (across**2 + down**2)
        return float(kinetic / 2 + ball * g * length * np.cos(theta))

    h = 1e-5
    power = (energy(x + h * moved) - energy(x - h * moved)) / (2 * h)
    assert power == pytest.approx(force * x[2], rel=1e-6)


def test_ten_steps_follow_a_motors_lag() -> None:
    """Against so many more that they count as exact: far below a reading's noise."""
    model, problem = model_of("rotating_masses"), problem_named("rotating_masses")
    given, x = figures_of("rotating_masses"), np.append(np.full(8, 0.3), 2.25e-4)
    u, dt = np.array([0.8, -0.8]), given["dt_s"]
    exact, n = x, 500
    for _ in range(n):
        half = exact + dt / n / 2 * rate_of("rotating_masses", exact, u)
        exact = exact + dt / n * rate_of("rotating_masses", half, u)
    moved = model.f(x, 0, dt, u, u).full().ravel()
    assert problem.substeps == 10
    assert np.abs(moved - exact)[:3].max() < 0.01 * given["r"]


def test_the_springs_filter_is_the_textbooks() -> None:
    case = "damped_spring"
    recording, given, model = recorded(case, 2), figures_of(case), model_of(case)
    prior, y = prior_of(case, recording, 2), recording.readings[SENSOR]
    (force,) = recording.inputs.values()
    F = np.empty((2, 2))
    for i in range(2):  # the model's f is linear: its columns
        F[:, i] = model.f(np.eye(2)[i], 0, given["dt_s"], 0, 0).full().ravel()
    g = model.f(np.zeros(2), 0, given["dt_s"], 1, 1).full().ravel()
    H, R = np.array([[1.0, 0.0]]), np.array([[given["r"] ** 2]])
    mean, P, means = prior.mean, prior.covariance, []
    for reading, u in zip(y, force, strict=True):
        posterior = kalman.update(mean, P, reading, H, R)
        means.append(posterior.mean)
        mean = F @ posterior.mean + g * u
        P = F @ posterior.covariance @ F.T + given["w"] ** 2 * np.outer(g, g)
    np.testing.assert_allclose(
        filtered(prior, y[:, 0], force, given), np.array(means), rtol=0, atol=1e-13
    )
