"""Attitudes against SciPy's rotations and five-point differences."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from models import attitude, rotation
from models.arrays import Array

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
RATE, ANGLES = function(attitude.rate, 3, 3), function(attitude.pen_angles, 3)
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
def test_a_tangent_vector_is_a_rotation_vector_to_second_order(R: Rotation) -> None:
    """The error of a turn grows with its third power: the order of convergence, measured."""
    sigma, axis = sigma_of(R), np.array([2.0, -1.0, 2.0]) / 3

    def error(length: float) -> float:
        found = RETRACT(sigma, length * axis).full()
        wrong = rotation_of(found) * R.inv() * Rotation.from_rotvec(-length * axis)
        return float(np.linalg.norm(wrong.as_rotvec()))

    order = np.log2(error(0.2) / error(0.1))
    assert order == pytest.approx(3, abs=0.05)


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
