"""One test or more per row of the errata table, section 1 of the equations.

A row that is a mounting is shown both ways round; one that is an error is
shown to stay under every choice of axis signs.
"""

from __future__ import annotations

from itertools import product
from typing import Any

import casadi as ca
import numpy as np
import pytest

from models import printed
from models.euler_pen import euler_body
from models.free_pen import OMEGA
from models.kinematics import RigidBody
from models.motion import white_jerk_motion
from models.pen import pen_model
from models.rotation import world_to_body
from models.sensor_kinds.accelerometer import Accelerometer
from models.sensor_kinds.gyroscope import Gyroscope
from models.state_space import StateSpaceModel
from models.turntable import world_to_table
from tests.models.pens import ACCELEROMETER, GYROSCOPE, Array, call, matrix, pen, random_state

R, GRAVITY = 0.1, 9.81
UPWARD = np.array([0.0, 0.0, GRAVITY])
STATES = [random_state(np.random.default_rng(seed), 5) for seed in range(10)]
SIGNS = [np.array(signs) for signs in product((1, -1), repeat=3)]
TO_THE_TIP = [[1, 0, 0], [0, -1, 0], [0, 0, -1]]
"""A sensor upside down: half a turn about x."""
HALF_TURN = [[-1, 0, 0], [0, -1, 0], [0, 0, 1]]
"""A sensor turned about the pen's axis by half a turn."""

X = ca.SX.sym("x", 15)
Q, Q_DOT, Q_DDOT = X[:5], X[5:10], X[10:]
RIGID = RigidBody(Q, Q_DOT, Q_DDOT, Q[:3], world_to_body(Q[3], Q[4], 0.0))


def of_state(expression: ca.SX) -> ca.Function:
    return ca.Function("of_state", [X], [expression])


B_R = of_state(printed.rotation(Q))
GRAVITY_PART = of_state(printed.gravity_part(Q, GRAVITY))
TRANSLATION_PART = of_state(printed.translation_part(Q, Q_DDOT))
ROTATION_PART = of_state(printed.rotation_part(Q, Q_DOT, Q_DDOT, R))
BODY_RATE = of_state(printed.body_rate(Q, Q_DOT))
RIGID_GRAVITY = of_state(RIGID.world_to_body @ ca.DM([0, 0, GRAVITY]))
RIGID_ROTATION = of_state(
    RIGID.specific_force(ca.SX([0, 0, R]), 0.0) - RIGID.specific_force(ca.SX.zeros(3), 0.0)
)


def agree(one: Array, other: Array) -> bool:
    return bool(np.abs(one - other).max() < 1e-10)


def axis_pen(degrees_of_freedom: int = 5, **mounting: Any) -> StateSpaceModel:
    """Return the pen with both sensors on the axis, mounted alike."""
    sensors = {
        "accel": Accelerometer(**ACCELEROMETER, position_m=(0.0, 0.0, R), **mounting),
        "gyro": Gyroscope(**GYROSCOPE, **mounting),
    }
    config = pen(
        degrees_of_freedom,
        sensors,
        fixed_spin_rad=0.0,
        gravity_m_s2=GRAVITY,
        motion=white_jerk_motion(100.0, 1000.0),
    )
    return pen_model(config)


def test_e1_blocks_of_three_do_not_fit_the_state() -> None:
    dt, zeros = ca.SX(0.02), ca.SX.zeros(15)
    assert printed.transition(dt).shape == (9, 9)
    with pytest.raises(RuntimeError, match="imension"):
        printed.next_state(X, zeros, dt)


def test_e1_blocks_of_five_are_the_model() -> None:
    dt = ca.SX.sym("dt")
    step = ca.Function("step", [X, dt], [printed.next_state(X, ca.SX.zeros(15), dt, block=5)])
    model = axis_pen()
    for x in STATES:
        expected = call(model.f, x, np.zeros(15), 0.02)
        np.testing.assert_allclose(call(step, x, 0.02), expected, rtol=1e-14)


