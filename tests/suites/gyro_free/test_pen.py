"""The pen model is the same two accelerometers, in other axes."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from models.free_kinematics import attitude_of
from suites.gyro_free.cases import CASES
from suites.gyro_free.gesture import gesture, start_cosines
from suites.gyro_free.pen import (
    LOWER,
    NO_ROLL_SENSOR,
    UPPER,
    TwoAccelerometers,
    angle_rates,
    pen_angles,
    rates_and_cosines,
    start,
    two_accelerometers,
)
from suites.gyro_free.readings import exact_readings
from tests.references.pen_readings import gyroscope, world_to_body

PEN = TwoAccelerometers(0.04, 1e-4, 0.0)
TO_PEN = np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]])


def test_axes_are_those_of_the_textbook_pen_turned_round() -> None:
    states = np.random.default_rng(0).uniform(-1, 1, (20, 15))
    _, C = rates_and_cosines(states, 5)
    np.testing.assert_allclose(TO_PEN @ C, world_to_body(states), atol=1e-12)
    np.testing.assert_allclose(C[:, 0, 2], np.sin(states[:, 4]), atol=1e-12)


def test_angles_of_an_attitude() -> None:
    for elevation in (0.5, -0.3):
        found = pen_angles(start_cosines(elevation))
        np.testing.assert_allclose(found, [0, elevation, 0], atol=1e-12)
    for matrix in Rotation.random(20, random_state=1).as_matrix():
        states = np.zeros((1, 18))
        states[0, 3:6] = attitude_of(*pen_angles(matrix))
        np.testing.assert_allclose(rates_and_cosines(states, 6)[1][0], matrix, atol=1e-9)


def test_a_start_is_what_was_told() -> None:
    _, model = two_accelerometers(PEN)
    C, rate = Rotation.random(random_state=4).as_matrix(), np.array([0.4, -1.0, 2.0])
    prior = start(model, C, rate)
    found_rate, found_C = rates_and_cosines(prior.mean[None], 6)
    np.testing.assert_allclose(found_C[0], C, atol=1e-9)
    np.testing.assert_allclose(found_rate[0], rate, atol=1e-9)
    np.testing.assert_array_equal(prior.covariance, model.prior.covariance)
    resting = start(model, C).mean
    assert not resting[6:].any()


def test_the_rates_of_the_angles_are_those_of_the_textbook_pen() -> None:
    states = np.random.default_rng(6).uniform(-1, 1, (20, 15))
    for x, rate in zip(states, gyroscope(states), strict=True):
        found = angle_rates(np.array([x[3], x[4], 0.0]), rate)
        np.testing.assert_allclose(found, [x[8], x[9], 0.0], atol=1e-12)
    # About the pen's own axis, the other two rates turn with it.
    spun = Rotation.from_rotvec([0, 0, -0.7]).apply(gyroscope(states))
    spun[:, 2] += 0.3
    for x, rate in zip(states, spun, strict=True):
        found = angle_rates(np.array([x[3], x[4], 0.7]), rate)
        np.testing.assert_allclose(found, [x[8], x[9], 0.3], atol=1e-12)


def test_a_start_of_a_pen_without_spin_is_what_was_told() -> None:
    _, model = two_accelerometers(TwoAccelerometers(0.04, 1e-4, 0.0, degrees_of_freedom=5))
    x = np.random.default_rng(7).uniform(-1, 1, (1, 15))
    rate, C = rates_and_cosines(x, 5)
    np.testing.assert_allclose(start(model, C[0], rate[0]).mean[[3, 4, 8, 9]], x[0, [3, 4, 8, 9]])


def test_sensors_read_what_the_differential_equations_take() -> None:
    """Both readings of the model along a gesture of a pen without spin, angles differentiated."""
    m = gesture(CASES["roll"].gesture, 2)
    angles = np.array([pen_angles(C)[:2] for C in m.C])
    dt = m.time_s[1]
    _, model = two_accelerometers(TwoAccelerometers(0.04, 1e-4, 0.0, degrees_of_freedom=5))
    k = np.arange(2, len(m.time_s) - 2)

    def slopes(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        around = [values[k + i] for i in (-2, -1, 0, 1, 2)]
        first = np.tensordot([1 / 12, -2 / 3, 0, 2 / 3, -1 / 12], around, axes=1) / dt
        second = np.tensordot([-1 / 12, 4 / 3, -5 / 2, 4 / 3, -1 / 12], around, axes=1) / dt**2
        return first, second

    rate, acceleration = slopes(angles)
    velocity, _ = slopes(m.position)
    x = np.hstack([m.position[k], angles[k], velocity, rate, m.acceleration[k], acceleration])
    for name, expected in zip((LOWER, UPPER), exact_readings(m, 0.04), strict=True):
        found = model.sensor(name).h(x.T).full().T
        np.testing.assert_allclose(found, expected[k], atol=1e-4)
    found_rate, _ = rates_and_cosines(x, 5)
    np.testing.assert_allclose(found_rate, m.rate[k], atol=1e-5)


@pytest.mark.parametrize(("bias", "states"), [(0.0, 18), (1e-3, 24)])
def test_what_is_told_is_in_the_model(bias: float, states: int) -> None:
    pen = TwoAccelerometers(0.04, 2e-4, bias, no_roll=True)
    _, model = two_accelerometers(pen)
    assert model.n_x == states
    assert [sensor.name for sensor in model.sensors] == [LOWER, UPPER, NO_ROLL_SENSOR]
    np.testing.assert_allclose(model.sensor(LOWER).noise_std, 2e-4, rtol=1e-9)
    np.testing.assert_allclose(model.sensor(NO_ROLL_SENSOR).noise_std, np.radians(1), rtol=1e-9)
    x = np.zeros(states)
    x[3:6], x[9:12] = attitude_of(0.0, 0.6, 0.0), (0.1, 0.7, 0.2)
    roll = float(model.sensor(NO_ROLL_SENSOR).h(x))
    assert roll == pytest.approx(0.2)
    assert rates_and_cosines(x[None], 6)[0][0, 0] == pytest.approx(roll)
