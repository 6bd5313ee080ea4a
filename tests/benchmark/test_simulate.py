"""The simulated recording and the errors measured on it."""

from __future__ import annotations

import numpy as np
import pytest

from benchmark.metrics import root_mean_square, state_errors
from benchmark.registry import create_estimator, find_pen
from benchmark.simulate import simulate_recording
from estimation.estimator import run
from estimation.recording import Recording
from models.errors import InputError
from models.motions import minimum_jerk, stroke, strokes
from models.pen import pen_model

SENSORS = ("accel", "gyro", "camera")
pytestmark = pytest.mark.usefixtures("interpreted")


@pytest.fixture(scope="module")
def recording() -> Recording:
    return simulate_recording(find_pen("reference"), SENSORS, "turn", 2.0, seed=5)


@pytest.mark.parametrize("name", strokes())
def test_derivatives_of_motions_are_exact(name: str) -> None:
    h, t = 1e-4, np.linspace(0.31, 2.79, 400)
    q = {k: minimum_jerk(name, stroke(name), t + k * h).q for k in (-2, -1, 0, 1, 2)}
    motion = minimum_jerk(name, stroke(name), t)
    first = (q[-2] - 8 * q[-1] + 8 * q[1] - q[2]) / (12 * h)
    second = (-q[-2] + 16 * q[-1] - 30 * q[0] + 16 * q[1] - q[2]) / (12 * h**2)
    # Jerk jumps in the via points, where differences straddle two segments.
    knots = np.array(stroke(name).time_s)
    inside = np.abs(t[:, None] - knots).min(axis=1) > 3 * h
    np.testing.assert_allclose(motion.q_dot[inside], first[inside], atol=1e-8)
    np.testing.assert_allclose(motion.q_ddot[inside], second[inside], atol=1e-5)


def test_noise_has_the_stated_size(recording: Recording) -> None:
    model = pen_model(find_pen("reference"), SENSORS)
    assert recording.truth is not None
    for sensor in model.sensors:
        times, values = recording.sensor(sensor.name)
        rows = np.searchsorted(recording.truth.time_s, times)
        residuals = np.array(
            [
                np.asarray(sensor.residual(y, x)).ravel()
                for y, x in zip(values, recording.truth.values[rows], strict=True)
            ]
        )
        # Standard error of a variance from n samples: √(2/n); 4 of them, fixed seed.
        n = residuals.size
        ratio = np.mean((residuals / sensor.noise_std) ** 2)
        assert abs(ratio - 1) < 4 * np.sqrt(2 / n)


def test_every_sensor_keeps_its_own_instants(recording: Recording) -> None:
    times, _ = recording.sensor("camera")
    np.testing.assert_allclose(times, np.arange(61) / 30, atol=1e-9)
    times, _ = recording.sensor("gyro")
    np.testing.assert_allclose(times, np.arange(201) / 100, atol=1e-9)


def test_the_same_seed_gives_the_same_recording(recording: Recording) -> None:
    again = simulate_recording(find_pen("reference"), SENSORS, "turn", 2.0, seed=5)
    other = simulate_recording(find_pen("reference"), SENSORS, "turn", 2.0, seed=6)
    np.testing.assert_array_equal(recording.readings["gyro"], again.readings["gyro"])
    assert not np.allclose(recording.sensor("gyro")[1], other.sensor("gyro")[1])


def test_errors_are_estimate_minus_truth(recording: Recording) -> None:
    model = pen_model(find_pen("reference"), SENSORS)
    history = run(create_estimator("ekf", model), recording)
    assert recording.truth is not None
    errors = state_errors(model, history, recording.truth)
    tip = history.mean[50:, 0] - recording.truth.values[50:, 0]
    np.testing.assert_allclose(errors[50:, 0], tip, atol=1e-15)
    assert np.sqrt(np.mean(tip[100:] ** 2)) < 1e-3  # the camera's noise is 0.3 mm a frame
    rms = root_mean_square(model, errors[50:], {"tip_mm": (("tip_x_m",), 1e3)})
    assert rms["tip_mm"] == pytest.approx(1e3 * np.sqrt(np.mean(tip**2)), rel=1e-12)


def test_bad_input_is_refused() -> None:
    pen = find_pen("reference")
    with pytest.raises(InputError, match="stroke loop is unknown, expected one of turn"):
        simulate_recording(pen, SENSORS, "loop")
    with pytest.raises(InputError, match="duration is -1 s, expected a positive time"):
        simulate_recording(pen, SENSORS, "turn", -1)
    with pytest.raises(InputError, match="sensor contact has no rate_hz"):
        simulate_recording(find_pen("dpoint"), ["contact"], "turn")
    with pytest.raises(InputError, match="no sensor with readings"):
        simulate_recording(pen, ["area"], "turn")
    with pytest.raises(InputError, match=r"pen file nowhere does not exist.*dpoint, reference"):
        find_pen("nowhere")