def test_e2_no_axis_signs_make_the_inverse_agree() -> None:
    """(4) + (5) against what the tip of a rigid body feels, (7) read either way."""
    for signs, inverted in product(SIGNS, (False, True)):
        worst = 0.0
        for x in STATES:
            to_body = matrix(B_R, x).T if inverted else matrix(B_R, x)
            felt = to_body @ (x[10:13] + UPWARD)
            read = signs * (call(GRAVITY_PART, x) + call(TRANSLATION_PART, x))
            worst = max(worst, np.abs(read - felt).max())
        assert worst > 1.0  # m/s²


def test_e2_no_mounting_makes_the_inverse_agree() -> None:
    """A sensor turned by M reads M B a; (5) wants an M that moves with the attitude."""
    wanted = [matrix(B_R, x).T @ matrix(B_R, x).T for x in STATES[:2]]
    for x, M in zip(STATES, wanted, strict=False):
        np.testing.assert_allclose(
            M @ matrix(B_R, x) @ x[10:13], call(TRANSLATION_PART, x), rtol=1e-12
        )
    assert np.abs(wanted[0] - wanted[1]).max() > 0.5


def test_e2_the_matrix_itself_agrees() -> None:
    """With B_r in (5), x and y of (4) + (5) hold, and z once B_r has the z axis of (4).

    Left as in (7), that axis points to the top and the one of (4) to the tip:
    the sign that E5 leaves open is one for (4), (5) and (6) together.
    """
    to_the_tip = np.diag([1, 1, -1])
    for x in STATES:
        felt = matrix(B_R, x) @ (x[10:13] + UPWARD)
        corrected = call(GRAVITY_PART, x) + matrix(B_R, x) @ x[10:13]
        assert agree(corrected[:2], felt[:2])
        assert not agree(corrected[2], felt[2])
        assert not agree(corrected[2], -felt[2])
        in_axes_of_4 = call(GRAVITY_PART, x) + to_the_tip @ matrix(B_R, x) @ x[10:13]
        assert agree(in_axes_of_4, to_the_tip @ felt)


def test_e3_one_sign_of_x_cannot_serve_both_parts() -> None:
    for x in STATES:
        holds = {
            sign: (
                agree(sign * call(GRAVITY_PART, x)[0], call(RIGID_GRAVITY, x)[0]),
                agree(sign * call(ROTATION_PART, x)[0], call(RIGID_ROTATION, x)[0]),
            )
            for sign in (1, -1)
        }
        assert holds == {1: (True, False), -1: (False, True)}


def test_e4_y_lacks_the_coriolis_term_under_either_sign() -> None:
    """∂²/∂ωφ ∂ωθ: 0 as printed, whatever the sign, and -2 r sinθ of a rigid body."""

    def mixed_derivative(part: ca.Function) -> ca.Function:
        by_phi = ca.jacobian(part(X)[1], Q_DOT[3])
        return of_state(ca.jacobian(by_phi, Q_DOT[4]))

    as_printed, rigid = mixed_derivative(ROTATION_PART), mixed_derivative(RIGID_ROTATION)
    for x in STATES:
        coriolis = -2 * R * np.sin(x[4])
        for sign in (1, -1):
            assert sign * call(as_printed, x)[0] == 0
        assert call(rigid, x)[0] == pytest.approx(coriolis, rel=1e-12)
        without = call(RIGID_ROTATION, x)[1] - coriolis * x[8] * x[9]
        assert without == pytest.approx(call(ROTATION_PART, x)[1], abs=1e-12)


MIRROR = np.diag([1, 1, -1])
"""From the frame of (7), (-e_θ, e_φ, e_r), to the left-handed (-e_θ, e_φ, -e_r)."""


def in_axes(M: Array, x: Array) -> tuple[Array, Array, Array]:
    """Return gravity, rotation and rates (3,) of a rigid body in the axes M of the frame (7).

    Rates are a pseudovector: axes of the other hand turn their sign.
    """
    rate = np.array([-np.cos(x[4]) * x[8], -x[9], np.sin(x[4]) * x[8]])
    force, rotation = M @ call(RIGID_GRAVITY, x), M @ call(RIGID_ROTATION, x)
    return force, rotation, np.linalg.det(M) * M @ rate


