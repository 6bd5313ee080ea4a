"""The turntable: equations (10)-(12), the mountings of E6, constant rates."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from models.state_space import StateSpaceModel
from models.turntable import (
    TurntableConfig,
    paper_turntable,
    turntable_model,
    world_to_table,
)
from tests.models.pens import Array, call, matrix
from tests.models.test_jacobians import assert_jacobian
from tests.models.test_process_noise import linear_parts, van_loan

EXACT = 1e-12
G = 9.81
SEEDS = range(5)
CONFIGURATIONS = [("accel",), ("gyro",), ("accel", "gyro")]
AGAINST = ((1, 0, 0), (0, -1, 0), (0, 0, -1))
"""Half a turn about x: the second axis points the other way."""

_PHI, _THETA = ca.SX.sym("phi"), ca.SX.sym("theta")
ROTATION = ca.Function("B", [_PHI, _THETA], [world_to_table(_PHI, _THETA)])


def random_state(seed: int) -> Array:
    rng = np.random.default_rng(seed)
    return np.concatenate([rng.uniform(-np.pi, np.pi, 2), rng.normal(0, 3.0, 2)])


def equation_10(x: Array) -> Array:
    phi, theta = x[:2]
    return G * np.array(
        [np.sin(phi), np.cos(phi) * np.sin(theta), np.cos(phi) * np.cos(theta)],
    )


def equation_11(x: Array) -> Array:
    _, theta, phi_rate, theta_rate = x
    return np.array([theta_rate, phi_rate * np.cos(theta)])


def with_sensor(name: str, **changes: Any) -> TurntableConfig:
    """Return the paper's table with one sensor changed."""
    table = paper_turntable()
    sensor = table.sensors[name].model_copy(update=changes)
    return table.model_copy(update={"sensors": {**table.sensors, name: sensor}})


def readings(model: StateSpaceModel, x: Array) -> Array:
    """Return what all sensors of a model read, stacked."""
    return np.concatenate([call(sensor.h, x) for sensor in model.sensors])


@pytest.mark.parametrize("seed", SEEDS)
def test_rotation(seed: int) -> None:
    """R_x(θ) R_y(-φ) as changes of coordinates, which are transposes of rotations."""
    phi, theta = random_state(seed)[:2]
    about_y = Rotation.from_rotvec([0, -phi, 0]).as_matrix().T
    about_x = Rotation.from_rotvec([theta, 0, 0]).as_matrix().T
    assert matrix(ROTATION, phi, theta) == pytest.approx(about_x @ about_y, abs=EXACT)


@pytest.mark.parametrize("sensors", CONFIGURATIONS, ids="+".join)
@pytest.mark.parametrize("seed", SEEDS)
def test_observation_models(sensors: tuple[str, ...], seed: int) -> None:
    """(10), (11) and (12), typed here a second time."""
    x = random_state(seed)
    printed = {"accel": equation_10(x), "gyro": equation_11(x)}
    expected = np.concatenate([printed[name] for name in sensors])
    model = turntable_model(paper_turntable(), sensors)
    assert readings(model, x) == pytest.approx(expected, rel=EXACT, abs=EXACT)


@pytest.mark.parametrize("seed", SEEDS)
def test_mountings_of_the_gyroscope(seed: int) -> None:
    """E6: on the accelerometer's axes the second rate is -φ̇ cosθ, the other way +φ̇ cosθ."""
    x = random_state(seed)
    _, theta, phi_rate, theta_rate = x
    identity = np.eye(3).tolist()
    aligned = turntable_model(
        with_sensor("gyro", sensor_to_body=identity, axes=("x", "y", "z")), ["gyro"]
    )
    against = turntable_model(
        with_sensor("gyro", sensor_to_body=AGAINST, axes=("x", "y", "z")), ["gyro"]
    )
    rate = np.array([theta_rate, -phi_rate * np.cos(theta), phi_rate * np.sin(theta)])
    assert readings(aligned, x) == pytest.approx(rate, rel=EXACT, abs=EXACT)
    assert readings(against, x) == pytest.approx(rate * [1, -1, -1], rel=EXACT, abs=EXACT)


@pytest.mark.parametrize("seed", SEEDS)
def test_mountings_of_the_accelerometer(seed: int) -> None:
    """E6 the other way round: an accelerometer on the gyroscope's axes loses (10)'s signs."""
    x = random_state(seed)
    table = with_sensor("accel", sensor_to_body=AGAINST)
    force = readings(turntable_model(table, ["accel"]), x)
    assert force == pytest.approx(equation_10(x) * [1, -1, -1], rel=EXACT, abs=EXACT)


@pytest.mark.parametrize("seed", SEEDS)
def test_sensors_off_the_origin(seed: int) -> None:
    """ω × (ω × d), with the rotational acceleration of constant rates neglected.

    What q̈ = 0 leaves of ω̇ is the change of ω with the angles: exact for constant rates.
    """
    x, d = random_state(seed), np.array([0.03, -0.05, 0.07])
    _, theta, phi_rate, theta_rate = x
    sin, cos = np.sin(theta), np.cos(theta)
    rate = np.array([theta_rate, -phi_rate * cos, phi_rate * sin])
    rate_change = phi_rate * theta_rate * np.array([0, sin, cos])
    turning = np.cross(rate_change, d) + np.cross(rate, np.cross(rate, d))
    model = turntable_model(with_sensor("accel", position_m=tuple(d)), ["accel"])
    assert readings(model, x) == pytest.approx(equation_10(x) + turning, rel=EXACT, abs=EXACT)


