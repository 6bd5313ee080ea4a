"""What sensors make of the truth: noise, quantiser, range, lost samples, against theory."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.stats import binom, chi2

from models.motions import sample_motion
from models.noisy_readings import noisy_readings
from models.pen import pen_model
from models.sensor_kinds.accelerometer import Accelerometer
from models.sensor_kinds.gyroscope import Gyroscope
from models.sensor_kinds.pose_camera import PoseCamera
from models.sensor_model import SensorModel
from models.simulation import sample_times, simulate_readings, true_states
from tests.models.pens import Array, pen, random_rotation
from tests.references.allan import allan_variance, relative_error, white_kernel

RATE_HZ, DURATION_S, SEED = 1000.0, 4.0, 17
PLACE = {
    "position_m": (0.01, -0.02, 0.1),
    "sensor_to_body": random_rotation(np.random.default_rng(1)),
}
ACCEL_STD = 0.004 * np.sqrt(np.pi / 2 * 50.0)
SENSORS: dict[str, tuple[type, dict[str, Any], list[float]]] = {
    "accelerometer": (
        Accelerometer,
        {"noise_density_m_s2_per_sqrt_hz": 0.004, "bandwidth_hz": 50.0},
        [ACCEL_STD] * 3,
    ),
    "gyroscope": (
        Gyroscope,
        {"noise_density_rad_s_per_sqrt_hz": 0.001, "bandwidth_hz": 80.0},
        [0.001 * np.sqrt(np.pi / 2 * 80.0)] * 3,
    ),
    "pose_camera": (
        PoseCamera,
        {"position_std_m": 2e-4, "orientation_std_rad": 0.02},
        [2e-4] * 3 + [0.02] * 3,
    ),
}
"""Kind → class, its noise, and the standard deviations that this must give."""
EXTREME = 1e-5
"""Probability that a right simulator falls out of an interval."""


@cache
def simulated(
    kind: str, degrees_of_freedom: int = 6, **changes: Any
) -> tuple[SensorModel, Array, Array]:
    """Return a sensor, its readings along handwriting and the true states at them."""
    sensor, noise, _ = SENSORS[kind]
    config = pen(degrees_of_freedom, {"it": sensor(rate_hz=RATE_HZ, **PLACE, **noise, **changes)})
    model = pen_model(config)
    times = sample_times(model, DURATION_S)
    states = true_states(model, sample_motion("handwriting", times["it"], seed=SEED), SEED)
    readings = simulate_readings(model, times, times["it"], states, SEED)
    return model.sensor("it"), readings.sensors["it"][1], states


def residuals(sensor: SensorModel, values: Array, states: Array) -> Array:
    return np.array(
        [np.asarray(sensor.residual(y, x)).ravel() for y, x in zip(values, states, strict=True)]
    )


def assert_variance(samples: Array, std: float) -> None:
    """Assert that the samples lie within the χ² interval of a Gaussian of this size."""
    n = samples.size
    lowest, highest = chi2.ppf([EXTREME, 1 - EXTREME], n)
    assert lowest < np.sum(samples**2) / std**2 < highest


@pytest.mark.cover
@pytest.mark.parametrize("degrees_of_freedom", [5, 6])
@pytest.mark.parametrize("kind", SENSORS)
def test_noise_has_its_size_and_is_white(kind: str, degrees_of_freedom: int) -> None:
    sensor, values, states = simulated(kind, degrees_of_freedom)
    noise = residuals(sensor, values, states)
    n = len(noise)
    assert n == 4001
    for row, std in zip(noise.T, SENSORS[kind][2], strict=False):
        assert_variance(row, std)
        assert abs(row.mean()) < 4.5 * std / np.sqrt(n)
        for lag in (1, 2, 3, 10, 100):
            assert abs(np.mean(row[lag:] * row[:-lag])) < 4.5 * std**2 / np.sqrt(n - lag)
    correlation = np.corrcoef(noise.T) - np.eye(sensor.n_r)
    assert np.abs(correlation).max() < 4.5 / np.sqrt(n)


@pytest.mark.parametrize("m", [1, 10, 100])
def test_allan_deviation_of_the_noise(m: int) -> None:
    """N/√τ with N² the variance of a sample times the sampling period."""
    sensor, values, states = simulated("accelerometer")
    noise = residuals(sensor, values, states)
    density = ACCEL_STD / np.sqrt(RATE_HZ)
    found = np.sqrt(np.mean([allan_variance(axis, m) for axis in noise.T]))
    limit = 4.5 * relative_error(white_kernel(m), m, len(noise)) / 2 / np.sqrt(3)
    assert abs(found / (density / np.sqrt(m / RATE_HZ)) - 1) < limit < 0.3


@pytest.mark.parametrize("kind", SENSORS)
@pytest.mark.parametrize("degrees_of_freedom", [5, 6])
def test_a_reading_has_the_drawn_residual(kind: str, degrees_of_freedom: int) -> None:
    """Also turns of half a radian, where a rotation's residual is far from a difference."""
    sensor, _, states = simulated(kind, degrees_of_freedom)
    noise = np.random.default_rng(2).uniform(-0.5, 0.5, (30, sensor.n_r))
    values = noisy_readings(sensor, states[:30], noise)
    np.testing.assert_allclose(residuals(sensor, values, states[:30]), noise, rtol=0, atol=1e-12)
    exact = noisy_readings(sensor, states[:30], 0 * noise)
    h = np.array([np.asarray(sensor.h(x)).ravel() for x in states[:30]])
    np.testing.assert_allclose(exact, h, rtol=0, atol=1e-15)


