"""The printed equations: their check values, and what is left of them for comparison."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
import pytest

from models import printed
from models.errors import InputError
from models.kinematics import RigidBody
from models.pen import pen_model
from models.pen_file import parse_pen
from models.printed import ACCELEROMETER_SIGNS, GYROSCOPE_SIGNS, PRINTED_ERRORS, PrintedBody
from models.rotation import world_to_body
from models.sensor_kinds.accelerometer import Accelerometer
from models.sensor_kinds.gyroscope import Gyroscope
from models.sensor_kinds.pose_camera import PoseCamera
from models.state_space import StateSpaceModel
from tests.models.pens import ACCELEROMETER, CAMERA, GYROSCOPE, Array, call, matrix, random_state
from tests.models.pens import pen as pen_config
from tests.references import pen_readings

DIGITS = 5e-9  # half a unit of the eighth decimal
R, GRAVITY = 0.1, 9.81
ANGLES, RATES, ACCELERATIONS = (0.7, 0.9), (1.3, -0.8), (0.5, 0.4)
CHECK_STATE = np.concatenate([[0, 0, 0, *part] for part in (ANGLES, RATES, ACCELERATIONS)])
STATES = np.array([random_state(np.random.default_rng(seed), 5) for seed in range(20)])

X = ca.SX.sym("x", 15)
Q, Q_DOT, Q_DDOT = X[:5], X[5:10], X[10:]
RIGID = RigidBody(Q, Q_DOT, Q_DDOT, Q[:3], world_to_body(Q[3], Q[4], 0.0))


def function(expression: ca.SX) -> ca.Function:
    return ca.Function("of_state", [X], [expression])


GRAVITY_PART = function(printed.gravity_part(Q, GRAVITY))
TRANSLATION_PART = function(printed.translation_part(Q, Q_DDOT))
ROTATION_PART = function(printed.rotation_part(Q, Q_DOT, Q_DDOT, R))
BODY_RATE = function(printed.body_rate(Q, Q_DOT))
OBSERVATION = function(printed.observation(Q, Q_DOT, Q_DDOT, R, GRAVITY))
ERRORS = {name: function(term) for name, term in printed.error_terms(RIGID, R).items()}


def axis_pen(**others: Any) -> StateSpaceModel:
    """Return a pen with five degrees of freedom, its accelerometer at r on the axis."""
    sensors = {
        "accel": Accelerometer(**ACCELEROMETER, position_m=(0.0, 0.0, R)),
        "gyro": Gyroscope(**GYROSCOPE),
        "camera": PoseCamera(**CAMERA, position_m=(0.01, 0.02, 0.1)),
    }
    return pen_model(pen_config(5, sensors, fixed_spin_rad=0.0, gravity_m_s2=GRAVITY, **others))


def test_check_values() -> None:
    """Section 1 of the equations: the values in parentheses, printed."""
    rotation = [0.12229012, 0.031080498414, 0.12930142]
    assert np.abs(call(ROTATION_PART, CHECK_STATE) - rotation).max() < DIGITS
    assert np.abs(call(GRAVITY_PART, CHECK_STATE) - [-6.09799379, 0, -7.68443698]).max() < DIGITS
    assert np.abs(call(BODY_RATE, CHECK_STATE) - [0.80809296, -0.8]).max() < DIGITS


def test_rotation_is_7_entry_by_entry() -> None:
    for x in STATES:
        phi, theta = x[3:5]
        tilt = [[np.sin(theta), 0, -np.cos(theta)], [0, 1, 0], [np.cos(theta), 0, np.sin(theta)]]
        turn = [[np.cos(phi), np.sin(phi), 0], [-np.sin(phi), np.cos(phi), 0], [0, 0, 1]]
        B_r = np.array(tilt) @ np.array(turn)
        np.testing.assert_allclose(matrix(function(printed.rotation(Q)), x), B_r, atol=1e-15)
        inverse = np.linalg.inv(B_r)
        np.testing.assert_allclose(call(TRANSLATION_PART, x), inverse @ x[10:13], rtol=1e-12)


@pytest.mark.parametrize("block", [3, 5])
def test_transition_is_3_block_by_block(block: int) -> None:
    dt, I, O = 0.07, np.eye(block), np.zeros((block, block))  # noqa: E741
    A = np.block([[I, I * dt, I * dt**2 / 2], [O, I, I * dt], [O, O, I]])
    symbol, x, v = ca.SX.sym("dt"), ca.SX.sym("x", 3 * block), ca.SX.sym("v", 3 * block)
    transition = ca.Function("A", [symbol], [printed.transition(symbol, block)])
    np.testing.assert_array_equal(matrix(transition, dt), A)
    step = ca.Function("step", [x, v, symbol], [printed.next_state(x, v, symbol, block=block)])
    before, noise = np.random.default_rng(0).normal(size=(2, 3 * block))
    np.testing.assert_allclose(call(step, before, noise, dt), A @ before + noise, rtol=1e-14)


def test_observation_is_the_sum() -> None:
    for x in STATES:
        parts = [call(part, x) for part in (GRAVITY_PART, TRANSLATION_PART, ROTATION_PART)]
        expected = [*np.sum(parts, axis=0), *call(BODY_RATE, x)]
        np.testing.assert_allclose(call(OBSERVATION, x), expected, rtol=1e-13)


def printed_in_body_axes(states: Array) -> Array:
    """(9) along the comparison signs, (n, 5)."""
    signs = [*ACCELEROMETER_SIGNS, *GYROSCOPE_SIGNS]
    return np.array([signs * call(OBSERVATION, x) for x in states])


def test_comparison_signs_agree_at_rest() -> None:
    at_rest = STATES.copy()
    at_rest[:, 5:] = 0.0
    force = pen_readings.accelerometer(at_rest, R, GRAVITY)
    np.testing.assert_allclose(printed_in_body_axes(at_rest)[:, :3], force, atol=1e-13)


def test_gyroscope_in_comparison_signs_is_the_rigid_body_s() -> None:
    """Nothing is left to compare; the third rate is not measured."""
    rates = pen_readings.gyroscope(STATES)
    np.testing.assert_allclose(printed_in_body_axes(STATES)[:, 3:], rates[:, :2], atol=1e-14)
    x = STATES[0]
    as_printed = axis_pen(printed_errors=PRINTED_ERRORS)
    np.testing.assert_allclose(call(as_printed.sensor("gyro").h, x), rates[0], atol=1e-14)


def test_closed_forms_of_the_errors() -> None:
    """E2, E3, E4 of the equations' table, typed here a second time."""
    for x, B in zip(STATES, pen_readings.world_to_body(STATES), strict=True):
        theta, rate_phi, rate_theta, rate_theta_dot = x[4], x[8], x[9], x[14]
        centripetal = rate_phi**2 * np.sin(theta) * np.cos(theta)
        expected = {
            "E2": np.diag(ACCELEROMETER_SIGNS) @ B.T @ x[10:13] - B @ x[10:13],
            "E3": [2 * R * (rate_theta_dot + centripetal), 0, 0],
            "E4": [0, 2 * R * rate_phi * rate_theta * np.sin(theta), 0],
        }
        for name, value in expected.items():
            assert np.abs(value).max() > 1e-3  # no error would prove nothing
            np.testing.assert_allclose(call(ERRORS[name], x), value, rtol=1e-10, atol=1e-12)


