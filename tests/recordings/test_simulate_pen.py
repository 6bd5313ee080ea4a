"""The simulated recording and the errors measured on it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
import pytest

from estimation.estimator import run
from estimation.recording import Recording
from models.arrays import Array
from models.errors import InputError
from models.motions import motion_named, motions
from models.pen import pen_model
from models.pen_file import load_pen
from pen_mhe.errors import root_mean_square, state_errors
from pen_mhe.estimators import create_estimator
from recordings.motion_list import motion_names
from recordings.simulate_pen import simulate, simulate_model

SENSORS = ("accel", "gyro", "camera")
pytestmark = pytest.mark.usefixtures("interpreted")


@pytest.fixture(scope="module")
def recording() -> Recording:
    return simulate(load_pen("reference"), SENSORS, motion="turn", duration_s=2.0, seed=5)


def test_noise_has_the_stated_size(recording: Recording) -> None:
    model = pen_model(load_pen("reference"), SENSORS)
    assert recording.truth is not None
    for sensor in model.measured_sensors:
        times, values = recording.sensor(sensor.name)
        states = recording.truth.states(model.state_names, times)
        residuals = np.array(
            [np.asarray(sensor.residual(y, x)).ravel() for y, x in zip(values, states, strict=True)]
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


def of_truth(recording: Recording, names: Sequence[str], time_s: Array) -> Array:
    assert recording.truth is not None
    return recording.truth.states(names, time_s)


@pytest.mark.parametrize("motion", [*motions(), "model"])
def test_every_motion_is_recorded(motion: str) -> None:
    played = simulate(load_pen("reference"), SENSORS, motion=motion, duration_s=0.2, seed=1)
    assert played.name == f"{motion} (simulated)"
    times = np.arange(21) / 100
    np.testing.assert_allclose(played.sensor("accel")[0], times, rtol=0, atol=1e-9)
    assert np.isfinite(of_truth(played, ["tip_x_m", "spin_rad"], times)).all()


@pytest.mark.parametrize("stamps", ["capture", "arrival"])
def test_stamps(stamps: Literal["capture", "arrival"]) -> None:
    """The same readings; those of the camera 45 ms later, with the truth there too."""
    pen = load_pen("reference")
    captured = simulate(pen, SENSORS, motion="turn", duration_s=1.0, seed=5)
    recording = simulate(pen, SENSORS, motion="turn", duration_s=1.0, seed=5, stamps=stamps)
    delay = {"capture": 0.0, "arrival": 0.045}[stamps]
    assert pen.sensors["camera"].delay_s == 0.045
    for name, later in (("accel", 0.0), ("gyro", 0.0), ("camera", delay)):
        (times, values), (at, expected) = recording.sensor(name), captured.sensor(name)
        np.testing.assert_allclose(times - at, later, rtol=0, atol=1e-9)
        np.testing.assert_array_equal(values, expected)
    assert list(recording.arrivals) == ["camera"]
    np.testing.assert_allclose(
        recording.select(["camera"]).arrivals["camera"],
        captured.sensor("camera")[0] + 0.045,
        rtol=0,
        atol=1e-9,
    )
    names = pen_model(pen, SENSORS).state_names
    assert np.isfinite(of_truth(recording, names, recording.time_s)).all()
    np.testing.assert_array_equal(
        of_truth(recording, names, captured.sensor("accel")[0]),
        of_truth(captured, names, captured.sensor("accel")[0]),
    )


@pytest.mark.cover
@pytest.mark.parametrize("motion", ["turn", "handwriting"])
@pytest.mark.parametrize("alone", ["accel", "gyro", "camera"])
def test_a_further_sensor_changes_nothing_else(motion: str, alone: str) -> None:
    """Neither a sensor's readings nor the truth, its biases included; not even a digit."""
    pen = load_pen("reference")
    few = simulate(pen, [alone], motion=motion, duration_s=1.0, seed=3)
    for others in (SENSORS, (*SENSORS[::-1], "accel_lower")):
        many = simulate(pen, others, motion=motion, duration_s=1.0, seed=3)
        times, values = few.sensor(alone)
        np.testing.assert_array_equal(many.sensor(alone)[0], times)
        np.testing.assert_array_equal(many.sensor(alone)[1], values)
        assert few.truth is not None
        np.testing.assert_array_equal(of_truth(many, few.truth.names, times), few.truth.values)


def test_sensors_of_a_kind_have_noise_of_their_own() -> None:
    pen = load_pen("reference")
    both = simulate(pen, ["accel_lower", "accel_upper"], motion="still", duration_s=2.0, seed=3)
    lower, upper = (both.sensor(name)[1] for name in ("accel_lower", "accel_upper"))
    correlation = np.mean((lower - lower.mean(0)) * (upper - upper.mean(0)), axis=0)
    scale = lower.std(axis=0) * upper.std(axis=0)
    assert np.abs(correlation / scale).max() < 4 / np.sqrt(len(lower))


