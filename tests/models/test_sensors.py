"""How noisy a sample is: bandwidth, resolution, and what the papers say of their parts."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError
from scipy.integrate import quad

from models.pen import pen_model
from models.pen_file import parse_pen
from models.sensor_kinds.accelerometer import Accelerometer
from models.sensor_kinds.gyroscope import Gyroscope
from models.sensor_kinds.inertial import sample_noise_std
from models.sensor_kinds.pose_camera import PoseCamera
from models.sensor_model import SensorModel
from tests.models.pens import ACCELEROMETER, CAMERA, GYROSCOPE, pen

DEG = np.pi / 180
DATA_SHEET_POLE = np.sqrt(1.6 / (np.pi / 2))
"""The data sheet of the ADXL202 rounds the noise bandwidth of a pole from 1.571 to 1.6."""


def sensor_of(sensor: Any) -> SensorModel:
    return pen_model(pen(6, {"it": sensor})).sensors[0]


def preset_model(name: str) -> SensorModel:
    return pen_model(parse_pen({"name": "p", "sensors": {"it": {"preset": name}}})).sensors[0]


@pytest.mark.parametrize("bandwidth_hz", [1.0, 50.0, 400.0])
def test_sample_noise_is_the_density_behind_one_pole(bandwidth_hz: float) -> None:
    """σ² = density² ∫ |H(f)|² df with |H|² = 1 / (1 + (f / f_c)²)."""
    gain, _ = quad(lambda f: 1 / (1 + (f / bandwidth_hz) ** 2), 0, np.inf)
    expected = 0.003 * np.sqrt(gain)
    assert sample_noise_std(0.003, bandwidth_hz) == pytest.approx(expected, rel=1e-8)


def test_published_noise_of_the_accelerometer() -> None:
    """Section 2: about 0.044 m/s² per sample."""
    std = preset_model("ADXL202").noise_std
    assert std == pytest.approx([0.0435] * 3, abs=5e-5)
    assert [round(value, 3) for value in std * DATA_SHEET_POLE] == [0.044] * 3


def test_published_noise_of_the_gyroscope() -> None:
    """Section 2: about 0.4 °/s per sample."""
    std = preset_model("ADXRS150").noise_std / DEG
    assert std == pytest.approx([0.443] * 3, abs=5e-4)
    assert [round(value, 1) for value in std * DATA_SHEET_POLE] == [0.4] * 3


@pytest.mark.parametrize("resolution", [0.0, 0.001, 0.06])
def test_resolution_adds_the_variance_of_a_uniform_error(resolution: float) -> None:
    accel = sensor_of(Accelerometer(**ACCELEROMETER, resolution_m_s2=resolution))
    gyro = sensor_of(Gyroscope(**GYROSCOPE, resolution_rad_s=resolution))
    for sensor, density in ((accel, 0.004), (gyro, 0.001)):
        added = sensor.noise_std**2 - density**2 * 50.0 * np.pi / 2
        assert added == pytest.approx([resolution**2 / 12] * 3, rel=1e-9, abs=1e-18)


def test_a_quantiser_does_add_that_much() -> None:
    """Readings rounded to a grid that the truth sweeps: their variance grows by Δ²/12."""
    rng, step = np.random.default_rng(2), 0.06
    noise = sensor_of(Accelerometer(**ACCELEROMETER)).noise_std[0]
    quantised = sensor_of(Accelerometer(**ACCELEROMETER, resolution_m_s2=step)).noise_std[0]
    truth = rng.uniform(-1, 1, 400_000)
    error = np.round((truth + rng.normal(0, noise, truth.size)) / step) * step - truth
    # The relative standard error of a variance is √(2/n) = 0.2 %.
    assert error.var() == pytest.approx(quantised**2, rel=0.01)
    assert quantised**2 > 1.1 * noise**2


def test_noise_has_one_value_per_axis() -> None:
    sensor = sensor_of(Gyroscope(**GYROSCOPE, axes=("z", "x")))
    assert sensor.axes == ("z", "x")
    assert sensor.noise_std.shape == (2,)
    assert sensor.unit_of_axis == ("rad_s", "rad_s")


def test_range_rate_and_delay_reach_the_model() -> None:
    accel = sensor_of(Accelerometer(**ACCELEROMETER, range_m_s2=19.0, rate_hz=100.0))
    gyro = sensor_of(Gyroscope(**GYROSCOPE, range_rad_s=4.0))
    camera = sensor_of(PoseCamera(**CAMERA, rate_hz=30.0, delay_s=0.045))
    assert (accel.reading_limit, accel.rate_hz, accel.delay_s) == (19.0, 100.0, 0.0)
    assert (gyro.reading_limit, gyro.rate_hz) == (4.0, None)
    assert (camera.reading_limit, camera.rate_hz, camera.delay_s) == (None, 30.0, 0.045)


@pytest.mark.parametrize(
    ("preset", "limit"),
    [
        ("ADXL202", 2 * 9.80665),
        ("ADXRS150", 150 * DEG),
        ("LSM6DS3-accelerometer", 2 * 9.80665),
        ("LSM6DS3-gyroscope", 245 * DEG),
    ],
)
def test_range_of_a_preset(preset: str, limit: float) -> None:
    assert preset_model(preset).reading_limit == pytest.approx(limit, rel=1e-12)


def test_a_bias_needs_an_initial_spread() -> None:
    with_bias = pen(6, {"a": Accelerometer(**ACCELEROMETER, bias_std_m_s2=0.3, axes=("x", "z"))})
    model = pen_model(with_bias)
    assert model.state_names[18:] == ("a_bias_x_m_s2", "a_bias_z_m_s2")
    assert model.state_units[18:] == ("m/s²", "m/s²")
    assert model.prior.std[18:] == pytest.approx([0.3, 0.3])
    assert model.prior.mean[18:] == pytest.approx([0.0, 0.0], abs=0)
    assert pen_model(pen(6, {"a": Accelerometer(**ACCELEROMETER)})).n_x == 18


@pytest.mark.parametrize(
    ("kind", "keys", "unit"),
    [(Accelerometer, ACCELEROMETER, "m_s2"), (Gyroscope, GYROSCOPE, "rad_s")],
)
def test_a_bias_walk_needs_a_bias(kind: Any, keys: dict[str, float], unit: str) -> None:
    walk, std = f"bias_walk_{unit}_per_sqrt_s", f"bias_std_{unit}"
    with pytest.raises(ValueError, match=f"{walk} is given without {std}, expected a positive"):
        kind(**keys, **{walk: 0.01})
    assert getattr(kind(**keys, **{walk: 0.01, std: 0.3}), walk) == 0.01
    assert getattr(kind(**keys, **{walk: 0.0}), std) == 0.0


def test_a_step_as_wide_as_the_range_is_refused() -> None:
    with pytest.raises(ValidationError, match="resolution_m_s2 is not below range_m_s2"):
        Accelerometer(
            noise_density_m_s2_per_sqrt_hz=0.01,
            bandwidth_hz=50.0,
            range_m_s2=20.0,
            resolution_m_s2=20.0,
        )
