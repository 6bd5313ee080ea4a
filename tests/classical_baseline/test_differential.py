"""The differential solution is what Newton and Euler make two accelerometers read."""

from __future__ import annotations

import numpy as np
import pytest

from classical_baseline.differential import (
    angular_acceleration_without_roll,
    centre_specific_force,
    differential_solution,
)
from models.errors import InputError
from tests.classical_baseline.gestures import HALF_DISTANCE_M, gesture
from tests.references.gyro_free import GRAVITY


def test_it_is_the_rotation_of_a_rod_moved_by_a_torque() -> None:
    motion = gesture(0.01)
    inner = slice(1, None)  # the second difference does not reach before the start
    c = differential_solution(motion.f1, motion.f2, HALF_DISTANCE_M)[inner]
    rate = motion.rate[inner]
    np.testing.assert_allclose(c[:, 0], -(rate[:, 1] ** 2) - rate[:, 2] ** 2, atol=1e-5)
    t = motion.time_s[inner]
    expected = np.column_stack([0 * t, 8 * np.sin(5 * t), 6 * np.sin(7 * t + 0.5) * np.tanh(5 * t)])
    np.testing.assert_allclose(angular_acceleration_without_roll(c), expected, atol=1e-5)


def test_roll_enters_as_the_equation_says() -> None:
    rng = np.random.default_rng(1)
    w, w_dot, common = rng.standard_normal((3, 20, 3))
    f1, f2 = (
        common + np.cross(w_dot, L) + np.cross(w, np.cross(w, L))
        for L in (np.array([-0.1, 0, 0]), np.array([0.1, 0, 0]))
    )
    wx, wy, wz = w.T
    expected = [-(wy**2 + wz**2), w_dot[:, 2] + wx * wy, -w_dot[:, 1] + wx * wz]
    np.testing.assert_allclose(differential_solution(f1, f2, 0.1).T, expected, atol=1e-12)
    np.testing.assert_allclose(centre_specific_force(f1, f2), common, atol=1e-12)


def test_the_mean_is_what_the_centre_of_mass_feels() -> None:
    motion = gesture(0.01)
    t = motion.time_s[1:]
    a = np.column_stack([2 * np.sin(3 * t), np.sin(6 * t), -0.5 * np.sin(4 * t) + GRAVITY])
    expected = np.einsum("kij,kj->ki", motion.C[1:], a)
    found = centre_specific_force(motion.f1, motion.f2)[1:]
    np.testing.assert_allclose(found, expected, atol=1e-5)


def test_at_rest_there_is_nothing() -> None:
    f = np.tile([1.0, -2.0, 9.0], (5, 1))
    assert not differential_solution(f, f, 0.04).any()
    np.testing.assert_array_equal(centre_specific_force(f, f), f)


def test_bad_input_is_refused() -> None:
    f = np.zeros((4, 3))
    with pytest.raises(InputError, match=r"shapes \(4, 3\) and \(3, 3\)"):
        differential_solution(f, f[1:], 0.04)
    with pytest.raises(InputError, match=r"shapes \(4, 2\)"):
        centre_specific_force(f[:, :2], f[:, :2])
    for length in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(InputError, match="expected a positive length"):
            differential_solution(f, f, length)
