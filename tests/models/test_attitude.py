"""Attitudes against SciPy's rotations and five-point differences."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from models import attitude, rotation
from models.arrays import Array
from tests.references.free_tangent import heading_of, turn_of
from tests.references.rodrigues_rate import rate

RNG = np.random.default_rng(16)
UPRIGHT = Rotation.from_matrix(np.eye(3))
"""The body's z axis is the world's."""
ATTITUDES = [
    *Rotation.random(40, random_state=16),
    UPRIGHT,
    Rotation.from_rotvec([np.pi, 0, 0]),
    Rotation.from_rotvec([0, np.pi, 0]),
    Rotation.from_rotvec([0, 0, np.pi]),
    Rotation.from_rotvec([0, 0, np.pi - 1e-9]),
    Rotation.from_rotvec([1e-12, 0, 0]),
]


def function(of: object, *sizes: int) -> ca.Function:
    symbols = [ca.SX.sym(f"x{i}", n) for i, n in enumerate(sizes)]
    return ca.Function("of", symbols, [ca.densify(of(*symbols))])  # type: ignore[operator]


def sigma_of(R: Rotation) -> Array:
    q = R.as_quat(canonical=True)
    return np.array(q[:3] / (1 + q[3]))


def rotation_of(sigma: Array) -> Rotation:
    return Rotation.from_mrp(np.asarray(sigma).ravel())


TO_MATRIX = function(attitude.body_to_world, 3)
PRODUCT = function(attitude.product, 3, 3)
EXPONENTIAL = function(attitude.exponential, 3)
RETRACT, DIFFERENCE = function(attitude.retract, 3, 3), function(attitude.difference, 3, 3)
HEADING = function(attitude.heading, 3)
RATE, ANGLES = function(rate, 3, 3), function(attitude.pen_angles, 3)
QUATERNION, FROM_MATRIX = (
    function(attitude.quaternion, 3),
    ca.Function("of", [M := ca.SX.sym("M", 3, 3)], [attitude.from_matrix(M)]),
)


@pytest.mark.parametrize("R", ATTITUDES)
def test_matrix_quaternion_and_back(R: Rotation) -> None:
    sigma = sigma_of(R)
    np.testing.assert_allclose(TO_MATRIX(sigma).full(), R.as_matrix(), rtol=0, atol=1e-14)
    w, *xyz = QUATERNION(sigma).full().ravel()
    np.testing.assert_allclose([*xyz, w], R.as_quat(canonical=True), rtol=0, atol=1e-14)
    back = FROM_MATRIX(R.as_matrix()).full().ravel()
    assert np.linalg.norm(back) <= 1 + 1e-15
    np.testing.assert_allclose(TO_MATRIX(back).full(), R.as_matrix(), rtol=0, atol=1e-14)


@pytest.mark.parametrize("R", ATTITUDES)
def test_product_exponential_retract_difference(R: Rotation) -> None:
    sigma = sigma_of(R)
    for other in ATTITUDES:
        found = PRODUCT(sigma, sigma_of(other)).full().ravel()
        assert np.linalg.norm(found) <= 1 + 1e-12
        expected = (R * other).as_matrix()
        np.testing.assert_allclose(TO_MATRIX(found).full(), expected, rtol=0, atol=1e-13)
        d = DIFFERENCE(sigma_of(other), sigma).full().ravel()
        reached = TO_MATRIX(RETRACT(sigma, d)).full()
        np.testing.assert_allclose(reached, other.as_matrix(), rtol=0, atol=1e-12)
    for length in (0.0, 1e-9, 1e-3, 0.00999, 0.01001, 0.5, 3.0):
        turn = length * np.array([0.6, 0.0, -0.8])
        found = EXPONENTIAL(turn)
        expected = Rotation.from_rotvec(turn).as_matrix()
        np.testing.assert_allclose(TO_MATRIX(found).full(), expected, rtol=0, atol=1e-14)


@pytest.mark.parametrize("R", ATTITUDES)
def test_a_tangent_vector_is_a_tilt_and_a_turn_about_the_vertical(R: Rotation) -> None:
    for d in (np.array([0.3, -0.2, 0.4]), np.array([0.0, 0.0, 2.5]), np.array([-1.5, 0.7, -1.0])):
        found, expected = rotation_of(RETRACT(sigma_of(R), d).full()), turn_of(R, d) * R
        assert (found.inv() * expected).magnitude() < 1e-13
        back = DIFFERENCE(expected.as_mrp(), sigma_of(R)).full().ravel()
        np.testing.assert_allclose(back, d, rtol=0, atol=1e-12)


@pytest.mark.parametrize("R", ATTITUDES)
def test_heading_is_the_turn_about_the_vertical_that_leaves_a_level_axis(R: Rotation) -> None:
    N = Rotation.from_matrix(HEADING(sigma_of(R)).full())
    assert (N.inv() * heading_of(R)).magnitude() < 1e-13
    assert np.abs(N.as_rotvec()[:2]).max() < 1e-14
    is_down = 1 + R.as_matrix()[2, 2] <= 0.02
    rest = N.inv() * R * Rotation.from_rotvec([np.pi * is_down, 0, 0])
    assert np.abs(rest.as_rotvec()[2]) < 1e-7


@pytest.mark.parametrize("R", ATTITUDES)
def test_a_turned_pen_is_the_same_pen(R: Rotation) -> None:
    """About the vertical, however far: tangent vectors to a tilt stay what they are."""
    d, other = np.array([0.3, -0.2, 0.0]), Rotation.from_euler("z", 2.0)
    turned = (other * R).as_mrp()
    found = rotation_of(RETRACT(turned, d).full())
    expected = other * rotation_of(RETRACT(sigma_of(R), d).full())
    assert (found.inv() * expected).magnitude() < 1e-13
    straight = DIFFERENCE((other * turn_of(R, d) * R).as_mrp(), sigma_of(R)).full().ravel()
    np.testing.assert_allclose(straight, [*d[:2], 2.0], rtol=0, atol=1e-12)


@pytest.mark.parametrize("R", ATTITUDES)
def test_rates_are_five_point_differences(R: Rotation) -> None:
    sigma, body_rate, h = sigma_of(R), np.array([0.7, -1.1, 0.4]), 1e-3

    def along(t: float) -> Array:
        q = (R * Rotation.from_rotvec(body_rate * t)).as_quat()
        q0 = R.as_quat(canonical=True)
        q = q if q @ q0 > 0 else -q  # the same branch of σ on both sides
        return np.array(q[:3] / (1 + q[3]))

    numeric = (8 * (along(h) - along(-h)) - (along(2 * h) - along(-2 * h))) / (12 * h)
    found = RATE(sigma, body_rate).full().ravel()
    np.testing.assert_allclose(found, numeric, rtol=0, atol=1e-9 * np.abs(found).max())


@pytest.mark.parametrize("angles", RNG.uniform([-3, -1.5, -3], [3, 1.5, 3], (30, 3)))
def test_angles_of_a_pen(angles: Array) -> None:
    B = ca.Function("B", [], [rotation.world_to_body(*(ca.SX(a) for a in angles))])()["o0"].full()
    sigma = FROM_MATRIX(B.T)
    np.testing.assert_allclose(ANGLES(sigma).full().ravel(), angles, rtol=0, atol=1e-12)


def test_upright_and_upside_down_are_regular() -> None:
    """Values and Jacobians of what estimators use are finite and right there."""
    x, d = ca.SX.sym("x", 3), ca.SX.sym("d", 3)
    jacobian = ca.Function("J", [x, d], [ca.jacobian(attitude.retract(x, d), d)])
    for R in ATTITUDES:
        J = jacobian(sigma_of(R), np.zeros(3)).full()
        assert np.isfinite(J).all()
        assert np.linalg.cond(J) < 1 + 1e-9  # conformal: every attitude is like any other