def holds_at_once(M: Array) -> bool:
    """Whether (4), z of (6) and both rates of (8) are those of a rigid body in the axes M."""
    for x in STATES:
        gravity, rotation, rate = in_axes(M, x)
        if not (
            agree(gravity, call(GRAVITY_PART, x))
            and agree(rotation[2], call(ROTATION_PART, x)[2])
            and agree(rate[:2], call(BODY_RATE, x))
        ):
            return False
    return True


def test_e5_all_signs_hold_at_once_in_one_left_handed_frame() -> None:
    """And in no other choice of axis signs, so that a right-handed frame mounts each sensor."""
    assert np.linalg.det(MIRROR) == pytest.approx(-1)
    assert [list(signs) for signs in SIGNS if holds_at_once(np.diag(signs))] == [[1, 1, -1]]


def test_e5_an_axis_to_the_tip_reads_z_as_printed() -> None:
    upside_down = axis_pen(sensor_to_body=TO_THE_TIP, axes=("z",)).sensor("accel")
    upright = axis_pen(axes=("z",)).sensor("accel")
    for x in STATES:
        x = x.copy()
        x[10:13] = 0.0  # (5) is E2
        z = call(GRAVITY_PART, x)[2] + call(ROTATION_PART, x)[2]
        assert call(upside_down.h, x)[0] == pytest.approx(z, rel=1e-12)
        rigid = call(RIGID_GRAVITY, x)[2] + call(RIGID_ROTATION, x)[2]
        assert call(upright.h, x)[0] == pytest.approx(rigid, rel=1e-12)
        assert rigid == pytest.approx(-z, rel=1e-12)


@pytest.mark.parametrize("axis", ["x", "y"])
def test_e5_a_gyroscope_goes_in_either_way_round(axis: str) -> None:
    turned = axis_pen(sensor_to_body=HALF_TURN, axes=(axis,)).sensor("gyro")
    straight = axis_pen(axes=(axis,)).sensor("gyro")
    row = "xy".index(axis)
    for x in STATES:
        as_printed = call(BODY_RATE, x)[row]
        assert call(turned.h, x)[0] == pytest.approx(as_printed, rel=1e-12)
        assert call(straight.h, x)[0] == pytest.approx(-as_printed, rel=1e-12)


def test_e5_the_third_rate_is_not_measured() -> None:
    assert BODY_RATE.numel_out(0) == 2
    gyro = axis_pen(axes=("z",)).sensor("gyro")
    for x in STATES:
        assert call(gyro.h, x)[0] == pytest.approx(np.sin(x[4]) * x[8], rel=1e-12)


TILTS, TILT_RATES = ca.SX.sym("tilts", 2), ca.SX.sym("rates", 2)


TURNTABLE = RigidBody(
    TILTS, TILT_RATES, ca.SX.zeros(2), ca.SX.zeros(3), world_to_table(TILTS[0], TILTS[1])
)
TABLE_FORCE = ca.Function("f", [TILTS], [TURNTABLE.specific_force(ca.SX.zeros(3), GRAVITY)])
TABLE_RATE = ca.Function("w", [TILTS, TILT_RATES], [TURNTABLE.body_rate()])
TABLE_ATTITUDE = ca.Function("B", [TILTS], [TURNTABLE.world_to_body])
TABLE_STATES = np.random.default_rng(3).uniform(-1.4, 1.4, (10, 4))


def force_10(phi: float, theta: float) -> Array:
    """(10)."""
    return GRAVITY * np.array(
        [np.sin(phi), np.cos(phi) * np.sin(theta), np.cos(phi) * np.cos(theta)]
    )


def rate_11(theta: float, phi_dot: float, theta_dot: float) -> Array:
    """(11)."""
    return np.array([theta_dot, phi_dot * np.cos(theta)])


