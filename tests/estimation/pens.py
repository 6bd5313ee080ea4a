"""A pen of five degrees of freedom with sensors on its axis, and readings drawn from it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from estimation.recording import Measurement
from models.arrays import Array
from models.motion import white_jerk_motion
from models.pen import pen_model
from models.pen_config import PenConfig
from models.state_space import StateSpaceModel
from tests.references import pen_readings
from tests.references.batch import BatchProblem, white_jerk_step

DENSITIES = np.array([30.0, 30.0, 30.0, 200.0, 200.0])
ACCEL_R, CAMERA_R = 0.11, 0.16
ACCEL_STD, GYRO_STD, POSITION_STD, TURN_STD = 0.04, 0.01, 0.002, 0.02
BANDWIDTH_HZ = 50.0
TARGET_TO_BODY = Rotation.from_rotvec([0.3, -0.5, 1.1]).as_matrix()
PRIOR_MEAN = np.array([0.02, -0.01, 0.03, 0.4, 0.8] + [0.0] * 10)
PRIOR_STD = np.array([0.1] * 3 + [0.5, 0.3] + [0.2] * 3 + [1.0] * 2 + [3.0] * 3 + [5.0] * 2)


def pen_config() -> PenConfig:
    """Accelerometer, gyroscope and camera; noise as in the constants above."""
    per_sample = math.sqrt(math.pi / 2 * BANDWIDTH_HZ)
    return PenConfig.model_validate(
        {
            "name": "test pen",
            "degrees_of_freedom": 5,
            "motion": white_jerk_motion(DENSITIES[0], DENSITIES[-1]),
            "prior": {
                "tip_m": PRIOR_MEAN[:3],
                "tip_std_m": PRIOR_STD[0],
                "azimuth_rad": PRIOR_MEAN[3],
                "azimuth_std_rad": PRIOR_STD[3],
                "elevation_rad": PRIOR_MEAN[4],
                "elevation_std_rad": PRIOR_STD[4],
                "velocity_std_m_s": PRIOR_STD[5],
                "angle_rate_std_rad_s": PRIOR_STD[8],
                "acceleration_std_m_s2": PRIOR_STD[10],
                "angle_acceleration_std_rad_s2": PRIOR_STD[13],
            },
            "sensors": {
                "accel": {
                    "kind": "accelerometer",
                    "position_m": (0.0, 0.0, ACCEL_R),
                    "bandwidth_hz": BANDWIDTH_HZ,
                    "noise_density_m_s2_per_sqrt_hz": ACCEL_STD / per_sample,
                },
                "gyro": {
                    "kind": "gyroscope",
                    "bandwidth_hz": BANDWIDTH_HZ,
                    "noise_density_rad_s_per_sqrt_hz": GYRO_STD / per_sample,
                },
                "camera": {
                    "kind": "pose_camera",
                    "position_m": (0.0, 0.0, CAMERA_R),
                    "sensor_to_body": TARGET_TO_BODY.tolist(),
                    "position_std_m": POSITION_STD,
                    "orientation_std_rad": TURN_STD,
                },
            },
        }
    )


@dataclass(frozen=True, eq=False)
class PenRun:
    """The model, true states (n, 15) and what was measured of them."""

    model: StateSpaceModel
    truth: Array
    measurements: list[Measurement]


def draw_pen_run(n: int, seed: int, mean: Array = PRIOR_MEAN) -> PenRun:
    """Draw a motion from the model, irregular stamps, a slow camera and missing rows."""
    rng = np.random.default_rng(seed)
    times = np.cumsum(rng.uniform(0.004, 0.016, n))
    x = mean + PRIOR_STD * rng.standard_normal(15)
    states = [x]
    for dt in np.diff(times):
        F, G = white_jerk_step(float(dt), DENSITIES)
        x = F @ x + G @ rng.standard_normal(15)
        states.append(x)
    truth = np.array(states)
    accel = pen_readings.accelerometer(truth, ACCEL_R) + ACCEL_STD * rng.standard_normal((n, 3))
    gyro = pen_readings.gyroscope(truth) + GYRO_STD * rng.standard_normal((n, 3))
    accel[rng.uniform(size=(n, 3)) < 0.1] = np.nan
    gyro[rng.uniform(size=(n, 3)) < 0.1] = np.nan
    pose = pen_readings.camera(truth, CAMERA_R, TARGET_TO_BODY)
    shake = Rotation.from_rotvec(TURN_STD * rng.standard_normal((n, 3)))
    pose[:, :3] += POSITION_STD * rng.standard_normal((n, 3))
    pose[:, 3:] = (shake * Rotation.from_rotvec(pose[:, 3:])).as_rotvec()
    pose[np.arange(n) % 3 != 1] = np.nan
    pose[4, 3:] = np.nan  # a position without orientation
    y = np.hstack([accel, gyro, pose])
    measurements = [Measurement(float(t), row) for t, row in zip(times, y, strict=True)]
    return PenRun(pen_model(pen_config()), truth, measurements)


def pen_batch(
    measurements: list[Measurement], mean: Array = PRIOR_MEAN, L: Array | None = None
) -> BatchProblem:
    """Return the full-length problem of some measurements in the references' own formulas."""
    times, y = np.array([m.time_s for m in measurements]), np.array([m.y for m in measurements])
    steps = [white_jerk_step(float(dt), DENSITIES) for dt in np.diff(times)]
    rows_there = ~np.isnan(y)
    turn_there = np.repeat(rows_there[:, 9:].all(axis=1)[:, None], 2, axis=1)
    there = np.hstack([rows_there[:, :9], turn_there])
    known = np.nan_to_num(y)
    std = np.repeat([ACCEL_STD, GYRO_STD, POSITION_STD, TURN_STD], [3, 3, 3, 2])

    def readings(states: Array) -> Array:
        residual = np.hstack(
            [
                known[:, :3] - pen_readings.accelerometer(states, ACCEL_R),
                known[:, 3:6] - pen_readings.gyroscope(states),
                pen_readings.camera_residual(known[:, 6:], states, CAMERA_R, TARGET_TO_BODY),
            ]
        )
        return (residual / std)[there]

    F, G = [F for F, _ in steps], [G for _, G in steps]
    return BatchProblem(mean, np.diag(PRIOR_STD) if L is None else L, F, G, readings)
