"""What a pen file says of the start reaches the state it is about."""

from __future__ import annotations

import math

import numpy as np
import pytest

from models.pen import pen_model
from models.pen_config import PenConfig, Prior
from models.sensor_kinds.accelerometer import Accelerometer
from models.sensor_kinds.gyroscope import Gyroscope
from models.state_space import StateSpaceModel
from tests.models.pens import ACCELEROMETER, FIXED_SPIN_RAD, GYROSCOPE, call, pen

PRIOR = Prior(
    tip_m=(0.1, 0.2, 0.3),
    tip_std_m=0.4,
    azimuth_rad=0.5,
    azimuth_std_rad=0.6,
    elevation_rad=0.7,
    elevation_std_rad=0.8,
    spin_rad=0.9,
    spin_std_rad=1.1,
    velocity_std_m_s=1.2,
    angle_rate_std_rad_s=1.3,
    acceleration_std_m_s2=1.4,
    angle_acceleration_std_rad_s2=1.5,
)
EXPECTED = {
    "tip_x_m": (0.1, 0.4, "m"),
    "tip_y_m": (0.2, 0.4, "m"),
    "tip_z_m": (0.3, 0.4, "m"),
    "azimuth_rad": (0.5, 0.6, "rad"),
    "elevation_rad": (0.7, 0.8, "rad"),
    "spin_rad": (0.9, 1.1, "rad"),
    "tip_x_velocity_m_s": (0.0, 1.2, "m/s"),
    "tip_y_velocity_m_s": (0.0, 1.2, "m/s"),
    "tip_z_velocity_m_s": (0.0, 1.2, "m/s"),
    "azimuth_rate_rad_s": (0.0, 1.3, "rad/s"),
    "elevation_rate_rad_s": (0.0, 1.3, "rad/s"),
    "spin_rate_rad_s": (0.0, 1.3, "rad/s"),
    "tip_x_acceleration_m_s2": (0.0, 1.4, "m/s²"),
    "tip_y_acceleration_m_s2": (0.0, 1.4, "m/s²"),
    "tip_z_acceleration_m_s2": (0.0, 1.4, "m/s²"),
    "azimuth_acceleration_rad_s2": (0.0, 1.5, "rad/s²"),
    "elevation_acceleration_rad_s2": (0.0, 1.5, "rad/s²"),
    "spin_acceleration_rad_s2": (0.0, 1.5, "rad/s²"),
    "accel_bias_x_m_s2": (0.0, 1.6, "m/s²"),
    "accel_bias_y_m_s2": (0.0, 1.6, "m/s²"),
    "accel_bias_z_m_s2": (0.0, 1.6, "m/s²"),
    "gyro_bias_y_rad_s": (0.0, 1.7, "rad/s"),
}
"""State name → mean, standard deviation, unit, in the order of the state."""


def config_of(degrees_of_freedom: int) -> PenConfig:
    sensors = {
        "accel": Accelerometer(**ACCELEROMETER, bias_std_m_s2=1.6),
        "gyro": Gyroscope(**GYROSCOPE, axes=("y",), bias_std_rad_s=1.7),
    }
    return pen(degrees_of_freedom, sensors, prior=PRIOR)


def model_of(degrees_of_freedom: int) -> StateSpaceModel:
    return pen_model(config_of(degrees_of_freedom))


@pytest.mark.parametrize("degrees_of_freedom", [5, 6])
def test_every_state_has_its_own_mean_and_spread(degrees_of_freedom: int) -> None:
    model = model_of(degrees_of_freedom)
    expected = {
        name: row
        for name, row in EXPECTED.items()
        if degrees_of_freedom == 6 or not name.startswith("spin")
    }
    assert model.state_names == tuple(expected)
    mean, std, unit = zip(*expected.values(), strict=True)
    assert np.array_equal(model.prior.mean, mean)
    assert model.prior.std == pytest.approx(np.array(std), rel=1e-15)
    assert model.state_units == unit
    off_diagonal = model.prior.covariance - np.diag(np.diag(model.prior.covariance))
    assert not off_diagonal.any()


def test_nothing_is_known_of_azimuth_and_spin_by_default() -> None:
    """A uniform angle on (-π, π] has the variance ∫ a² da / 2π = π²/3."""
    angles = np.linspace(-math.pi, math.pi, 100_001)
    spread = np.sqrt(np.mean(angles**2))
    prior = Prior()
    assert prior.azimuth_std_rad == pytest.approx(spread, rel=1e-4)
    assert prior.spin_std_rad == pytest.approx(spread, rel=1e-4)


def test_a_fixed_spin_turns_the_sensor_axes() -> None:
    """At rest x and y of gravity turn by the spin about the pen's axis, z stays."""
    x = np.zeros(19)
    x[4] = 0.7
    read = call(model_of(5).sensor("accel").h, x)
    sideways = -9.81 * np.cos(0.7)
    expected = [
        sideways * np.cos(FIXED_SPIN_RAD),
        -sideways * np.sin(FIXED_SPIN_RAD),
        9.81 * np.sin(0.7),
    ]
    assert read == pytest.approx(expected, rel=1e-14)
    spinning = np.zeros(22)
    spinning[4:6] = 0.7, FIXED_SPIN_RAD
    assert call(model_of(6).sensor("accel").h, spinning) == pytest.approx(read, rel=1e-14)
