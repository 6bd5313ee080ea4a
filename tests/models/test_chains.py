"""Chains against the matrix exponential and a numerical integral."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from scipy.linalg import expm

from models.arrays import Array
from models.chains import Chain, bounded_velocity, matern, white_jerk

CHAINS = {
    "white jerk": white_jerk(3.0),
    "bounded velocity, a hand": bounded_velocity(0.08, 0.1),
    "bounded velocity, slow": bounded_velocity(2.0, 5.0),
    "Matérn": matern(0.3, 0.1),
}
STEPS = (1e-9, 1e-4, 1 / 119, 0.01, 0.0499, 0.0999, 0.1, 0.11, 0.3, 1.0, 7.0)


def of_step(chain: Chain, dt: float) -> tuple[Array, Array]:
    """F and the factor of Q, as numbers."""
    symbol = ca.SX.sym("dt")
    both = ca.Function("step", [symbol], [chain.transition(symbol), chain.factor(symbol)])
    F, G = both(dt)
    return F.full(), G.full()


def companion(chain: Chain) -> Array:
    """A, typed from the docstring."""
    c0, c1, c2 = chain.last_row
    rate = chain.rate
    return np.array([[0, 1, 0], [0, 0, 1], [-c0 * rate**3, -c1 * rate**2, -c2 * rate]])


def integral(chain: Chain, dt: float) -> Array:
    """∫₀¹ φ φᵀ du Δt, φ = D⁻¹ exp(A Δt u) e₃: Q scaled by D = diag(Δt², Δt, 1)."""
    A = companion(chain)
    D = np.array([dt**2, dt, 1.0])
    # diag(1/D) exp(A s) e3 = exp(A' s) e3 with A' = diag(1/D) A diag(D): no small numbers.
    scaled = A * dt * D[None, :] / D[:, None]

    panels = max(1, round(chain.rate * dt))
    nodes, weights = np.polynomial.legendre.leggauss(24)
    at_nodes = np.array([expm(scaled * (u / panels))[:, 2] for u in (nodes + 1) / 2]).T
    next_panel, found = expm(scaled / panels), np.zeros((3, 3))
    for _ in range(panels):
        found += (at_nodes * weights / 2 / panels) @ at_nodes.T
        at_nodes = next_panel @ at_nodes
    return chain.density**2 * dt * found


@pytest.mark.parametrize("dt", STEPS)
@pytest.mark.parametrize("name", CHAINS)
def test_the_transition_is_the_matrix_exponential(name: str, dt: float) -> None:
    chain = CHAINS[name]
    F, _ = of_step(chain, dt)
    D = np.array([dt**2, dt, 1.0])
    scaled = companion(chain) * dt * D[None, :] / D[:, None]
    np.testing.assert_allclose(F * D[None, :] / D[:, None], expm(scaled), rtol=0, atol=1e-12)


@pytest.mark.parametrize("dt", STEPS)
@pytest.mark.parametrize("name", CHAINS)
def test_the_factor_is_that_of_the_integral(name: str, dt: float) -> None:
    """Q scaled by diag(Δt^2.5, Δt^1.5, Δt^.5), relative to its largest entry per row and column."""
    chain = CHAINS[name]
    _, G = of_step(chain, dt)
    D = np.array([dt**2, dt, 1.0])
    Q = (G @ G.T) / np.outer(D, D)
    expected = integral(chain, dt)
    size = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    np.testing.assert_allclose(Q / size, expected / size, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(np.triu(G, 1), 0)


@pytest.mark.parametrize("name", CHAINS)
def test_no_time_changes_nothing(name: str) -> None:
    F, G = of_step(CHAINS[name], 0.0)
    np.testing.assert_array_equal(F, np.eye(3))
    np.testing.assert_array_equal(G, np.zeros((3, 3)))


@pytest.mark.cover
@pytest.mark.parametrize("dt", [0.01, 0.3, 1.0])
@pytest.mark.parametrize("part", [0.001, 0.3, 0.9])
@pytest.mark.parametrize("name", CHAINS)
def test_a_step_may_be_split(name: str, part: float, dt: float) -> None:
    chain = CHAINS[name]
    (F, G), (F1, G1), (F2, G2) = (of_step(chain, t) for t in (dt, part * dt, (1 - part) * dt))
    D = np.array([dt**2, dt, 1.0])
    scale = D[None, :] / D[:, None]
    np.testing.assert_allclose((F2 @ F1) * scale, F * scale, rtol=0, atol=1e-12)
    Q, split = G @ G.T, F2 @ G1 @ G1.T @ F2.T + G2 @ G2.T
    size = np.sqrt(np.outer(np.diag(Q), np.diag(Q)))
    np.testing.assert_allclose(split / size, Q / size, rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", [name for name, chain in CHAINS.items() if chain.rate])
def test_what_stays_bounded_is_stationary(name: str) -> None:
    """P = F P Fᵀ + Q for the states that are bounded, in one step of any length."""
    chain = CHAINS[name]
    bounded = np.isfinite(chain.stationary_std)
    F, G = of_step(chain, 400.0 / chain.rate)
    Q = (G @ G.T)[np.ix_(bounded, bounded)]
    found = np.sqrt(np.diag(Q))
    np.testing.assert_allclose(found, np.array(chain.stationary_std)[bounded], rtol=1e-12)
    assert np.abs(F[np.ix_(bounded, bounded)]).max() < 1e-12


@pytest.mark.parametrize("name", [name for name, chain in CHAINS.items() if chain.rate])
def test_simulated_speed_and_correlation(name: str) -> None:
    """A long draw: its speed's deviation and correlation after 1/λ, in standard errors."""
    chain, dt, n = CHAINS[name], 0.25 / CHAINS[name].rate, 40_000
    F, G = of_step(chain, dt)
    noise = np.random.default_rng(5).standard_normal((n, 3)) @ G.T
    x, speeds = np.zeros(3), np.empty(n)
    bounded = np.isfinite(chain.stationary_std)
    for k in range(n):
        x = F @ x + noise[k]
        x[~bounded] = 0.0
        speeds[k] = x[1]
    speeds = speeds[1000:]
    std = chain.stationary_std[1]
    # Autocorrelation in τ = λs: (1 + τ) e^-τ, and (1 + τ - τ²) e^-τ of a Matérn's slope.
    lag, tau = 4, 1.0
    expected = (1 + tau - (tau**2 if np.isfinite(chain.stationary_std[0]) else 0)) * np.exp(-tau)
    standard_error = np.sqrt(8 / len(speeds))  # about eight steps per independent speed
    assert abs(speeds.std() / std - 1) < 4 * standard_error
    found = np.mean(speeds[lag:] * speeds[:-lag]) / std**2
    assert abs(found - expected) < 6 * standard_error