@pytest.mark.parametrize("step_over_std", [0.5, 1.0, 2.0])
def test_quantised_noise_is_what_the_estimators_assume(step_over_std: float) -> None:
    """Variance σ² + Δ²/12 over a truth that sweeps the grid; R says the same."""
    step = step_over_std * ACCEL_STD
    sensor, values, states = simulated("accelerometer", resolution_m_s2=step)
    expected = np.sqrt(ACCEL_STD**2 + step**2 / 12)
    assert sensor.noise_std == pytest.approx([expected] * 3, rel=1e-12)
    assert sensor.drawn_std == pytest.approx([ACCEL_STD] * 3, rel=1e-12)
    # A uniform error strays less than a Gaussian: the interval of χ² is wide enough.
    assert_variance(residuals(sensor, values, states), expected)
    assert_multiples(values, step)


def assert_multiples(values: Array, step: float) -> None:
    codes = values / step
    np.testing.assert_allclose(codes, np.round(codes), rtol=0, atol=1e-9)


def test_noise_far_below_the_step_stays_as_drawn() -> None:
    step = 100 * ACCEL_STD
    sensor, _, _ = simulated("accelerometer", resolution_m_s2=step)
    assert sensor.drawn_std == pytest.approx([ACCEL_STD] * 3, rel=1e-11)


@pytest.mark.parametrize("resolution", [0.0, 0.03])
def test_readings_end_at_the_range(resolution: float) -> None:
    """The same noise with and without a range: clipped there, and nowhere else."""
    limit = 8.0
    _, analogue, _ = simulated("accelerometer")
    sensor, values, _ = simulated("accelerometer", range_m_s2=limit, resolution_m_s2=resolution)
    assert sensor.reading_limit == limit
    assert np.abs(values).max() == limit
    beyond = np.abs(analogue) > limit + resolution / 2
    assert 100 < beyond.sum() < beyond.size / 2
    np.testing.assert_array_equal(values[beyond], np.sign(analogue[beyond]) * limit)
    within = np.abs(analogue) < limit - resolution / 2
    assert np.abs(values[within] - analogue[within]).max() <= resolution / 2 + 1e-12
    if resolution:
        assert_multiples(values[np.abs(values) < limit], resolution)


def test_lost_samples() -> None:
    """Binomial in number, independent of one another, the others as without losses."""
    fraction = 0.2
    _, whole, _ = simulated("gyroscope")
    sensor, values, _ = simulated("gyroscope", dropout_fraction=fraction)
    assert sensor.dropout_fraction == fraction
    lost = np.isnan(values).any(axis=1)
    np.testing.assert_array_equal(np.isnan(values).all(axis=1), lost)
    np.testing.assert_array_equal(values[~lost], whole[~lost])
    n = len(lost)
    assert binom.ppf(EXTREME, n, fraction) <= lost.sum() <= binom.ppf(1 - EXTREME, n, fraction)
    centred = (lost - fraction) / np.sqrt(fraction * (1 - fraction))
    for lag in (1, 2, 5):
        assert abs(np.mean(centred[lag:] * centred[:-lag])) < 4.5 / np.sqrt(n - lag)


def test_losing_everything_is_refused() -> None:
    for fraction in (1.0, -0.1):
        with pytest.raises(ValueError, match="dropout_fraction"):
            Gyroscope(**SENSORS["gyroscope"][1], dropout_fraction=fraction)
