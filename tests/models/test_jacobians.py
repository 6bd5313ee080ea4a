"""Every Jacobian that an estimator may take, against five-point central differences."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import casadi as ca
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from models.free_pen import ALPHA, OMEGA, SIGMA, TIP, A, V
from models.motion import Motion, TipBoundedVelocity, white_jerk_motion
from models.pen import pen_model
from models.state_space import StateSpaceModel
from tests.models.pens import Array, call, every_sensor, pen, random_state
from tests.references.free_states import still_state
from tests.references.free_tangent import tangent_of, turn_of
from tests.references.trajectory import first_difference

RELATIVE = 1e-6
OF_LARGEST = 1e-9
"""Beside it: of the largest entry."""
STEP = 1e-3
SENSORS = ("accel", "gyro", "camera", "contact", "area")
N_BIASES = 5
SEEDS = range(16)
"""Enough for angles beyond half a turn and attitudes beyond the shadow."""
CORRELATION_TIME_S = 0.15
STEPS_S = (0.0, 1e-4, 0.01, 0.2)


@cache
def model_of(degrees_of_freedom: int) -> StateSpaceModel:
    sensors = every_sensor(np.random.default_rng(degrees_of_freedom))
    if degrees_of_freedom == 5:
        return pen_model(pen(5, sensors, motion=white_jerk_motion(100.0, 1000.0)))
    tip = TipBoundedVelocity(speed_m_s=0.3, correlation_time_s=CORRELATION_TIME_S)
    return pen_model(pen(6, sensors, motion=Motion(tip=tip)))


def difference_jacobian(function: Callable[[Array], Array], at: Array, step: float) -> Array:
    """Return the Jacobian by five-point differences, column by column."""

    def along(unit: Array) -> Array:
        return first_difference(lambda length: function(at + length * unit), 0.0, step)

    return np.column_stack([along(unit) for unit in np.eye(len(at))])


def assert_jacobian(
    function: ca.Function,
    which: int,
    arguments: list[Array],
    step: float = STEP,
    fifth_derivative: float = 32.0,
) -> None:
    """Compare ∂function/∂arguments[which], entry by entry.

    An entry may be off by the tolerance, or by what the differences themselves
    cannot resolve: rounding of values of the row's size over the step, and a
    truncation of step⁴/30 times the fifth derivative, relative to that size
    (2⁵ for products of two sines).
    """

    def moved(value: Array) -> Array:
        return call(function, *(value if k == which else a for k, a in enumerate(arguments)))

    symbols = [ca.SX.sym(f"a{k}", len(a)) for k, a in enumerate(arguments)]
    jacobian = ca.Function("J", symbols, [ca.jacobian(function(*symbols), symbols[which])])
    exact = np.asarray(jacobian(*arguments).full())
    numeric = difference_jacobian(moved, arguments[which], step)
    assert exact.shape == numeric.shape
    row_size = 1 + np.abs(moved(arguments[which]))[:, None] + np.abs(exact).max(axis=1)[:, None]
    unresolved = row_size * (4 * np.finfo(float).eps / step + fifth_derivative * step**4 / 30)
    excess = np.abs(exact - numeric) - RELATIVE * np.abs(exact) - unresolved
    assert excess.max() < 0, np.unravel_index(excess.argmax(), excess.shape)
    assert np.abs(exact - numeric).max() <= OF_LARGEST * np.abs(exact).max()


@pytest.mark.parametrize("degrees_of_freedom", [5, 6])
@pytest.mark.parametrize("dt", STEPS_S)
@pytest.mark.parametrize("which", [0, 1], ids=["x", "w"])
def test_transition(degrees_of_freedom: int, dt: float, which: int) -> None:
    """With five degrees of freedom f is linear: any step is exact, and a long one rounds least."""
    model = model_of(degrees_of_freedom)
    rng = np.random.default_rng(11)
    x = random_state(rng, degrees_of_freedom, N_BIASES)
    arguments = [x, rng.standard_normal(model.n_w), np.array([dt])]
    if degrees_of_freedom == 5:
        assert_jacobian(model.f, which, arguments, step=1.0, fifth_derivative=0.0)
    else:
        assert_jacobian(model.f, which, arguments)


def test_transition_by_its_step() -> None:
    """∂f/∂Δt without noise is the rate of the state at the end of the step."""
    model, n, dt = model_of(5), 5, 0.05
    x = random_state(np.random.default_rng(12), n, N_BIASES)
    still, later = np.zeros(model.n_w), np.array([dt])
    moved = difference_jacobian(lambda step: call(model.f, x, still, step), later, STEP)
    velocity, acceleration = x[n : 2 * n], x[2 * n : 3 * n]
    rate = np.concatenate([velocity + acceleration * dt, acceleration, np.zeros(n + N_BIASES)])
    assert moved.ravel() == pytest.approx(rate, rel=1e-10, abs=1e-10)


def test_transition_of_the_free_pen_by_its_step() -> None:
    """The same: vectors by the chains' differential equations, the attitude by SciPy's turns."""
    model, dt = model_of(6), 0.05
    x = random_state(np.random.default_rng(12), 6, N_BIASES)
    still, later = np.zeros(model.n_w), np.array([dt])
    moved = difference_jacobian(lambda step: call(model.f, x, still, step), later, 4e-4).ravel()
    end, forgets = call(model.f, x, still, later), 1 / CORRELATION_TIME_S

    def turned(time: float) -> Array:
        turn = Rotation.from_rotvec(time * x[OMEGA] + time**2 / 2 * x[ALPHA])
        return np.asarray((Rotation.from_mrp(x[SIGMA]) * turn).as_mrp())

    rate = np.zeros(model.n_x)
    rate[TIP], rate[V], rate[OMEGA] = end[V], end[A], end[ALPHA]
    rate[A] = -(forgets**2) * end[V] - 2 * forgets * end[A]
    rate[SIGMA] = first_difference(turned, dt, 4e-4)
    assert moved == pytest.approx(rate, rel=1e-10, abs=1e-9)


@pytest.mark.parametrize("degrees_of_freedom", [5, 6])
@pytest.mark.parametrize("name", SENSORS)
@pytest.mark.parametrize("seed", range(4))
def test_readings(degrees_of_freedom: int, name: str, seed: int) -> None:
    x = random_state(np.random.default_rng(seed), degrees_of_freedom, N_BIASES)
    assert_jacobian(model_of(degrees_of_freedom).sensor(name).h, 0, [x])


@pytest.mark.cover
@pytest.mark.parametrize("degrees_of_freedom", [5, 6])
@pytest.mark.parametrize("name", SENSORS)
@pytest.mark.parametrize("which", [0, 1], ids=["y", "x"])
@pytest.mark.parametrize("seed", range(4))
def test_residuals(degrees_of_freedom: int, name: str, which: int, seed: int) -> None:
    """Seen from another state, and with a residual of exactly zero.

    At zero the residual of the camera is at the limit of its formula, and that
    is where an estimator works.
    """
    sensor = model_of(degrees_of_freedom).sensor(name)
    rng = np.random.default_rng(seed)
    x = random_state(rng, degrees_of_freedom, N_BIASES)
    away = x + rng.uniform(-0.3, 0.3, len(x))
    for seen in (away, x):
        y = call(sensor.h, seen)
        assert_jacobian(sensor.residual, which, [y, x])


@pytest.mark.parametrize("degrees_of_freedom", [5, 6])
def test_residual_at_zero_is_minus_the_reading(degrees_of_freedom: int) -> None:
    """For a plain difference ∂residual/∂x = -∂h/∂x and ∂residual/∂y = I."""
    model = model_of(degrees_of_freedom)
    x = ca.SX.sym("x", model.n_x)
    state = random_state(np.random.default_rng(3), degrees_of_freedom, N_BIASES)
    for name in ("accel", "gyro", "contact", "area"):
        sensor = model.sensor(name)
        y = ca.SX.sym("y", sensor.n_y)
        residual = sensor.residual(y, x)
        slopes = ca.Function("slopes", [y, x], [ca.jacobian(residual, s) for s in (y, x)])
        by_y, by_x = (slope.full() for slope in slopes(call(sensor.h, state), state))
        of_h = ca.Function("H", [x], [ca.jacobian(sensor.h(x), x)])(state).full()
        assert by_y == pytest.approx(np.eye(sensor.n_y), abs=0)
        assert by_x == pytest.approx(-of_h, abs=0)


@pytest.mark.parametrize("which", [0, 1])
@pytest.mark.parametrize("seed", SEEDS)
def test_retract_and_difference(which: int, seed: int) -> None:
    """Also where the sum has left (-π, π]; only the jump itself has no derivative."""
    model, angles = model_of(5), slice(3, 5)
    rng = np.random.default_rng(seed)
    x, other = (random_state(rng, 5, N_BIASES) for _ in range(2))
    for function, plain in ((model.retract, x + other), (model.difference, x - other)):
        wrapped = call(function, x, other)
        assert np.abs(np.abs(wrapped[angles]) - np.pi).min() > 4 * STEP
        assert_jacobian(function, which, [x, other])
        turns = (plain - wrapped)[angles] / (2 * np.pi)
        assert turns == pytest.approx(np.round(turns), abs=1e-12)


def test_some_of_those_angles_were_wrapped() -> None:
    model = model_of(5)
    wrapped = 0
    for seed in SEEDS:
        rng = np.random.default_rng(seed)
        x, other = (random_state(rng, 5, N_BIASES) for _ in range(2))
        wrapped += int((np.abs((x + other) - call(model.retract, x, other)) > 1).sum())
    assert wrapped >= 3


def swing_of(x: Array, other: Array) -> float:
    """Angle of the swing from one free pen's attitude to another's, rad."""
    turn = Rotation.from_mrp(x[SIGMA]) * Rotation.from_mrp(other[SIGMA]).inv()
    *_, z, w = turn.as_quat()
    is_near_a_turn = abs(w) < 0.1 * abs(z)  # of the twist, which wraps
    return np.pi if is_near_a_turn else float(2 * np.arccos(np.hypot(z, w)))


@pytest.mark.parametrize("which", [0, 1])
@pytest.mark.parametrize("seed", SEEDS)
def test_retract_and_difference_of_the_free_pen(which: int, seed: int) -> None:
    """Values by SciPy's rotations, on either side of the shadow; the jump has no derivative.

    Nor has a swing of half a turn, from the other or from upright: near it a five-point difference
    says little.
    """
    model, rng = model_of(6), np.random.default_rng(seed)
    drawn = (random_state(rng, 6, N_BIASES) for _ in range(40))
    plain = (one for one in drawn if swing_of(one, np.zeros(len(one))) < np.radians(120))
    x = next(plain)
    other = next(one for one in plain if swing_of(x, one) < np.radians(150))
    delta = rng.normal(size=model.n_x)
    R, R_other = (Rotation.from_mrp(state[SIGMA]) for state in (x, other))

    moved, turn = x + delta, turn_of(R, delta[SIGMA])
    moved[SIGMA] = (turn * R).as_mrp()
    away, turned = x - other, R * R_other.inv()
    away[SIGMA] = tangent_of(R_other, turned)
    for vector in (V, A):
        moved[vector] = turn.apply(x[vector]) + delta[vector]
        away[vector] = x[vector] - turned.apply(other[vector])
    for function, second, expected, length in (
        (model.retract, delta, moved, 1.0),
        (model.difference, other, away, 4.0),
    ):
        found = call(function, x, second)
        assert found == pytest.approx(expected, rel=1e-13, abs=1e-13)
        assert abs(np.linalg.norm(found[SIGMA]) / length - 1) > 4 * STEP
        assert_jacobian(function, which, [x, second])


def test_some_of_those_attitudes_were_shadows() -> None:
    """SciPy's product of quaternions with w ≥ 0 had w < 0."""
    shadows = 0
    for seed in SEEDS:
        rng = np.random.default_rng(seed)
        x, other = (random_state(rng, 6, N_BIASES) for _ in range(2))
        (*xyz, w), (*xyz_2, w_2) = (
            Rotation.from_mrp(state[SIGMA]).as_quat(canonical=True) for state in (x, other)
        )
        shadows += int(w * w_2 + np.dot(xyz, xyz_2) < 0)
    assert shadows >= 2


