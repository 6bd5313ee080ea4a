"""The free pen: what its sensors read, its manifold, and its motion."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from models import free_pen
from models.arrays import Array
from models.chains import bounded_velocity, white_jerk
from models.free_pen import ALPHA, N_FREE, OMEGA, SIGMA, TIP, A, FreeBody, V
from tests.references.rodrigues_rate import rate

RNG = np.random.default_rng(16)
STATES = [*RNG.normal(size=(8, N_FREE)), np.zeros(N_FREE)]
for state in STATES:
    state[SIGMA] = Rotation.from_rotvec(state[SIGMA]).as_mrp()
TIP_CHAIN, TURN_CHAIN = bounded_velocity(0.08, 0.1), white_jerk(40.0)
GRAVITY = 9.81

x, d, w, dt = (ca.SX.sym(name, n) for name, n in (("x", 18), ("d", 18), ("w", 18), ("dt", 1)))
other = ca.SX.sym("other", N_FREE)
RETRACT = ca.Function("retract", [x, d], [free_pen.retract(x, d)])
DIFFERENCE = ca.Function("difference", [x, other], [free_pen.difference(x, other)])
STEP = ca.Function("step", [x, w, dt], [free_pen.step(x, w, dt, TIP_CHAIN, TURN_CHAIN)])


def value(expression: ca.SX, state: Array) -> Array:
    return np.array(ca.Function("value", [x], [ca.densify(expression)])(state).full())


def along(state: Array, t: float) -> Array:
    """The state after t seconds of constant a and α, by SciPy's rotations: fourth order in t."""
    moved = state.copy()
    moved[TIP] = state[TIP] + t * state[V] + t**2 / 2 * state[A]
    moved[V], moved[OMEGA] = state[V] + t * state[A], state[OMEGA] + t * state[ALPHA]
    # Magnus: the rotation vector of a rate ω + s α, to fourth order.
    turn = t * state[OMEGA] + t**2 / 2 * state[ALPHA]
    turn = turn + t**3 / 12 * np.cross(state[OMEGA], state[ALPHA])
    R = Rotation.from_mrp(state[SIGMA]) * Rotation.from_rotvec(turn)
    moved[SIGMA] = R.as_mrp()
    return moved


@pytest.mark.parametrize("state", STATES)
@pytest.mark.parametrize("mounting", [(0.0, 0.0, 0.0), (0.01, -0.02, 0.15)])
def test_specific_force_is_the_second_derivative_of_the_place(
    state: Array, mounting: tuple[float, ...]
) -> None:
    """By a five-point difference of the sensor's place; to 1e-7 of the largest entry."""
    body, h, lever = FreeBody(x), 1e-3, np.array(mounting)

    def place(t: float) -> Array:
        moved = along(state, t)
        return moved[TIP] + Rotation.from_mrp(moved[SIGMA]).apply(lever)

    points = np.array([place(k * h) for k in (-2, -1, 0, 1, 2)])
    acceleration = np.array([-1, 16, -30, 16, -1]) @ points / (12 * h**2)
    R = Rotation.from_mrp(state[SIGMA])
    expected = R.inv().apply(acceleration + np.array([0.0, 0.0, GRAVITY]))
    found = value(body.specific_force(ca.SX(ca.DM(lever)), GRAVITY), state).ravel()
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-7 * np.abs(expected).max())


@pytest.mark.parametrize("state", STATES)
def test_specific_force_is_what_the_derivation_along_the_state_gives(state: Array) -> None:
    """d/dt = Σ ∂/∂c · ċ with c = (p, σ, v, ω), as for every other body."""
    body, mounting = FreeBody(x), ca.SX([0.01, -0.02, 0.15])
    c = ca.vertcat(x[TIP], x[SIGMA], x[V], x[OMEGA])
    c_dot = ca.vertcat(x[V], rate(x[SIGMA], x[OMEGA]), x[A], x[ALPHA])

    def derivative(expression: ca.SX) -> ca.SX:
        return ca.jtimes(expression, c, c_dot)

    derived = body.world_to_body @ (
        derivative(derivative(body.point(mounting))) + ca.vertcat(0, 0, GRAVITY)
    )
    expected = value(derived, state)
    found = value(body.specific_force(mounting, GRAVITY), state)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("state", STATES)
def test_difference_undoes_retract(state: Array) -> None:
    for tangent in RNG.normal(size=(5, N_FREE)):
        back = DIFFERENCE(RETRACT(state, tangent), state).full().ravel()
        np.testing.assert_allclose(back, tangent, rtol=0, atol=1e-13)
    for target in STATES:
        there = RETRACT(state, DIFFERENCE(target, state)).full().ravel()
        aside = DIFFERENCE(there, target).full().ravel()
        np.testing.assert_allclose(aside, 0, rtol=0, atol=1e-12)


@pytest.mark.parametrize("state", STATES)
def test_a_gyroscope_says_nothing_of_the_attitude(state: Array) -> None:
    """Its rows of H have no attitude column; an accelerometer's have none of the tip's a."""
    body = FreeBody(free_pen.retract(x, d))
    at_zero = ca.Function(
        "H",
        [x],
        [
            ca.substitute(ca.jacobian(h, d), d, 0)
            for h in (body.body_rate(), body.world_to_body @ body.x[A])
        ],
    )
    of_gyro, of_acceleration = (H.full() for H in at_zero(state))
    np.testing.assert_array_equal(of_gyro[:, SIGMA], 0)
    np.testing.assert_allclose(of_acceleration[:, SIGMA], 0, rtol=0, atol=1e-13)


@pytest.mark.parametrize("state", STATES)
def test_without_noise_the_pen_turns_as_rates_say(state: Array) -> None:
    """Splitting a step halves the error of the turn by four: order 2, as R Exp(∫ω) is."""
    no_noise, t = np.zeros(N_FREE), 0.02

    def error(n: int) -> float:
        moved = state
        for _ in range(n):
            moved = STEP(moved, no_noise, t / n).full().ravel()
        exact = Rotation.from_mrp(fine[SIGMA])
        return float((exact.inv() * Rotation.from_mrp(moved[SIGMA])).magnitude())

    fine = state
    for _ in range(256):
        fine = STEP(fine, no_noise, t / 256).full().ravel()
    if not state.any():
        assert error(1) == 0
        return
    assert error(2) < error(1) / 3.5


@pytest.mark.parametrize("state", STATES)
def test_no_time_changes_nothing(state: Array) -> None:
    found = STEP(state, RNG.normal(size=N_FREE), 0.0).full().ravel()
    np.testing.assert_allclose(found, state, rtol=0, atol=1e-15)