def test_a_drawn_recording_is_the_models() -> None:
    """The truth of the motion `model` makes one step after the other with unit noises."""
    model = pen_model(load_pen("reference"), SENSORS)
    named = simulate(load_pen("reference"), SENSORS, motion="model", duration_s=2.0, seed=3)
    drawn = simulate_model(model, duration_s=2.0, seed=3)
    assert drawn.truth is not None
    time_s = drawn.truth.time_s
    states = drawn.truth.states(model.state_names, time_s)
    np.testing.assert_array_equal(of_truth(named, model.state_names, named.time_s), states)
    zero, squared = np.zeros(model.n_w), 0.0
    for k, dt in enumerate(np.diff(time_s)):
        predicted = model.f(states[k], zero, dt).full().ravel()
        G = model.f.jacobian()(states[k], zero, dt, predicted)[1].full()
        squared += np.sum(np.linalg.solve(G, states[k + 1] - predicted) ** 2)
    n = model.n_w * (len(time_s) - 1)
    assert abs(squared / n - 1) < 4 * np.sqrt(2 / n)


def test_speed_and_a_motion_of_ones_own() -> None:
    pen = load_pen("reference")
    names = ["tip_x_m", "tip_x_velocity_m_s", "tip_x_acceleration_m_s2"]
    times = np.arange(0, 51) / 100
    slow = simulate(pen, ["accel"], motion=motion_named("turn"), duration_s=1.0, seed=3)
    fast = simulate(pen, ["accel"], motion="turn", duration_s=0.5, seed=3, speed=2.0)
    assert slow.name == "minimum_jerk (simulated)"
    expected = of_truth(slow, names, 2 * times) * [1, 2, 4]
    np.testing.assert_allclose(of_truth(fast, names, times), expected, rtol=0, atol=1e-14)


def test_motion_names_are_the_tables_and_the_model() -> None:
    assert motion_names() == (*motions(), "model")


def test_the_same_seed_gives_the_same_recording(recording: Recording) -> None:
    again = simulate(load_pen("reference"), SENSORS, motion="turn", duration_s=2.0, seed=5)
    other = simulate(load_pen("reference"), SENSORS, motion="turn", duration_s=2.0, seed=6)
    np.testing.assert_array_equal(recording.readings["gyro"], again.readings["gyro"])
    assert not np.allclose(recording.sensor("gyro")[1], other.sensor("gyro")[1])


def test_errors_are_estimate_minus_truth(recording: Recording) -> None:
    model = pen_model(load_pen("reference"), SENSORS)
    history = run(create_estimator("ekf", model), recording)
    assert recording.truth is not None
    errors = state_errors(model, history, recording.truth)
    tip = history.column("tip_x_m")[50:] - recording.truth.values[50:, 0]
    np.testing.assert_allclose(errors[50:, 0], tip, atol=1e-15)
    assert np.sqrt(np.mean(tip[100:] ** 2)) < 1e-3  # the camera's noise is 0.3 mm a frame
    rms = root_mean_square(history.names, errors[50:], {"tip_mm": (("tip_x_m",), 1e3)})
    assert rms["tip_mm"] == pytest.approx(1e3 * np.sqrt(np.mean(tip**2)), rel=1e-12)


def test_bad_input_is_refused() -> None:
    pen = load_pen("reference")
    with pytest.raises(InputError, match=r"motion loop is unknown, expected one of turn.*, model"):
        simulate(pen, SENSORS, motion="loop")
    with pytest.raises(InputError, match="speed is 2 for the motion model, expected 1"):
        simulate(pen, SENSORS, motion="model", speed=2)
    with pytest.raises(InputError, match="speed is 0, expected a positive factor"):
        simulate(pen, SENSORS, motion="turn", speed=0)
    with pytest.raises(InputError, match="stamps is sent, expected one of capture, arrival"):
        simulate(pen, SENSORS, stamps="sent")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="duration is -1 s, expected a positive time"):
        simulate(pen, SENSORS, motion="turn", duration_s=-1)
    with pytest.raises(InputError, match="sensor contact has no rate_hz"):
        simulate(load_pen("dpoint"), ["contact"], motion="turn")
    with pytest.raises(InputError, match="no sensor with readings"):
        simulate(pen, ["area"], motion="turn")
    with pytest.raises(InputError, match=r"pen file nowhere does not exist.*dpoint, reference"):
        load_pen("nowhere")