@pytest.mark.parametrize("degrees_of_freedom", [5, 6])
def test_regularity(degrees_of_freedom: int) -> None:
    """The margin is cosθ: zero for an upright pen."""
    model = model_of(degrees_of_freedom)
    x = random_state(np.random.default_rng(5), degrees_of_freedom, N_BIASES)
    assert_jacobian(model.regularity, 0, [x])
    is_free = degrees_of_freedom == 6
    cosine = (
        np.linalg.norm(Rotation.from_mrp(x[SIGMA]).apply([0, 0, 1])[:2])
        if is_free
        else np.cos(x[4])
    )
    assert call(model.regularity, x) == pytest.approx(cosine, abs=1e-15)
    if is_free:
        x[SIGMA] = still_state(np.pi / 2, azimuth=0.4, spin=1.1)[SIGMA]
    else:
        x[4] = np.pi / 2
    assert call(model.regularity, x) == pytest.approx(0, abs=1e-15)


@pytest.mark.parametrize("seed", SEEDS)
def test_what_people_read(seed: int) -> None:
    """Outputs of the free pen by its state: their deviations come from this Jacobian."""
    model = model_of(6)
    x = random_state(np.random.default_rng(seed), 6, N_BIASES)
    assert model.outputs is not None
    assert_jacobian(model.outputs.function, 0, [x], step=3e-4)  # angles bend near upright
