"""A pen as data: what a pen file says."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import Field, PositiveFloat, ValidationInfo, field_validator, model_validator

from models.config import Title, UnitConfig
from models.level import Vector2, check_level
from models.motion import Motion, with_motion
from models.outputs import UNIFORM_ANGLE_STD_RAD
from models.paper import Paper, check_paper
from models.printed import PrintedError, check_printed_pen
from models.recording_columns import RecordingColumns
from models.sensor_kinds.mounted import Vector3
from models.sensor_kinds.table import Sensor

Limit = Annotated[float, Field(allow_inf_nan=True)]
"""A bound in a pen file; inf leaves that side open, NaN is refused by the model."""


class Prior(UnitConfig):
    """What is known of the pen before its first measurement: means and standard deviations.

    Velocities and accelerations have mean zero.
    """

    tip_m: Vector3 = (0.0, 0.0, 0.0)
    tip_std_m: PositiveFloat = 0.3
    azimuth_rad: float = 0.0
    azimuth_std_rad: PositiveFloat = UNIFORM_ANGLE_STD_RAD
    elevation_rad: float = 0.9
    elevation_std_rad: PositiveFloat = 0.4
    spin_rad: float = 0.0
    spin_std_rad: PositiveFloat = UNIFORM_ANGLE_STD_RAD
    velocity_std_m_s: PositiveFloat = 0.2
    angle_rate_std_rad_s: PositiveFloat = 1.0
    acceleration_std_m_s2: PositiveFloat = 3.0
    angle_acceleration_std_rad_s2: PositiveFloat = 20.0


class PenConfig(UnitConfig):
    """A pen with its sensors, as written in a pen file.

    A file may say ``pen_mhe_version`` besides, see `models.pen_file`.

    Parameters
    ----------
    name : for people
    degrees_of_freedom : 5 (no spin) or 6
    gravity_m_s2 : local gravity
    level_rad : rotation vector (about the paper's x and y) from the paper's frame, in which tip,
        angles and camera are, to gravity's, see `models.level`; zero is a level paper
    reach_m : standard deviation of the tip's position from which its estimate says nothing;
        a status then says so; smaller warns earlier
    fixed_spin_rad : the constant spin of a pen with five degrees of freedom
    motion : what drives tip and attitude, see `models.motion`
    sensors : by name
    bounds : state name → (lower, upper), in the state's unit
    printed_errors : errors of [Pen] that this pen's accelerometers make, for comparison;
        none is the rigid body, all are the paper's (4)-(6), see `models.printed`
    paper : what the tip may not pass, see `models.paper`; None leaves it free
    recording : what a logger calls the columns of its recordings
    """

    name: Title
    degrees_of_freedom: Literal[5, 6] = 6
    gravity_m_s2: PositiveFloat = 9.81
    level_rad: Vector2 = (0.0, 0.0)
    reach_m: PositiveFloat = 2.0
    fixed_spin_rad: float = 0.0
    motion: Motion = Motion()
    prior: Prior = Prior()
    bounds: Mapping[str, tuple[Limit, Limit]] = Field(default_factory=dict)
    sensors: Annotated[Mapping[str, Sensor], Field(min_length=1)]
    printed_errors: tuple[PrintedError, ...] = ()
    paper: Paper | None = None
    recording: RecordingColumns | None = None

    @model_validator(mode="before")
    @classmethod
    def _motion_of_old_files(cls, data: Any) -> Any:
        return with_motion(data) if isinstance(data, Mapping) else data

    @field_validator("level_rad")
    @classmethod
    def _is_no_wall(cls, level_rad: Vector2) -> Vector2:
        check_level(level_rad)
        return level_rad

    @field_validator("printed_errors")
    @classmethod
    def _fit_the_printed_pen(
        cls, errors: tuple[PrintedError, ...], info: ValidationInfo
    ) -> tuple[PrintedError, ...]:
        check_printed_pen(errors, **info.data)
        return errors

    @field_validator("paper")
    @classmethod
    def _fits_bounds_and_sensors(cls, paper: Paper | None, info: ValidationInfo) -> Paper | None:
        check_paper(paper, **info.data)
        return paper
