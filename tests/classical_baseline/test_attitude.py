"""Direction cosines: exact at a constant rate, second order otherwise, always a rotation."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from classical_baseline.attitude import direction_cosines, orthonormal
from models.errors import InputError
from tests.classical_baseline.gestures import ATTITUDE, order, times
from tests.references.direction_cosines import at_constant_rate, attitudes

START = np.asarray(ATTITUDE.inv().as_matrix())


def rate(t: float) -> np.ndarray:
    return np.array([0.5 * np.cos(3 * t), 2 * np.sin(4 * t), 3 * np.sin(5 * t + 1)])


@pytest.mark.parametrize(
    "constant",
    [[0.0, 2.0, 0.0], [0.3, -1.0, 2.0], [0.0, 0.0, 0.0], [1e-9, 0.0, 3e-9], [50.0, 9, 0]],
)
def test_a_constant_rate_is_exact(constant: list[float]) -> None:
    C = direction_cosines(np.tile(constant, (401, 1)), 0.005, START)
    expected = at_constant_rate(np.array(constant), 2.0, START)
    np.testing.assert_allclose(C[-1], expected, atol=1e-12)


def test_the_sign_turns_the_world_not_the_body() -> None:
    """A quarter turn about body z: what was ahead of the body now is to its right."""
    C = direction_cosines(np.tile([0.0, 0.0, np.pi / 2], (101, 1)), 0.01, np.eye(3))
    np.testing.assert_allclose(C[-1] @ [1.0, 0.0, 0.0], [0.0, -1.0, 0.0], atol=1e-12)


def test_it_is_of_second_order() -> None:
    errors = []
    for step in (0.02, 0.01, 0.005):
        t = times(step)
        found = direction_cosines(np.array([rate(s) for s in t]), step, START)
        errors.append(float(np.abs(found - attitudes(rate, t, START)).max()))
    np.testing.assert_allclose(order(errors), 2.0, atol=0.05)


def test_it_stays_orthonormal() -> None:
    rates = np.random.default_rng(0).standard_normal((20_000, 3)) * 10
    C = direction_cosines(rates, 0.01, START)
    away = np.abs(np.einsum("kij,klj->kil", C, C) - np.eye(3)).max(axis=(1, 2))
    assert away.max() < 1e-14
    np.testing.assert_allclose(np.linalg.det(C[-1]), 1.0, atol=1e-14)


def test_a_matrix_that_is_off_goes_to_the_next_rotation() -> None:
    left = []
    for size in (1e-2, 1e-3):
        off = START + size * np.random.default_rng(1).standard_normal((3, 3))
        u, _, vt = np.linalg.svd(off)
        left.append(np.abs(orthonormal(off) - u @ vt).max())
    assert left[0] / left[1] == pytest.approx(100, rel=0.2)
    np.testing.assert_allclose(orthonormal(START), START, atol=1e-15)


def test_edges_and_bad_input() -> None:
    assert direction_cosines(np.zeros((0, 3)), 0.01, START).shape == (0, 3, 3)
    np.testing.assert_array_equal(direction_cosines(np.ones((1, 3)), 0.01, START), START[None])
    for start in (2 * START, np.zeros((3, 3)), np.eye(2), np.full((3, 3), np.nan), -START):
        with pytest.raises(InputError, match="no rotation"):
            direction_cosines(np.zeros((3, 3)), 0.01, start)
    with pytest.raises(InputError, match=r"shape \(3, 2\)"):
        direction_cosines(np.zeros((3, 2)), 0.01, START)
    assert Rotation.from_matrix(START).magnitude() > 0.1  # a start that could be lost
