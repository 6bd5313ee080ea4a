"""The camera's pose of a target on the pen, and the angle between two poses."""

from __future__ import annotations

from functools import cache
from typing import Any

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from models.pen import pen_model
from models.rotation import SMALL_ANGLE_SQUARED, rotation_matrix, rotation_vector
from models.sensor_kinds.pose_camera import PoseCamera
from models.sensor_model import SensorModel
from tests.models.pens import CAMERA, FIXED_SPIN_RAD, Array, call, matrix, pen, random_rotation
from tests.references.free_states import still_state
from tests.references.trajectory import random_motion

ROUNDING = 1e-12
PLACE = (0.01, -0.02, 0.15)
TARGET_TO_BODY = random_rotation(np.random.default_rng(5))


@cache
def camera_of(degrees_of_freedom: int, **keys: Any) -> SensorModel:
    mounting = {"position_m": PLACE, "sensor_to_body": TARGET_TO_BODY, **keys}
    return pen_model(pen(degrees_of_freedom, {"camera": PoseCamera(**CAMERA, **mounting)})).sensors[
        0
    ]


def pose(degrees_of_freedom: int, seed: int) -> tuple[Array, Array, Array]:
    """Return a state, where the target is in it and the matrix from body to world."""
    fixed_spin = FIXED_SPIN_RAD if degrees_of_freedom == 5 else None
    motion = random_motion(np.random.default_rng(seed), fixed_spin)
    x = motion.state(0.2, degrees_of_freedom)
    return x, motion.position(0.2, np.array(PLACE)), motion.body_to_world(0.2)


def reading(place: Array, body_to_world: Array) -> Array:
    """Return what the camera sees of a body: position and rotation vector of the target."""
    target = Rotation.from_matrix(body_to_world @ np.array(TARGET_TO_BODY))
    return np.concatenate([place, target.as_rotvec()])


def turned(body_to_world: Array, turn: Array) -> Array:
    """Return a body turned by a rotation vector in its own axes."""
    return np.asarray(body_to_world @ Rotation.from_rotvec(turn).as_matrix())


@pytest.mark.parametrize("degrees_of_freedom", [5, 6])
@pytest.mark.parametrize("seed", range(8))
def test_reading_is_the_pose(degrees_of_freedom: int, seed: int) -> None:
    x, place, body_to_world = pose(degrees_of_freedom, seed)
    expected = reading(place, body_to_world)
    # Near π the entries of the matrix determine the vector less and less well.
    tolerance = 1e-14 / min(1.0, np.pi - float(np.linalg.norm(expected[3:])))
    assert call(camera_of(degrees_of_freedom).h, x) == pytest.approx(expected, abs=tolerance)


@pytest.mark.parametrize("degrees_of_freedom", [5, 6])
@pytest.mark.parametrize("seed", range(8))
def test_residual_of_the_own_reading_is_zero(degrees_of_freedom: int, seed: int) -> None:
    camera = camera_of(degrees_of_freedom)
    x, _, _ = pose(degrees_of_freedom, seed)
    residual = call(camera.residual, call(camera.h, x), x)
    assert residual.shape == (camera.n_r,) == (degrees_of_freedom,)
    assert np.abs(residual).max() < ROUNDING


@settings(max_examples=40, deadline=None)
@given(
    st.lists(st.floats(-1.7, 1.7), min_size=3, max_size=3),
    st.lists(st.floats(-0.5, 0.5), min_size=3, max_size=3),
    st.integers(0, 20),
)
def test_residual_with_spin_is_the_turn(turn: list[float], shift: list[float], seed: int) -> None:
    """Position in world axes, rotation vector in body axes, at any size below π."""
    x, place, body_to_world = pose(6, seed)
    y = reading(place + shift, turned(body_to_world, np.array(turn)))
    expected = [*shift, *turn]
    assert call(CAMERA_6.residual, y, x) == pytest.approx(expected, abs=ROUNDING)


@settings(max_examples=40, deadline=None)
@given(
    st.lists(st.floats(-2.1, 2.1), min_size=2, max_size=2),
    st.floats(-3.0, 3.0),
    st.integers(0, 20),
)
def test_residual_without_spin_is_the_tilt(tilt: list[float], spin: float, seed: int) -> None:
    """Two rows: how the axis leans about body x and y; a seen spin changes nothing."""
    x, place, body_to_world = pose(5, seed)
    tilted = turned(body_to_world, np.array([*tilt, 0.0]))
    y = reading(place, turned(tilted, np.array([0.0, 0.0, spin])))
    assert call(CAMERA_5.residual, y, x) == pytest.approx([0, 0, 0, *tilt], abs=ROUNDING)


def test_noise_follows_the_rows() -> None:
    assert CAMERA_5.noise_std == pytest.approx([2e-4] * 3 + [3e-3] * 2)
    assert CAMERA_6.noise_std == pytest.approx([2e-4] * 3 + [3e-3] * 3)


CAMERA_5, CAMERA_6 = camera_of(5), camera_of(6)

_R = ca.SX.sym("R", 3, 3)
LOG = ca.Function("log", [_R], [rotation_vector(_R)])
LOG_SLOPE = ca.Function("slope", [_R], [ca.jacobian(rotation_vector(_R), ca.vec(_R))])
_V = ca.SX.sym("v", 3)
EXP = ca.Function("exp", [_V], [rotation_matrix(_V)])
EXP_SLOPE = ca.Function("slope", [_V], [ca.jacobian(ca.vec(rotation_matrix(_V)), _V)])

