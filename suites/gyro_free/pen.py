"""The same two accelerometers in the pen model, for EKF and MHE.

Axes: the long axis is x in [GyroFree] and z in the pen; their (x, y, z) are the pen's
(z, x, y). The pen's tip is put where their centre of mass is: no sensor says where on the
axis a pen ends, and so the position among the states is the path of the gesture.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np

from models.arrays import Array
from models.free_kinematics import attitude_of
from models.gaussian import GaussianState
from models.motion import Motion, white_jerk_motion
from models.pen import pen_model
from models.pen_body import rates_and_attitudes
from models.pen_config import PenConfig, Prior
from models.sensor_kinds.accelerometer import Accelerometer
from models.sensor_kinds.gyroscope import Gyroscope
from models.sensor_kinds.inertial import sample_noise_std
from models.sensor_kinds.mounted import Matrix3
from models.sensor_kinds.table import Sensor
from models.state_space import StateSpaceModel
from suites.gyro_free.readings import GRAVITY_M_S2

THEIR_AXES_TO_PEN: Matrix3 = ((0, 1, 0), (0, 0, 1), (1, 0, 0))
"""v_pen = THEIR_AXES_TO_PEN · v_theirs."""

LOWER, UPPER, NO_ROLL_SENSOR = "accel_lower", "accel_upper", "no_roll"
"""At their L₁ = (-l, 0, 0) and L₂ = (+l, 0, 0), and what says that the pen does not roll."""

ANGLES = ("azimuth", "elevation", "spin")

BANDWIDTH_HZ = 100.0
"""Of all sensors: its only part here is in the noise of a sample."""

START_STD = Prior(
    tip_std_m=1e-4,
    azimuth_std_rad=math.radians(0.1),
    elevation_std_rad=math.radians(0.1),
    spin_std_rad=math.radians(0.1),
    velocity_std_m_s=0.001,
    angle_rate_std_rad_s=0.01,
    acceleration_std_m_s2=0.01,
    angle_acceleration_std_rad_s2=0.1,
)
"""A start at rest in a known pose, as the integration takes it."""

GESTURE_MOTION = white_jerk_motion(tip=13.0, attitude=28.0)
"""RMS jerk of the test case's gestures over the root of its bandwidth."""

NO_ROLL_STD_RAD_S = math.radians(1.0)
"""How sure one is that a pen does not roll: a gyroscope about its axis that reads zero."""


@dataclass(frozen=True)
class TwoAccelerometers:
    """A pen with two accelerometers on its axis.

    Parameters
    ----------
    half_distance_m : l
    noise_std : of a sample of one axis, m/s²; told
    bias_std : of one axis, m/s²; told. 0 has no biases among the states
    degrees_of_freedom : 6, or 5 for a pen of constant spin
    no_roll : adds the sensor `NO_ROLL_SENSOR`
    prior, motion : what is told of the motion
    """

    half_distance_m: float
    noise_std: float
    bias_std: float
    degrees_of_freedom: int = 6
    no_roll: bool = False
    prior: Prior = START_STD
    motion: Motion = GESTURE_MOTION


@cache
def two_accelerometers(pen: TwoAccelerometers) -> tuple[PenConfig, StateSpaceModel]:
    """Return the configuration of a pen, and its model."""
    per_density = sample_noise_std(1.0, BANDWIDTH_HZ)

    def sensor(z: float) -> Accelerometer:
        return Accelerometer(
            position_m=(0.0, 0.0, z),
            sensor_to_body=THEIR_AXES_TO_PEN,
            bandwidth_hz=BANDWIDTH_HZ,
            noise_density_m_s2_per_sqrt_hz=pen.noise_std / per_density,
            bias_std_m_s2=pen.bias_std,
        )

    sensors: dict[str, Sensor] = {
        LOWER: sensor(-pen.half_distance_m),
        UPPER: sensor(pen.half_distance_m),
    }
    if pen.no_roll:
        sensors[NO_ROLL_SENSOR] = Gyroscope(
            axes=("z",),
            bandwidth_hz=BANDWIDTH_HZ,
            noise_density_rad_s_per_sqrt_hz=NO_ROLL_STD_RAD_S / per_density,
        )
    config = PenConfig(
        name=f"two accelerometers {2e3 * pen.half_distance_m:g} mm apart",
        degrees_of_freedom=5 if pen.degrees_of_freedom == 5 else 6,
        gravity_m_s2=GRAVITY_M_S2,
        prior=pen.prior,
        motion=pen.motion,
        sensors=sensors,
    )
    # A gesture in the air has no writing area.
    return config, pen_model(config, writing_area=False)


def start(model: StateSpaceModel, C: Array, rate: Array | None = None) -> GaussianState:
    """Return the model's prior with its means at a known attitude, and rate.

    Parameters
    ----------
    C : (3, 3) direction cosines of the start, world to their axes
    rate : (3,) of the start in their axes, rad/s; at rest by default
    """
    mean, to_pen = model.prior.mean.copy(), np.array(THEIR_AXES_TO_PEN)
    body_rate = np.zeros(3) if rate is None else to_pen @ rate
    angles = pen_angles(C)
    known = {
        "mrp_{}": zip("xyz", attitude_of(*angles), strict=True),
        "body_rate_{}_rad_s": zip("xyz", body_rate, strict=True),
        "{}_rad": zip(ANGLES, angles, strict=True),
        "{}_rate_rad_s": zip(ANGLES, angle_rates(angles, body_rate), strict=True),
    }
    for pattern, values in known.items():
        for of, value in values:
            if pattern.format(of) in model.state_names:
                mean[model.state_names.index(pattern.format(of))] = value
    return GaussianState(mean, model.prior.covariance)


def pen_angles(C: Array) -> Array:
    """Return azimuth, elevation and spin (3,), rad, of direction cosines in their axes."""
    B = np.array(THEIR_AXES_TO_PEN) @ C
    azimuth, elevation = math.atan2(B[2, 1], B[2, 0]), math.asin(np.clip(B[2, 2], -1, 1))
    # The third column of B is (-cos ψ cosθ, sin ψ cosθ, sinθ).
    return np.array([azimuth, elevation, math.atan2(B[1, 2], -B[0, 2])])


def angle_rates(angles: Array, body_rate: Array) -> Array:
    """Return the rates (3,) of the angles of a body rate (3,), rad/s.

    Solves ω = Rz(ψ) (-cosθ ωφ, -ωθ, sinθ ωφ) + (0, 0, ωψ).
    """
    _, elevation, spin = angles
    x, y, z = body_rate
    of_azimuth = -(math.cos(spin) * x - math.sin(spin) * y) / math.cos(elevation)
    of_elevation = -(math.sin(spin) * x + math.cos(spin) * y)
    return np.array([of_azimuth, of_elevation, z - math.sin(elevation) * of_azimuth])


def rates_and_cosines(states: Array, degrees_of_freedom: int) -> tuple[Array, Array]:
    """Return rates (n, 3) in rad/s and C (n, 3, 3) in their axes, of states (n, n_x) of a pen."""
    config, _ = two_accelerometers(TwoAccelerometers(0.1, 1.0, 0.0, degrees_of_freedom))
    rates, B = rates_and_attitudes(config, states)
    to_pen = np.array(THEIR_AXES_TO_PEN)
    return rates @ to_pen, to_pen.T @ B
