"""The gesture's truth is consistent with itself, and its readings with the truth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from suites.gyro_free.cases import CASES
from suites.gyro_free.gesture import GestureConfig, gesture
from suites.gyro_free.pen import pen_angles
from suites.gyro_free.readings import G_M_S2, Errors, exact_readings, readings

GESTURES = {name: CASES[name].gesture for name in ("test case", "roll", "one plane", "fast")}
FINE = 0.001


@pytest.fixture(params=GESTURES)
def config(request: pytest.FixtureRequest) -> GestureConfig:
    return replace(GESTURES[request.param], step_s=FINE)


def test_attitude_rate_and_its_derivative_belong_together(config: GestureConfig) -> None:
    m = gesture(config, 3)
    x, y, z = m.rate.T
    zero = np.zeros_like(x)
    skew = np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]).transpose(2, 0, 1)
    slope = (m.C[2:] - m.C[:-2]) / (2 * FINE)
    np.testing.assert_allclose(slope, -(skew @ m.C)[1:-1], atol=2e-4)
    slope = (m.rate[2:, 1:] - m.rate[:-2, 1:]) / (2 * FINE)
    np.testing.assert_allclose(slope, m.rate_derivative[1:-1, 1:], atol=2e-3)
    np.testing.assert_allclose(np.einsum("kij,klj->kil", m.C, m.C)[-1], np.eye(3), atol=1e-9)


def test_it_rests_at_both_ends(config: GestureConfig) -> None:
    m = gesture(config, 1)
    for values in (m.rate, m.acceleration):
        np.testing.assert_allclose(values[[0, -1]], 0, atol=1e-10)
    np.testing.assert_allclose(m.position[[0, -1]], 0, atol=1e-12)
    speed = np.linalg.norm(np.diff(m.position, axis=0), axis=1) / FINE
    assert speed[0] < 1e-3 < 0.3 < speed.max()
    assert np.abs(m.rate).max() > 0.4


def test_roll_is_what_it_says() -> None:
    for name in ("test case", "one plane", "fast"):
        assert not gesture(GESTURES[name], 2).rate[:, 0].any()
    rolling = gesture(GESTURES["roll"], 2)
    assert np.abs(rolling.rate[:, 0]).max() > 0.2
    spins = np.array([pen_angles(C)[2] for C in rolling.C])
    np.testing.assert_allclose(spins, 0, atol=1e-8)
    assert np.abs([pen_angles(C)[2] for C in gesture(GESTURES["test case"], 2).C]).max() > 0.05


def test_in_one_plane_the_rate_keeps_its_direction() -> None:
    def turning(name: str) -> float:
        m = gesture(GESTURES[name], 4)
        wy, wz = m.rate[:, 1:].T
        return float(np.abs(wy * m.rate_derivative[:, 2] - wz * m.rate_derivative[:, 1]).max())

    assert turning("one plane") < 1e-12
    assert turning("test case") > 5


def test_a_seed_is_a_gesture() -> None:
    config = GestureConfig()
    assert gesture(config, 0) is gesture(config, 0)
    assert np.abs(gesture(config, 0).rate - gesture(config, 1).rate).max() > 0.1


def test_accelerometers_read_the_second_difference_of_their_places(config: GestureConfig) -> None:
    m, half = gesture(config, 5), 0.04
    for f, x in zip(exact_readings(m, half), (-half, half), strict=True):
        place = m.position + x * m.C[:, 0]
        second = (place[2:] - 2 * place[1:-1] + place[:-2]) / FINE**2
        felt = np.einsum("kij,kj->ki", m.C[1:-1], second + np.array([0.0, 0.0, 9.81]))
        # Second differences of a solution to 1e-11 are good to a few 1e-5, and blur by FINE².
        np.testing.assert_allclose(f[1:-1], felt, atol=2e-3)


def test_errors_are_those_of_the_difference() -> None:
    m = gesture(GestureConfig(), 0)
    exact1, exact2 = exact_readings(m, 0.04)
    for seed in range(4):
        f1, f2 = readings(m, 0.04, Errors(), seed)
        error1, error2 = f1 - exact1, f2 - exact2
        difference = error2 - error1
        np.testing.assert_allclose(np.abs(difference.mean(axis=0)), 1e-4 * G_M_S2, rtol=0.05)
        np.testing.assert_allclose(difference.std(axis=0), 1e-5 * G_M_S2, rtol=0.15)
        sizes = np.abs([error1.mean(axis=0), error2.mean(axis=0)])
        np.testing.assert_allclose(sizes.min(axis=0), 0, atol=2e-6 * G_M_S2)


def test_noise_is_the_same_draw_at_every_size_and_distance() -> None:
    m = gesture(GestureConfig(), 0)
    noises = []
    for size, half in ((1e-4, 0.01), (2e-4, 0.04)):
        errors = Errors(bias_m_s2=0.0, noise_m_s2=size)
        noises.append(readings(m, half, errors, 7)[1] - exact_readings(m, half)[1])
    np.testing.assert_allclose(noises[1], 2 * noises[0], atol=1e-13)
    clean = readings(m, 0.04, Errors(0.0, 0.0), 7)
    np.testing.assert_array_equal(clean, exact_readings(m, 0.04))
