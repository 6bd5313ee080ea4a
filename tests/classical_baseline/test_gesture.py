"""The path of a gesture, by itself and at the end of the whole chain."""

from __future__ import annotations

import numpy as np
import pytest

from classical_baseline.attitude import direction_cosines
from classical_baseline.differential import centre_specific_force, differential_solution
from classical_baseline.gesture import gesture_path
from classical_baseline.gyro_free import integrate_rate
from models.errors import InputError
from tests.classical_baseline.gestures import ATTITUDE, HALF_DISTANCE_M, gesture, order, times
from tests.references.gyro_free import GRAVITY

C = np.asarray(ATTITUDE.inv().as_matrix())


def felt(acceleration: np.ndarray) -> np.ndarray:
    return (acceleration + np.array([0.0, 0.0, GRAVITY])) @ C.T


def test_at_rest_it_stays() -> None:
    n = 300
    path = gesture_path(np.tile(C, (n, 1, 1)), felt(np.zeros((n, 3))), 0.005, GRAVITY)
    for values in (path.acceleration, path.velocity, path.position):
        assert np.abs(values).max() < 1e-13
    assert path.length_m < 1e-13


def test_an_acceleration_that_grows_evenly_is_exact() -> None:
    t = times(0.1)[:, None]
    slope, first = np.array([1.0, -2.0, 0.5]), np.array([0.3, 0.0, -1.0])
    path = gesture_path(np.tile(C, (len(t), 1, 1)), felt(first + slope * t), 0.1, GRAVITY)
    np.testing.assert_allclose(path.velocity, first * t + slope * t**2 / 2, atol=1e-12)
    np.testing.assert_allclose(path.position, first * t**2 / 2 + slope * t**3 / 6, atol=1e-12)


def test_it_is_of_second_order() -> None:
    errors = []
    for step in (0.04, 0.02, 0.01):
        t = times(step)[:, None]
        path = gesture_path(
            np.tile(C, (len(t), 1, 1)),
            felt(np.array([9.0, 0.0, 0.0]) * np.sin(3 * t)),
            step,
            GRAVITY,
        )
        errors.append(float(np.abs(path.position[:, 0] - (3 * t - np.sin(3 * t))[:, 0]).max()))
    np.testing.assert_allclose(order(errors), 2.0, atol=0.05)


def test_a_tilt_error_falls_with_gravity() -> None:
    tilt, n = 0.01, 401
    tilted = np.tile(C @ np.array([[1, 0, tilt], [0, 1, 0], [-tilt, 0, 1]]), (n, 1, 1))
    path = gesture_path(tilted, felt(np.zeros((n, 3))), 0.005, GRAVITY)
    assert path.position[-1, 0] == pytest.approx(-GRAVITY * tilt * 2.0**2 / 2, rel=1e-3)


def test_the_whole_chain_follows_a_rod_moved_by_torque_and_force() -> None:
    errors: dict[str, list[float]] = {"C": [], "path": []}
    for step in (0.01, 0.005):
        motion = gesture(step)
        f1, f2 = motion.f1, motion.f2
        f1[0] = f2[0] = C @ [0.0, 0.0, GRAVITY]
        rate = integrate_rate(differential_solution(f1, f2, HALF_DISTANCE_M), step).rate
        cosines = direction_cosines(rate, step, C)
        path = gesture_path(cosines, centre_specific_force(f1, f2), step, GRAVITY)
        errors["C"].append(float(np.abs(cosines - motion.C).max()))
        errors["path"].append(float(np.abs(path.position - motion.position).max()))
    for found in errors.values():
        np.testing.assert_allclose(order(found), 2.0, atol=0.1)
        assert found[-1] < 1e-3
    assert path.length_m > 0.5


def test_bad_input_is_refused() -> None:
    with pytest.raises(InputError, match=r"shape \(3, 3, 3\) for 2 specific forces"):
        gesture_path(np.zeros((3, 3, 3)), np.zeros((2, 3)), 0.01, GRAVITY)
    with pytest.raises(InputError, match="at least one"):
        gesture_path(np.zeros((0, 3, 3)), np.zeros((0, 3)), 0.01, GRAVITY)