@pytest.mark.parametrize("error", PRINTED_ERRORS)
def test_a_pen_makes_the_error_it_is_asked_for(error: str) -> None:
    rigid, wrong = axis_pen().sensor("accel"), axis_pen(printed_errors=(error,)).sensor("accel")
    for x in STATES:
        np.testing.assert_allclose(
            call(wrong.h, x) - call(rigid.h, x), call(ERRORS[error], x), rtol=1e-9, atol=1e-12
        )


def test_all_errors_are_the_printed_accelerometer() -> None:
    accel = axis_pen(printed_errors=PRINTED_ERRORS).sensor("accel")
    readings = np.array([call(accel.h, x) for x in STATES])
    np.testing.assert_allclose(readings, printed_in_body_axes(STATES)[:, :3], atol=1e-11)


def test_no_errors_are_the_rigid_body() -> None:
    accel = axis_pen().sensor("accel")
    readings = np.array([call(accel.h, x) for x in STATES])
    np.testing.assert_allclose(readings, pen_readings.accelerometer(STATES, R, GRAVITY), atol=1e-12)
    nothing = PrintedBody(RIGID, ()).specific_force(ca.SX([0, 0, R]), GRAVITY)
    np.testing.assert_array_equal(call(function(nothing), STATES[0]), readings[0])


def test_a_camera_does_not_notice() -> None:
    rigid, wrong = axis_pen(), axis_pen(printed_errors=PRINTED_ERRORS)
    pose = call(rigid.sensor("camera").h, STATES[1])
    np.testing.assert_array_equal(call(wrong.sensor("camera").h, STATES[1]), pose)


ACCEL = {"kind": "accelerometer", "noise_density_ug_per_sqrt_hz": 90, "bandwidth_hz": 50}
HALF_TURN = [[-1, 0, 0], [0, -1, 0], [0, 0, 1]]
REFUSED = {
    "six degrees of freedom": ({"degrees_of_freedom": 6}, {}, "degrees_of_freedom = 5"),
    "six by default": ({"degrees_of_freedom": None}, {}, "degrees_of_freedom = 5"),
    "spin": ({"fixed_spin_rad": 0.1}, {}, "fixed_spin_rad = 0"),
    "off the axis": ({}, {"position_mm": [0, 4, 100]}, r"accelerometer accel at .* \(0, 0, r\)"),
    "turned": ({}, {"sensor_to_body": HALF_TURN}, "the identity as sensor_to_body"),
    "twice": ({"printed_errors": ["E2", "E2"]}, {}, "each error once, got E2, E2"),
    "no such error": ({"printed_errors": ["E5"]}, {}, "'E2', 'E3' or 'E4'"),
}


def printed_pen(pen: dict[str, Any], accel: dict[str, Any]) -> Any:
    keys = {"name": "p", "degrees_of_freedom": 5, "printed_errors": ["E2"], **pen}
    sensors = {"accel": {**ACCEL, "position_mm": [0, 0, 100], **accel}}
    given = {key: value for key, value in keys.items() if value is not None}
    return parse_pen({**given, "sensors": sensors})


@pytest.mark.parametrize(("pen", "accel", "expected"), REFUSED.values(), ids=REFUSED.keys())
def test_other_mountings_are_refused(pen: Any, accel: Any, expected: str) -> None:
    with pytest.raises(InputError, match=f"^pen: key printed_errors.*: .*{expected}") as error:
        printed_pen(pen, accel)
    assert "\n" not in str(error.value)


def test_the_template_of_the_refused_is_right() -> None:
    assert printed_pen({}, {}).printed_errors == ("E2",)
    assert printed_pen({"printed_errors": []}, {"position_mm": [0, 4, 100]}).printed_errors == ()