def test_e6_the_second_rate_has_the_other_sign() -> None:
    """With the axes of (10) the y rate is -φ̇ cosθ; a y gyroscope turned round reads (11)."""
    for phi, theta, phi_dot, theta_dot in TABLE_STATES:
        force = call(TABLE_FORCE, [phi, theta])
        np.testing.assert_allclose(force, force_10(phi, theta), rtol=1e-12)
        rate = call(TABLE_RATE, [phi, theta], [phi_dot, theta_dot])
        x, y = rate_11(theta, phi_dot, theta_dot)
        np.testing.assert_allclose(rate[:2], [x, -y], atol=1e-14)
        gyroscope_y = np.array([0, -1, 0])  # its axis, in body axes
        assert gyroscope_y @ rate == pytest.approx(y, abs=1e-14)


def test_e7_the_mirrored_attitude_reads_the_same() -> None:
    for phi, theta, phi_dot, theta_dot in TABLE_STATES:
        here, mirrored = [phi, theta], [np.pi - phi, theta + np.pi]
        force = call(TABLE_FORCE, here)
        np.testing.assert_allclose(call(TABLE_FORCE, mirrored), force, atol=1e-14)
        rate = call(TABLE_RATE, here, [phi_dot, theta_dot])[:2]
        there = call(TABLE_RATE, mirrored, [-phi_dot, theta_dot])[:2]
        np.testing.assert_allclose(there, rate, atol=1e-14)
        apart = matrix(TABLE_ATTITUDE, mirrored) @ matrix(TABLE_ATTITUDE, here).T
        assert np.trace(apart) == pytest.approx(-1, abs=1e-12)  # half a turn


def test_e7_theta_cannot_be_seen_where_cos_phi_vanishes() -> None:
    by_theta = ca.Function("d", [TILTS], [ca.jacobian(TABLE_FORCE(TILTS), TILTS[1])])
    for theta in (-1.0, 0.2, 2.5):
        for phi in (np.pi / 2, -np.pi / 2):
            assert np.abs(call(by_theta, [phi, theta])).max() < 1e-14
        assert np.linalg.norm(call(by_theta, [0.3, theta])) == pytest.approx(GRAVITY * np.cos(0.3))


def test_e7_the_tilts_are_not_azimuth_and_elevation() -> None:
    """Gravity depends on both tilts, but not on an azimuth."""
    both = ca.Function("d", [TILTS], [ca.jacobian(TABLE_FORCE(TILTS), TILTS)])
    assert np.linalg.norm(matrix(both, [0.3, 0.4]), axis=0).min() > 1.0
    by_azimuth = of_state(ca.jacobian(RIGID_GRAVITY(X), Q[3]))
    by_elevation = of_state(ca.jacobian(RIGID_GRAVITY(X), Q[4]))
    for x in STATES:
        assert np.abs(call(by_azimuth, x)).max() < 1e-14
        assert np.linalg.norm(call(by_elevation, x)) == pytest.approx(GRAVITY)


def test_e8_a_pen_without_roll_spins() -> None:
    """ωz vanishes where ψ̇ = -sinθ ωφ, and not where the pen does not spin."""
    q, q_dot = ca.SX.sym("q", 6), ca.SX.sym("q_dot", 6)
    rate = ca.Function("w", [q, q_dot], [euler_body(q, q_dot, ca.SX.zeros(6)).body_rate()])
    gyro = axis_pen(6).sensor("gyro")
    rng = np.random.default_rng(1)
    for x in STATES:
        angles, rates = np.array([*x[:5], 0.8]), np.array([*x[5:10], 0.0])
        unspun = call(rate, angles, rates)
        assert unspun[2] == pytest.approx(np.sin(x[4]) * x[8], rel=1e-12)
        rates[5] = -np.sin(x[4]) * x[8]
        without_roll = call(rate, angles, rates)
        assert without_roll[2] == pytest.approx(0, abs=1e-14)
        free = random_state(rng, 6)
        free[OMEGA] = without_roll
        assert call(gyro.h, free) == pytest.approx(without_roll, abs=1e-14)