_AGAIN = rotation_vector(rotation_matrix(_V))
AGAIN_SLOPE = ca.Function("slope", [_V], [ca.jacobian(_AGAIN, _V)])
AGAIN_CURVATURE = ca.Function("curvature", [_V], [ca.hessian(ca.sumsqr(_AGAIN) / 2, _V)[0]])

NEAR_ZERO = [0.0, 1e-300, 1e-12, 9e-7, 1.1e-6, 1e-3, 0.5]
"""Both sides of the switch to the limit of the formula, at 1e-6 rad."""
AXES = [*np.eye(3), np.ones(3) / np.sqrt(3), np.array([0.6, 0.0, -0.8])]


@pytest.mark.parametrize("angle", [*NEAR_ZERO, 3.0, np.pi - 1e-3, np.pi, 5.0])
@pytest.mark.parametrize("axis", AXES, ids=str)
def test_rotation_matrix_of_a_vector(axis: Array, angle: float) -> None:
    expected = Rotation.from_rotvec(angle * axis).as_matrix()
    assert matrix(EXP, angle * axis) == pytest.approx(expected, abs=1e-14)
    assert np.isfinite(matrix(EXP_SLOPE, angle * axis)).all()


@pytest.mark.parametrize("angle", [*NEAR_ZERO, 3.0, np.pi - 1e-3, np.pi - 2e-6])
@pytest.mark.parametrize("axis", AXES, ids=str)
def test_rotation_vector_of_a_matrix(axis: Array, angle: float) -> None:
    """Entries of the matrix are rounded to 1e-16, which angle / sine multiplies."""
    tolerance = 1e-15 / np.sinc(angle / np.pi)
    rotation = Rotation.from_rotvec(angle * axis).as_matrix()
    assert call(LOG, rotation) == pytest.approx(angle * axis, abs=tolerance)


@pytest.mark.parametrize("angle", [*NEAR_ZERO, 3.0])
@pytest.mark.parametrize("axis", AXES, ids=str)
def test_vector_to_matrix_and_back_has_slope_one(axis: Array, angle: float) -> None:
    """Log(Exp(v)) = v, so its Jacobian is I, and so is the Hessian of ½|Log(Exp(v))|².

    IPOPT takes the second.
    """
    slope = matrix(AGAIN_SLOPE, angle * axis)
    curvature = matrix(AGAIN_CURVATURE, angle * axis)
    assert slope == pytest.approx(np.eye(3), abs=ROUNDING)
    assert curvature == pytest.approx(np.eye(3), abs=ROUNDING)


@pytest.mark.parametrize("function", [LOG_SLOPE, EXP_SLOPE], ids=["Log", "Exp"])
def test_slope_at_rest(function: ca.Function) -> None:
    """At the identity: Log picks the skew part, Exp gives [e_k]×."""
    generators = [np.cross(unit, np.eye(3)).T for unit in np.eye(3)]
    columns = np.column_stack([generator.ravel(order="F") for generator in generators])
    if function is EXP_SLOPE:
        assert matrix(function, np.zeros(3)) == pytest.approx(columns, abs=1e-15)
    else:
        assert matrix(function, np.eye(3)) == pytest.approx(columns.T / 2, abs=1e-15)


@pytest.mark.parametrize("distance", [0.0, 1e-12, 9e-7, 1.1e-6, 1e-3])
@pytest.mark.parametrize("axis", AXES, ids=str)
def test_rotation_vector_near_pi_is_finite(axis: Array, distance: float) -> None:
    rotation = Rotation.from_rotvec((np.pi - distance) * axis).as_matrix()
    assert np.isfinite(call(LOG, rotation)).all()
    assert np.isfinite(matrix(LOG_SLOPE, rotation)).all()


@pytest.mark.parametrize("degrees_of_freedom", [5, 6])
@pytest.mark.parametrize("angle", [0.0, 1e-9, np.pi - 1e-3, np.pi - 1e-9, np.pi])
def test_residual_is_finite_at_every_angle(degrees_of_freedom: int, angle: float) -> None:
    """Seen as predicted, and seen the wrong way round: values and Jacobians stay finite."""
    camera = camera_of(degrees_of_freedom)
    x, place, body_to_world = pose(degrees_of_freedom, 3)
    slope = camera.residual.jacobian()
    for axis in AXES:
        y = reading(place, turned(body_to_world, angle * axis))
        assert np.isfinite(call(camera.residual, y, x)).all()
        for jacobian in slope(y, x, np.zeros(camera.n_r)):
            assert np.isfinite(jacobian.full()).all()


def test_small_angles_switch_without_a_step() -> None:
    """The formula and its limit agree where one takes over from the other."""
    switch = np.sqrt(SMALL_ANGLE_SQUARED)
    for axis in AXES:
        below, above = (Rotation.from_rotvec(switch * k * axis).as_matrix() for k in (0.99, 1.01))
        step = call(LOG, above) - call(LOG, below)
        assert step == pytest.approx(0.02 * switch * axis, abs=1e-15)


@pytest.mark.parametrize("azimuth", [np.pi, -np.pi])
def test_reading_of_a_pen_that_points_backwards(azimuth: float) -> None:
    """A target with the pen's own axes is turned by exactly π at azimuth π, spin 0."""
    camera = camera_of(6, sensor_to_body=((1, 0, 0), (0, 1, 0), (0, 0, 1)))
    x = still_state(0.9, azimuth)
    assert np.linalg.norm(call(camera.h, x)[3:]) == pytest.approx(np.pi)
