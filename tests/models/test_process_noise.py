"""White jerk and white acceleration over a step: closed form, factor, steps that are split."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad_vec
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from models.euler_pen import kinematic_states
from models.free_pen import ALPHA, N_FREE, OMEGA, SIGMA, TIP, A, V
from models.motion import white_jerk_motion
from models.pen import pen_model
from models.process_noise import (
    constant_acceleration,
    constant_velocity,
    white_acceleration_factor,
    white_jerk_factor,
)
from models.sensor_kinds.accelerometer import Accelerometer
from models.sensor_kinds.gyroscope import Gyroscope
from models.state_space import StateSpaceModel
from tests.models.pens import ACCELEROMETER, GYROSCOPE, Array, call, matrix, pen, random_state
from tests.references.free_tangent import heading_of

_DT = ca.SX.sym("dt")
FACTOR = ca.Function("factor", [_DT], [white_jerk_factor(_DT)])
TRANSITION = ca.Function("transition", [_DT], [constant_acceleration(_DT)])
VELOCITY_FACTOR = ca.Function("factor", [_DT], [white_acceleration_factor(_DT)])
VELOCITY_TRANSITION = ca.Function("transition", [_DT], [constant_velocity(_DT)])
INTEGRATOR_CHAIN = np.diag([1.0, 1.0], k=1)
STEPS_S = [1e-6, 1e-3, 0.01, 0.5, 3.0]
RELATIVE = 1e-12

TIP_DENSITY, ANGLE_DENSITY = 3.0, 70.0
ACCEL_WALK, GYRO_WALK = 0.02, 0.004

steps = st.floats(1e-5, 10.0)


def covariance(dt: float) -> Array:
    factor = matrix(FACTOR, dt)
    return factor @ factor.T


def printed_covariance(dt: float) -> Array:
    """Q for S = 1 as the equations print it."""
    return np.array(
        [
            [dt**5 / 20, dt**4 / 8, dt**3 / 6],
            [dt**4 / 8, dt**3 / 3, dt**2 / 2],
            [dt**3 / 6, dt**2 / 2, dt],
        ]
    )


def van_loan(dt: float, length: int = 3) -> tuple[Array, Array]:
    """Return A and Q of a chain of integrators from one matrix exponential.

    Van Loan (1978), Computing integrals involving the matrix exponential.
    """
    chain, noise = np.eye(length, k=1), np.zeros((length, length))
    noise[-1, -1] = 1.0
    block = np.block([[-chain, noise], [np.zeros((length, length)), chain.T]])
    exponential = expm(block * dt)
    transition = exponential[length:, length:].T
    return transition, transition @ exponential[:length, length:]


@pytest.mark.parametrize("dt", STEPS_S)
def test_factor_is_a_factor_of_the_printed_covariance(dt: float) -> None:
    assert covariance(dt) == pytest.approx(printed_covariance(dt), rel=RELATIVE, abs=0)
    factor = matrix(FACTOR, dt)
    assert np.array_equal(factor, np.tril(factor))
    assert (np.diag(factor) > 0).all()


@pytest.mark.parametrize("dt", [1e-3, 0.01, 0.5, 3.0])
def test_van_loan(dt: float) -> None:
    transition, noise = van_loan(dt)
    assert matrix(TRANSITION, dt) == pytest.approx(transition, rel=RELATIVE, abs=0)
    assert covariance(dt) == pytest.approx(noise, rel=1e-10, abs=0)


@pytest.mark.parametrize("dt", STEPS_S)
def test_quadrature(dt: float) -> None:
    """Q = ∫ A(s) b bᵀ A(s)ᵀ ds over the step, jerk entering the acceleration."""

    def integrand(s: float) -> Array:
        jerk_response = expm(INTEGRATOR_CHAIN * s)[:, 2]
        return np.outer(jerk_response, jerk_response)

    integral, _ = quad_vec(integrand, 0.0, dt, epsabs=0.0, epsrel=1e-12)
    assert covariance(dt) == pytest.approx(integral, rel=1e-10, abs=0)


@pytest.mark.parametrize("dt", STEPS_S)
def test_white_acceleration_is_a_factor_of_the_printed_covariance(dt: float) -> None:
    factor = matrix(VELOCITY_FACTOR, dt)
    printed = np.array([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]])
    assert factor @ factor.T == pytest.approx(printed, rel=RELATIVE, abs=0)
    assert np.array_equal(factor, np.tril(factor))
    assert (np.diag(factor) > 0).all()


@pytest.mark.parametrize("dt", [1e-3, 0.01, 0.5, 3.0])
def test_white_acceleration_van_loan(dt: float) -> None:
    transition, noise = van_loan(dt, length=2)
    factor = matrix(VELOCITY_FACTOR, dt)
    assert matrix(VELOCITY_TRANSITION, dt) == pytest.approx(transition, rel=RELATIVE, abs=0)
    assert factor @ factor.T == pytest.approx(noise, rel=1e-10, abs=0)


@given(steps, steps)
def test_a_step_of_white_acceleration_may_be_split(first: float, second: float) -> None:
    def noise(dt: float) -> Array:
        factor = matrix(VELOCITY_FACTOR, dt)
        return factor @ factor.T

    A, whole = matrix(VELOCITY_TRANSITION, second), first + second
    split = A @ noise(first) @ A.T + noise(second)
    assert split == pytest.approx(noise(whole), rel=RELATIVE, abs=0)
    transition = A @ matrix(VELOCITY_TRANSITION, first)
    assert transition == pytest.approx(matrix(VELOCITY_TRANSITION, whole), rel=RELATIVE, abs=0)


@pytest.mark.parametrize("dt", STEPS_S)
def test_white_acceleration_is_white_jerk_of_the_rates(dt: float) -> None:
    """Velocity and acceleration under white jerk are position and velocity one link up."""
    factor, jerk = matrix(VELOCITY_FACTOR, dt), covariance(dt)
    assert factor @ factor.T == pytest.approx(jerk[1:, 1:], rel=RELATIVE, abs=0)
    assert np.array_equal(matrix(VELOCITY_TRANSITION, dt), matrix(TRANSITION, dt)[1:, 1:])


@given(steps, steps)
def test_a_step_may_be_split(first: float, second: float) -> None:
    """Q(a+b) = A(b) Q(a) A(b)ᵀ + Q(b), and A(a+b) = A(b) A(a)."""
    A = matrix(TRANSITION, second)
    whole = first + second
    split = A @ covariance(first) @ A.T + covariance(second)
    assert split == pytest.approx(covariance(whole), rel=RELATIVE, abs=0)
    transition = A @ matrix(TRANSITION, first)
    assert transition == pytest.approx(matrix(TRANSITION, whole), rel=RELATIVE, abs=0)


def noisy_model(degrees_of_freedom: int) -> StateSpaceModel:
    """Return a pen with biases that walk, on some axes."""
    sensors = {
        "gyro": Gyroscope(
            **GYROSCOPE,
            axes=("y", "x"),
            bias_std_rad_s=0.1,
            bias_walk_rad_s_per_sqrt_s=GYRO_WALK,
        ),
        "accel": Accelerometer(
            **ACCELEROMETER, bias_std_m_s2=0.3, bias_walk_m_s2_per_sqrt_s=ACCEL_WALK
        ),
    }
    motion = white_jerk_motion(TIP_DENSITY, ANGLE_DENSITY)
    return pen_model(pen(degrees_of_freedom, sensors, motion=motion))


def linear_parts(model: StateSpaceModel, dt: float) -> tuple[Array, Array]:
    """Return A and Q of the whole state, column by column from f."""
    no_state, no_noise = np.zeros(model.n_x), np.zeros(model.n_w)
    A = np.column_stack([call(model.f, unit, no_noise, dt) for unit in np.eye(model.n_x)])
    G = np.column_stack([call(model.f, no_state, unit, dt) for unit in np.eye(model.n_w)])
    return A, G @ G.T


@pytest.mark.parametrize("dt", [1e-3, 0.01, 0.5])
def test_whole_state(dt: float) -> None:
    """Every degree of freedom alike and apart, biases as random walks."""
    model, n_q = noisy_model(5), 5
    A, Q = linear_parts(model, dt)
    transition, noise = van_loan(dt)
    n_x = 3 * n_q + 5
    expected_A, expected_Q = np.eye(n_x), np.zeros((n_x, n_x))
    for axis in range(n_q):
        density = TIP_DENSITY if axis < 3 else ANGLE_DENSITY
        chain = np.ix_(*[[axis, axis + n_q, axis + 2 * n_q]] * 2)
        expected_A[chain], expected_Q[chain] = transition, density**2 * noise
    walks = [GYRO_WALK] * 2 + [ACCEL_WALK] * 3
    expected_Q[3 * n_q :, 3 * n_q :] = np.diag(np.array(walks) ** 2 * dt)
    assert pytest.approx(expected_A, rel=RELATIVE, abs=0) == A
    assert pytest.approx(expected_Q, rel=1e-10, abs=0) == Q


def test_whole_state_over_a_split_step() -> None:
    model = noisy_model(5)
    A_1, Q_1 = linear_parts(model, 0.004)
    A_2, Q_2 = linear_parts(model, 0.013)
    A, Q = linear_parts(model, 0.017)
    assert pytest.approx(A, rel=RELATIVE, abs=0) == A_2 @ A_1
    assert pytest.approx(Q, rel=RELATIVE, abs=0) == A_2 @ Q_1 @ A_2.T + Q_2


FREE = np.delete(np.arange(N_FREE + 5), range(SIGMA.start, SIGMA.stop))
"""All but the attitude: what moves linearly."""


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("dt", [1e-3, 0.01, 0.5])
def test_whole_state_of_the_free_pen(dt: float, seed: int) -> None:
    """Tip, rates and biases by the matrix exponential; the attitude by SciPy's turn.

    Unit noises, together, have the covariance of a matrix exponential; the turn within the step
    is the first row of the attitude's chain, and its noise is correlated with that of the rates.
    """
    model, rng = noisy_model(6), np.random.default_rng(seed)
    x, w = random_state(rng, 6, n_biases=5), rng.standard_normal(model.n_w)
    transition, noise = van_loan(dt)
    L = np.linalg.cholesky(noise)
    expected, with_heading = x.copy(), w.copy()
    N = heading_of(Rotation.from_mrp(x[SIGMA]))
    for part in (TIP, V, A):
        with_heading[part] = N.apply(w[part])
    for axis in range(3):
        tip = [TIP.start + axis, V.start + axis, A.start + axis]
        turning = [SIGMA.start + axis, OMEGA.start + axis, ALPHA.start + axis]
        expected[tip] = transition @ x[tip] + TIP_DENSITY * L @ with_heading[tip]
        turn_of = [0.0, *x[turning[1:]]]
        expected[turning] = transition @ turn_of + ANGLE_DENSITY * L @ w[turning]
    turn = Rotation.from_rotvec(expected[SIGMA])
    walks = np.array([GYRO_WALK] * 2 + [ACCEL_WALK] * 3)
    expected[N_FREE:] = x[N_FREE:] + walks * np.sqrt(dt) * w[N_FREE:]
    found = call(model.f, x, w, dt)
    assert found[FREE] == pytest.approx(expected[FREE], rel=1e-9, abs=1e-12)
    R = Rotation.from_mrp(x[SIGMA]) * turn
    assert (R.inv() * Rotation.from_mrp(found[SIGMA])).magnitude() < 1e-9


@pytest.mark.parametrize("dt", [1e-3, 0.01, 0.5])
def test_small_noise_of_the_free_pen(dt: float) -> None:
    """Of a pen at rest, in its tangent space: the covariance of three chains per vector."""
    model = noisy_model(6)
    rest = np.zeros(model.n_x)
    w = ca.SX.sym("w", model.n_w)
    away = model.difference(model.f(rest, w, dt), model.f(rest, np.zeros(model.n_w), dt))
    G = ca.Function("G", [w], [ca.jacobian(away, w)])(np.zeros(model.n_w)).full()
    _, noise = van_loan(dt)
    expected = np.zeros((model.n_x, model.n_x))
    for parts, density in (((TIP, V, A), TIP_DENSITY), ((SIGMA, OMEGA, ALPHA), ANGLE_DENSITY)):
        for axis in range(3):
            rows = [part.start + axis for part in parts]
            expected[np.ix_(rows, rows)] = density**2 * noise
    walks = np.array([GYRO_WALK] * 2 + [ACCEL_WALK] * 3)
    expected[N_FREE:, N_FREE:] = np.diag(walks**2 * dt)
    assert pytest.approx(expected, rel=1e-10, abs=0) == G @ G.T


def test_the_free_pen_over_a_split_step() -> None:
    """Without noise: what moves linearly exactly; turns about a fixed axis too."""
    model, rng = noisy_model(6), np.random.default_rng(4)
    x, still = random_state(rng, 6, n_biases=5), np.zeros(model.n_w)
    x[ALPHA] = -3.0 * x[OMEGA]
    halfway = call(model.f, x, still, 0.004)
    split, whole = call(model.f, halfway, still, 0.013), call(model.f, x, still, 0.017)
    assert split[FREE] == pytest.approx(whole[FREE], rel=RELATIVE, abs=0)
    apart = Rotation.from_mrp(split[SIGMA]).inv() * Rotation.from_mrp(whole[SIGMA])
    assert apart.magnitude() < 1e-14


@pytest.mark.parametrize("degrees_of_freedom", [5, 6])
def test_no_time_changes_nothing(degrees_of_freedom: int) -> None:
    assert np.array_equal(matrix(FACTOR, 0.0), np.zeros((3, 3)))
    assert np.array_equal(matrix(TRANSITION, 0.0), np.eye(3))
    assert np.array_equal(matrix(VELOCITY_FACTOR, 0.0), np.zeros((2, 2)))
    assert np.array_equal(matrix(VELOCITY_TRANSITION, 0.0), np.eye(2))
    model, rng = noisy_model(degrees_of_freedom), np.random.default_rng(1)
    x = random_state(rng, degrees_of_freedom, n_biases=5)
    moved = call(model.f, x, rng.standard_normal(model.n_w), 0.0)
    if degrees_of_freedom == 5:
        assert np.array_equal(moved, x)
    else:
        assert np.array_equal(moved[FREE], x[FREE])
        assert moved[SIGMA] == pytest.approx(x[SIGMA], abs=1e-16)


@pytest.mark.parametrize("degrees_of_freedom", [5, 6])
def test_names_follow_the_blocks(degrees_of_freedom: int) -> None:
    """State i + n is the velocity of state i, and i + 2n its acceleration."""
    names = [name for name, _ in kinematic_states(degrees_of_freedom)]
    units = [unit for _, unit in kinematic_states(degrees_of_freedom)]
    for i in range(degrees_of_freedom):
        position, velocity, acceleration = names[i::degrees_of_freedom]
        stem, unit = position.rsplit("_", 1)
        assert velocity.startswith(stem)
        assert velocity.endswith(f"_{unit}_s")
        assert acceleration == f"{stem}_acceleration_{unit}_s2"
        assert units[i::degrees_of_freedom] == [unit, f"{unit}/s", f"{unit}/s²"]
