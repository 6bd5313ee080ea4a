"""The check values of section 1 of the equations, and its expansions on the axis."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from models.kinematics import RigidBody
from models.pen import pen_model
from models.rotation import world_to_body
from models.sensor_kinds.accelerometer import Accelerometer
from models.sensor_kinds.gyroscope import Gyroscope
from models.state_space import StateSpaceModel
from tests.models.pens import ACCELEROMETER, GYROSCOPE, Array, call, pen, random_state
from tests.references.free_states import free_state, still_state

DIGITS = 5e-9  # half a unit of the eighth decimal
GRAVITY = 9.81
R = 0.1
ANGLES, RATES, ACCELERATIONS = (0.7, 0.9), (1.3, -0.8), (0.5, 0.4)

ROTATION_PART = np.array([-0.12229012, 0.194012495616, -0.12930142])
GRAVITY_PART = np.array([-6.09799379, 0.0, 7.68443698])
BODY_RATE = np.array([-0.80809296, 0.8, 1.01832498])


def as_state(q: Array, q_dot: Array, q_ddot: Array, degrees_of_freedom: int) -> Array:
    """Return the state of a pen that does not spin, from five coordinates and their derivatives."""
    if degrees_of_freedom == 5:
        return np.concatenate([q, q_dot, q_ddot])
    return free_state(np.concatenate([[*part, 0.0] for part in (q, q_dot, q_ddot)]))


def rigid_body_function(gravity: float) -> ca.Function:
    """Return (q, q̇, q̈) -> (specific force on the axis at r, body rate), no spin."""
    q, q_dot, q_ddot = (ca.SX.sym(name, 5) for name in ("q", "q_dot", "q_ddot"))
    body = RigidBody(q, q_dot, q_ddot, q[:3], world_to_body(q[3], q[4], 0.0))
    force = body.specific_force(ca.SX([0, 0, R]), gravity)
    return ca.Function("body", [q, q_dot, q_ddot], [force, body.body_rate()])


def tip_at_rest(angles: tuple[float, ...]) -> Array:
    return np.array([0.0, 0.0, 0.0, *angles])


def test_rotation_part() -> None:
    force, _ = rigid_body_function(0.0)(*map(tip_at_rest, (ANGLES, RATES, ACCELERATIONS)))
    assert np.abs(force.full().ravel() - ROTATION_PART).max() < DIGITS


def test_gravity_part() -> None:
    rest = tip_at_rest((0.0, 0.0))
    force, _ = rigid_body_function(GRAVITY)(tip_at_rest(ANGLES), rest, rest)
    assert np.abs(force.full().ravel() - GRAVITY_PART).max() < DIGITS


def test_body_rate() -> None:
    _, rate = rigid_body_function(GRAVITY)(*map(tip_at_rest, (ANGLES, RATES, ACCELERATIONS)))
    assert np.abs(rate.full().ravel() - BODY_RATE).max() < DIGITS


def axis_pen(degrees_of_freedom: int, gravity: float = GRAVITY) -> StateSpaceModel:
    """Return the pen with an accelerometer at r on the axis and a gyroscope, spin 0."""
    sensors = {
        "accel": Accelerometer(**ACCELEROMETER, position_m=(0.0, 0.0, R)),
        "gyro": Gyroscope(**GYROSCOPE),
    }
    return pen_model(
        pen(degrees_of_freedom, sensors, fixed_spin_rad=0.0, gravity_m_s2=gravity),
    )


@pytest.mark.parametrize("degrees_of_freedom", [5, 6])
def test_sensors_read_the_check_values(degrees_of_freedom: int) -> None:
    model = axis_pen(degrees_of_freedom)
    q, q_dot, q_ddot, rest = map(tip_at_rest, (ANGLES, RATES, ACCELERATIONS, (0.0, 0.0)))
    moving = as_state(q, q_dot, q_ddot, degrees_of_freedom)
    still = as_state(q, rest, rest, degrees_of_freedom)
    accel, gyro = model.sensor("accel").h, model.sensor("gyro").h
    assert np.abs(call(accel, still) - GRAVITY_PART).max() < DIGITS
    assert np.abs(call(accel, moving) - call(accel, still) - ROTATION_PART).max() < DIGITS
    assert np.abs(call(gyro, moving) - BODY_RATE).max() < DIGITS
    assert np.abs(call(gyro, still)).max() == 0


@pytest.mark.parametrize("degrees_of_freedom", [5, 6])
@pytest.mark.parametrize("seed", range(5))
def test_expansions_on_the_axis(degrees_of_freedom: int, seed: int) -> None:
    """f_b and ω_b as section 1 writes them out, typed here a second time."""
    q, q_dot, q_ddot = random_state(np.random.default_rng(seed), 5).reshape(3, 5)
    phi, theta = q[3:5]
    rate_phi, rate_theta = q_dot[3:5]
    phi_2, theta_2 = q_ddot[3:5]
    sin, cos = np.sin(theta), np.cos(theta)
    B = np.array([[sin, 0, -cos], [0, 1, 0], [cos, 0, sin]]) @ np.array(
        [[np.cos(phi), np.sin(phi), 0], [-np.sin(phi), np.cos(phi), 0], [0, 0, 1]]
    )
    force = np.array([-GRAVITY * cos, 0, GRAVITY * sin]) + B @ q_ddot[:3]
    force += R * np.array(
        [
            -theta_2 - rate_phi**2 * sin * cos,
            cos * phi_2 - 2 * rate_phi * rate_theta * sin,
            -(rate_theta**2) - rate_phi**2 * cos**2,
        ]
    )
    rate = np.array([-cos * rate_phi, -rate_theta, sin * rate_phi])
    model = axis_pen(degrees_of_freedom)
    state = as_state(q, q_dot, q_ddot, degrees_of_freedom)
    assert call(model.sensor("accel").h, state) == pytest.approx(force, rel=1e-12, abs=1e-12)
    assert call(model.sensor("gyro").h, state) == pytest.approx(rate, rel=1e-12, abs=1e-12)


def test_free_fall_reads_nothing_and_rest_reads_gravity_upwards() -> None:
    model = axis_pen(6, gravity=9.83)
    x = still_state(np.pi / 2)
    assert call(model.sensor("accel").h, x) == pytest.approx([0, 0, 9.83], abs=1e-14)
    x[14] = -9.83
    assert call(model.sensor("accel").h, x) == pytest.approx([0, 0, 0], abs=1e-14)
