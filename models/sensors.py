"""Sensors as data: what is mounted on the pen, where, and how good it is.

A sensor never becomes a class of model or estimator: `models.measurement`
turns any of these into symbolic readings.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, PositiveFloat, field_validator, model_validator

from models.config import UnitConfig

Vector3 = tuple[float, float, float]
Matrix3 = tuple[Vector3, Vector3, Vector3]
Axis = Literal["x", "y", "z"]
NonNegative = Annotated[float, Field(ge=0)]

IDENTITY: Matrix3 = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
ROTATION_TOLERANCE = 1e-6


def sample_noise_std(density: float, bandwidth_hz: float) -> float:
    """Return the standard deviation of one sample behind a single-pole filter.

    ``σ = density · √(π/2 · bandwidth)``: π/2 is the ratio of the noise
    bandwidth of a single pole to its -3 dB frequency.
    """
    return density * math.sqrt(math.pi / 2 * bandwidth_hz)


class SensorBase(UnitConfig):
    """What every sensor has.

    Parameters
    ----------
    rate_hz : nominal sampling rate, Hz; used by the simulator and by sensors
        without readings of their own, estimators go by the time stamps
    delay_s : time from capture to arrival, s
    dropout_fraction : part of the samples that get lost, each by itself; used by the
        simulator only
    sees_position : whether the tip's position stays bounded with this sensor
    """

    sees_position: ClassVar[bool] = False
    rate_hz: PositiveFloat | None = None
    delay_s: NonNegative = 0.0
    dropout_fraction: Annotated[float, Field(ge=0, lt=1)] = 0.0


class MountedSensor(SensorBase):
    """A sensor at a place and in an orientation on the pen.

    Parameters
    ----------
    position_m : from the tip, in body axes (z from tip to top), m
    sensor_to_body : rotation matrix by rows, v_body = sensor_to_body · v_sensor
    """

    position_m: Vector3 = (0.0, 0.0, 0.0)
    sensor_to_body: Matrix3 = IDENTITY

    @field_validator("sensor_to_body")
    @classmethod
    def _is_rotation(cls, value: Matrix3) -> Matrix3:
        matrix = np.array(value)
        if np.abs(matrix @ matrix.T - np.eye(3)).max() > ROTATION_TOLERANCE:
            raise ValueError("expected a rotation matrix: its rows are not orthonormal")
        if np.linalg.det(matrix) < 0:
            raise ValueError("expected a rotation matrix: its determinant is -1, a reflection")
        return value


class InertialSensor(MountedSensor):
    """Noise and bias of one axis, in the unit that the concrete sensor names.

    The noise of a sample is white, with the density behind a single pole of
    `bandwidth_hz`. A bias that starts with standard deviation `bias_std` > 0
    becomes a state (a random walk of density `bias_walk`).
    """

    axes: tuple[Axis, ...] = Field(default=("x", "y", "z"), min_length=1)
    bandwidth_hz: PositiveFloat

    @field_validator("axes")
    @classmethod
    def _no_axis_twice(cls, value: tuple[Axis, ...]) -> tuple[Axis, ...]:
        if len(set(value)) < len(value):
            raise ValueError(f"expected each axis once, got {', '.join(value)}")
        return value

    @model_validator(mode="after")
    def _walk_has_a_start(self) -> Self:
        """Refuse a walk that nothing would walk: a bias of std 0 is no state."""
        std, walk = self._field("bias_std_"), self._field("bias_walk_")
        if getattr(self, walk) > 0 and getattr(self, std) == 0:
            raise ValueError(f"{walk} is given without {std}, expected a positive {std}")
        return self

    @model_validator(mode="after")
    def _range_has_steps(self) -> Self:
        """Refuse a quantiser of which every code is a limit of the range."""
        limit, step = self._field("range_"), self._field("resolution_")
        if getattr(self, limit) is not None and getattr(self, step) >= getattr(self, limit):
            raise ValueError(f"{step} is not below {limit}, expected a step within the range")
        return self

    @classmethod
    def _field(cls, stem: str) -> str:
        """Return the concrete sensor's field that begins with a stem, whatever its unit."""
        return next(field for field in cls.model_fields if field.startswith(stem))


class Accelerometer(InertialSensor):
    """Specific force along its axes, m/s²: at rest +g along the upward direction."""

    kind: Literal["accelerometer"] = "accelerometer"
    noise_density_m_s2_per_sqrt_hz: PositiveFloat
    range_m_s2: PositiveFloat | None = None
    resolution_m_s2: NonNegative = 0.0
    bias_std_m_s2: NonNegative = 0.0
    bias_walk_m_s2_per_sqrt_s: NonNegative = 0.0


class Gyroscope(InertialSensor):
    """Angular rate about its axes, rad/s."""

    kind: Literal["gyroscope"] = "gyroscope"
    noise_density_rad_s_per_sqrt_hz: PositiveFloat
    range_rad_s: PositiveFloat | None = None
    resolution_rad_s: NonNegative = 0.0
    bias_std_rad_s: NonNegative = 0.0
    bias_walk_rad_s_per_sqrt_s: NonNegative = 0.0


class PoseCamera(MountedSensor):
    """Pose of a target on the pen in the world: position, m, and rotation vector, rad.

    The rotation vector is that of the matrix from target axes to world axes.
    """

    sees_position: ClassVar[bool] = True
    kind: Literal["pose_camera"] = "pose_camera"
    position_std_m: PositiveFloat
    orientation_std_rad: PositiveFloat


class Contact(SensorBase):
    """The tip touches a plane of known height while the pen presses.

    Its reading is the height of the plane, m, while the tip touches, and
    missing while it does not.

    Parameters
    ----------
    std_m : how well the tip keeps to the plane, m; larger trusts it less
    pressure_threshold : raw pressure above which a recording counts as touching
    """

    kind: Literal["contact"] = "contact"
    height_m: float = 0.0
    std_m: PositiveFloat
    pressure_threshold: NonNegative = 0.0


class WritingArea(SensorBase):
    """A pen stays on its desk: the tip is N(centre, std²) per axis at `rate_hz`.

    It has no readings of its own. It makes position observable where nothing
    else does; a larger `std_m` binds the tip less.
    """

    sees_position: ClassVar[bool] = True
    kind: Literal["writing_area"] = "writing_area"
    centre_m: Vector3 = (0.0, 0.0, 0.0)
    std_m: PositiveFloat = 1.0
    rate_hz: PositiveFloat | None = 100.0


Sensor = Annotated[
    Accelerometer | Gyroscope | PoseCamera | Contact | WritingArea,
    Field(discriminator="kind"),
]
SENSOR_KINDS: dict[str, type[Any]] = {
    kind.model_fields["kind"].default: kind
    for kind in (Accelerometer, Gyroscope, PoseCamera, Contact, WritingArea)
}
