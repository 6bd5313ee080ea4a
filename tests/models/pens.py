"""Pens and states that the tests of this folder share."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from models.pen_config import PenConfig
from models.sensor_kinds.accelerometer import Accelerometer
from models.sensor_kinds.contact import Contact
from models.sensor_kinds.gyroscope import Gyroscope
from models.sensor_kinds.pose_camera import PoseCamera
from models.sensor_kinds.writing_area import WritingArea
from tests.references.free_states import body_to_world

Array = NDArray[np.float64]

FIXED_SPIN_RAD = 0.6
ACCELEROMETER = {"noise_density_m_s2_per_sqrt_hz": 0.004, "bandwidth_hz": 50.0}
GYROSCOPE = {"noise_density_rad_s_per_sqrt_hz": 0.001, "bandwidth_hz": 50.0}
CAMERA = {"position_std_m": 2e-4, "orientation_std_rad": 3e-3}


def call(function: ca.Function, *arguments: Any) -> Array:
    """Return the only result of a CasADi function as a vector."""
    return np.asarray(function(*arguments).full()).ravel()


def matrix(function: ca.Function, *arguments: Any) -> Array:
    """Return the only result of a CasADi function as a matrix."""
    return np.asarray(function(*arguments).full())


def pen(degrees_of_freedom: int, sensors: dict[str, Any], **others: Any) -> PenConfig:
    """Return a pen; one with five degrees of freedom has a spin that is not zero."""
    spin = {"fixed_spin_rad": FIXED_SPIN_RAD} if degrees_of_freedom == 5 else {}
    return PenConfig(
        **{
            "name": "test pen",
            "degrees_of_freedom": degrees_of_freedom,
            "sensors": sensors,
            **spin,
            **others,
        }
    )


def random_rotation(rng: np.random.Generator) -> list[list[float]]:
    """Return a rotation matrix by rows, as a sensor takes it."""
    rows: list[list[float]] = Rotation.random(rng=rng).as_matrix().tolist()
    return rows


def every_sensor(rng: np.random.Generator) -> dict[str, Any]:
    """Return one sensor of every kind, mounted off the axis and turned, with biases."""

    def mounting() -> dict[str, Any]:
        return {
            "position_m": tuple(rng.uniform(-0.1, 0.1, 3)),
            "sensor_to_body": random_rotation(rng),
        }

    return {
        "accel": Accelerometer(
            **ACCELEROMETER, **mounting(), bias_std_m_s2=0.3, bias_walk_m_s2_per_sqrt_s=0.01
        ),
        "gyro": Gyroscope(
            **GYROSCOPE,
            **mounting(),
            axes=("z", "x"),
            bias_std_rad_s=0.03,
            bias_walk_rad_s_per_sqrt_s=0.001,
        ),
        "camera": PoseCamera(**CAMERA, **mounting()),
        "contact": Contact(std_m=5e-4),
        "area": WritingArea(centre_m=(0.1, 0.2, 0.0), std_m=0.3),
    }


def random_state(rng: np.random.Generator, degrees_of_freedom: int, n_biases: int = 0) -> Array:
    """Return a brisk pen, its axis anywhere but within 0.2 rad of upright.

    With six degrees of freedom its angles are drawn alike, and rates and accelerations of its
    body in place of theirs.
    """
    n_angles = degrees_of_freedom - 3
    angles = rng.uniform([-np.pi, -1.3, -np.pi], [np.pi, 1.3, np.pi])[:n_angles]
    is_free = degrees_of_freedom == 6
    return np.concatenate(
        [
            rng.uniform(-0.2, 0.2, 3),
            body_to_world(*angles[:, None]).as_mrp()[0] if is_free else angles,
            rng.normal(0, 0.3, 3),
            rng.normal(0, 3.0, n_angles),
            rng.normal(0, 5.0, 3),
            rng.normal(0, 30.0, n_angles),
            rng.normal(0, 0.1, n_biases),
        ]
    )