@pytest.mark.parametrize("phi", [np.pi / 2, -np.pi / 2, 3 * np.pi / 2])
@pytest.mark.parametrize("theta", [-2.0, 0.0, 0.8])
def test_gravity_hides_theta_where_cos_phi_is_zero(phi: float, theta: float) -> None:
    model = turntable_model(paper_turntable())
    x = np.array([phi, theta, 0.5, -0.3])
    slope = model.sensor("accel").h.jacobian()
    column = np.asarray(slope(x, np.zeros(3)).full())[:, 1]
    assert np.abs(column).max() < 1e-14
    assert call(model.regularity, x) == pytest.approx([0], abs=1e-15)
    away = x + np.array([0.4, 0.0, 0.0, 0.0])
    column = np.asarray(slope(away, np.zeros(3)).full())[:, 1]
    assert np.linalg.norm(column) == pytest.approx(G * abs(np.cos(away[0])), rel=EXACT)
    assert call(model.regularity, away) == pytest.approx([np.cos(away[0])], rel=EXACT)


@pytest.mark.parametrize("name", ["accel", "gyro"])
@pytest.mark.parametrize("seed", SEEDS)
def test_jacobians_of_the_sensors(name: str, seed: int) -> None:
    model = turntable_model(with_sensor("accel", position_m=(0.03, -0.05, 0.07)))
    sensor = model.sensor(name)
    assert_jacobian(sensor.h, 0, [random_state(seed)])
    y = np.random.default_rng(seed).normal(0, 5, sensor.n_y)
    assert_jacobian(sensor.residual, 1, [y, random_state(seed)])


@pytest.mark.parametrize("which", [0, 1], ids=["x", "w"])
@pytest.mark.parametrize("dt", [0.0, 0.01, 0.5])
def test_jacobians_of_the_transition(which: int, dt: float) -> None:
    """f is linear, so any step is exact and a long one rounds least."""
    model = turntable_model(paper_turntable())
    arguments = [random_state(1), np.array([0.3, -1.0, 0.7, 2.0]), np.array([dt])]
    assert_jacobian(model.f, which, arguments, step=1.0, fifth_derivative=0.0)


@pytest.mark.parametrize("dt", [1e-3, 0.01, 0.5])
@pytest.mark.parametrize("reached_after_s", [1.0, 0.25])
def test_exact_discretisation(dt: float, reached_after_s: float) -> None:
    """Each axis alike and apart: S = tolerance² / the time in which it is reached."""
    table = paper_turntable().model_copy(update={"tolerance_reached_after_s": reached_after_s})
    A, Q = linear_parts(turntable_model(table), dt)
    transition, noise = van_loan(dt, length=2)
    expected_A, expected_Q = np.eye(4), np.zeros((4, 4))
    for axis, tolerance_deg_s in enumerate((1.0, 0.5)):
        block = np.ix_([axis, axis + 2], [axis, axis + 2])
        expected_A[block] = transition
        expected_Q[block] = np.radians(tolerance_deg_s) ** 2 / reached_after_s * noise
    assert pytest.approx(expected_A, rel=EXACT, abs=0) == A
    assert pytest.approx(expected_Q, rel=1e-10, abs=0) == Q


def test_a_rate_wanders_by_its_tolerance_in_the_given_time() -> None:
    table = paper_turntable().model_copy(update={"tolerance_reached_after_s": 0.3})
    _, Q = linear_parts(turntable_model(table), 0.3)
    assert np.degrees(np.sqrt(np.diag(Q)))[2:] == pytest.approx([1.0, 0.5], rel=EXACT)


def test_a_step_may_be_split() -> None:
    model = turntable_model(paper_turntable())
    A_1, Q_1 = linear_parts(model, 0.004)
    A_2, Q_2 = linear_parts(model, 0.013)
    A, Q = linear_parts(model, 0.017)
    assert pytest.approx(A, rel=EXACT, abs=0) == A_2 @ A_1
    assert pytest.approx(Q, rel=EXACT, abs=0) == A_2 @ Q_1 @ A_2.T + Q_2


def test_no_time_changes_nothing() -> None:
    model, x = turntable_model(paper_turntable()), random_state(2)
    assert np.array_equal(call(model.f, x, np.ones(4), 0.0), x)


def test_both_tilts_are_wrapped_and_the_rates_are_not() -> None:
    model = turntable_model(paper_turntable())
    moved = call(model.retract, np.array([3.0, -3.0, 3.0, -3.0]), np.array([1.0, -1.0, 1.0, -1.0]))
    assert moved == pytest.approx([4 - 2 * np.pi, 2 * np.pi - 4, 4, -4], rel=EXACT)


def test_sensors_with_biases() -> None:
    table = with_sensor("gyro", bias_std_rad_s=0.1, bias_walk_rad_s_per_sqrt_s=0.02)
    model = turntable_model(table)
    assert model.state_names[4:] == ("gyro_bias_x_rad_s", "gyro_bias_y_rad_s")
    assert model.state_units[4:] == ("rad/s", "rad/s")
    x = np.array([*random_state(3), 0.2, -0.3])
    reading = equation_11(x[:4]) + np.array([0.2, -0.3])
    assert call(model.sensor("gyro").h, x) == pytest.approx(reading, rel=EXACT)
    assert model.prior.std[4:] == pytest.approx([0.1, 0.1])
    _, Q = linear_parts(model, 0.25)
    assert Q[4:, 4:] == pytest.approx(np.eye(2) * 0.02**2 * 0.25, rel=EXACT)
