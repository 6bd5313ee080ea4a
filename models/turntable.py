"""The turntable of [Pen]: two tilts at constant rate, and the attitude that looks the same.

State, in blocks of the two tilts q = (φ, θ):

    x = (φ, θ, φ̇, θ̇, biases)

with constant rates driven by white angular acceleration. φ and θ are both tilts
about horizontal axes, with the world-to-body rotation ``R_x(θ) R_y(-φ)``; they are
not the pen's azimuth and elevation. The three observation models are

    accelerometer   (g sinφ, g cosφ sinθ, g cosφ cosθ)                        (10)
    gyroscope       (θ̇, φ̇ cosθ)                                               (11)
    both            (10) stacked on (11)                                      (12)

None of them is typed below: the rigid body gives them, with the origin fixed and
the rotational acceleration neglected. Its second rate is -φ̇ cosθ; (11) is a
gyroscope mounted half a turn about x away from the accelerometer.

References
----------
[Pen] equations (10)-(12) and its table of motions.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Annotated

import casadi as ca
import numpy as np
from pydantic import Field, PositiveFloat, field_validator

from models.arrays import Array
from models.body_model import Kinematics, body_model, choose_sensors, linear_step
from models.config import Title, UnitConfig
from models.kinematics import RigidBody
from models.manifold import wrapped_angles
from models.pen_file import load_config
from models.process_noise import constant_velocity, white_acceleration_factor
from models.rotation import about_z
from models.sensor_kinds.reading import MovingBody
from models.sensor_kinds.table import Sensor
from models.state_space import StateSpaceModel

TILTS = ("tilt_phi", "tilt_theta")
"""The degrees of freedom q; also the axes of a `TurntableConfig`."""


class AxisPrior(UnitConfig):
    """What is known of an axis before the first measurement: means and standard deviations."""

    angle_rad: float = 0.0
    angle_std_rad: PositiveFloat
    rate_rad_s: float = 0.0
    rate_std_rad_s: PositiveFloat


class TurntableAxis(UnitConfig):
    """One axis of the table.

    Parameters
    ----------
    range_rad : from where to where it turns
    rate_rad_s : the constant rate at which it runs, unless it stands still
    rate_tolerance_rad_s : how well it keeps that rate; larger follows changes of the
        rate faster and smooths less, see `TurntableConfig`
    prior : of the estimators
    """

    range_rad: tuple[float, float]
    rate_rad_s: PositiveFloat
    rate_tolerance_rad_s: PositiveFloat
    prior: AxisPrior

    @field_validator("range_rad")
    @classmethod
    def _ascends(cls, value: tuple[float, float]) -> tuple[float, float]:
        if not value[0] < value[1]:
            raise ValueError("expected the lower end of the range first")
        return value


class TurntableConfig(UnitConfig):
    """A turntable with its sensors, as written in a turntable file.

    A tolerance of the rate becomes process noise as a random walk of the rate:
    white angular acceleration of spectral density

        S = tolerance² / tolerance_reached_after_s

    lets the rate wander by one tolerance (one standard deviation) in that time.

    Parameters
    ----------
    name : for people
    gravity_m_s2 : local gravity
    tolerance_reached_after_s : larger holds the rates closer to constant and smooths more
    tilt_phi, tilt_theta : the axes
    sensors : by name
    """

    name: Title
    gravity_m_s2: PositiveFloat = 9.81
    tolerance_reached_after_s: PositiveFloat = 1.0
    tilt_phi: TurntableAxis
    tilt_theta: TurntableAxis
    sensors: Annotated[Mapping[str, Sensor], Field(min_length=1)]

    @property
    def axes(self) -> tuple[TurntableAxis, TurntableAxis]:
        """The axes in the order of the state."""
        return self.tilt_phi, self.tilt_theta

    def acceleration_density(self, axis: TurntableAxis) -> float:
        """Return √S of an axis, rad/s² per √Hz: its tolerance over the root of the time."""
        return axis.rate_tolerance_rad_s / math.sqrt(self.tolerance_reached_after_s)


def load_turntable(path: str | Path) -> TurntableConfig:
    """Read and validate a turntable file; raises `InputError` as `models.pen_file.load_pen`."""
    return load_config(path, TurntableConfig, "turntable file")


@cache
def paper_turntable() -> TurntableConfig:
    """Return the turntable of [Pen], ``models/turntables/pen_paper.toml``."""
    return load_turntable(Path(str(resources.files("models") / "turntables" / "pen_paper.toml")))


def world_to_table(phi: ca.SX, theta: ca.SX) -> ca.SX:
    """Return R_x(θ) R_y(-φ), (3, 3), from world to body coordinates; angles in rad."""
    # A change of coordinates about x is one about z with the axes renamed: x plays z,
    # y plays x, z plays y. About y likewise.
    about_x, about_y = about_z(theta)[[2, 0, 1], [2, 0, 1]], about_z(-phi)[[1, 2, 0], [1, 2, 0]]
    return about_x @ about_y


def mirror(state: Array) -> Array:
    """Return the state (…, n_x) that no inertial sensor tells from the given one.

        (φ, θ, φ̇, θ̇)  →  (π - φ, θ + π, -φ̇, θ̇)

    It is the same table turned half a turn about the vertical,

        R_x(θ + π) R_y(φ - π) = R_x(θ) R_y(-φ) R_z(π),

    so gravity and the body rates are the same, now and (constant rates) ever after. Only
    the prior tells the two apart: from a bad start an estimator can settle in the mirror
    solution and stay there, with small innovations. The angles are not wrapped; biases
    are left as they are. Twice mirrored is the first state, but for a turn of θ.
    """
    mirrored = np.array(state, dtype=float)
    mirrored[..., 0] = math.pi - mirrored[..., 0]
    mirrored[..., 1] += math.pi
    mirrored[..., 2] *= -1
    return mirrored


def turntable_model(
    config: TurntableConfig | None = None, sensors: Iterable[str] | None = None
) -> StateSpaceModel:
    """Build the state-space model of a turntable with some or all of its sensors.

    Its regularity is cosφ: at zero, gravity lies along the axis of θ, which cannot be
    seen then.

    Parameters
    ----------
    config : the turntable; None takes `paper_turntable`
    sensors : names from the turntable file, in the order to stack them; None takes all

    Raises
    ------
    InputError
        If a sensor is unknown or named twice; the message lists the known names.
    """
    config = config or paper_turntable()
    chosen = choose_sensors(config.sensors, sensors, config.name)
    q, q_dot = ca.SX.sym("q", 2), ca.SX.sym("q_dot", 2)
    origin, no_acceleration = ca.SX.zeros(3), ca.SX.zeros(2)
    rigid = RigidBody(q, q_dot, no_acceleration, origin, world_to_table(q[0], q[1]))
    body = MovingBody(rigid, config.gravity_m_s2, has_spin=True)
    return body_model(config.name, _kinematics(config, q, q_dot), body, chosen)


def _kinematics(config: TurntableConfig, q: ca.SX, q_dot: ca.SX) -> Kinematics:
    """Constant rates, driven by white acceleration on both axes."""
    priors = [axis.prior for axis in config.axes]
    densities = ca.diag(ca.DM([config.acceleration_density(axis) for axis in config.axes]))
    is_angle = (True, True, False, False)
    std = [p.angle_std_rad for p in priors] + [p.rate_std_rad_s for p in priors]
    return Kinematics(
        x=ca.vertcat(q, q_dot),
        names=(*(f"{tilt}_rad" for tilt in TILTS), *(f"{tilt}_rate_rad_s" for tilt in TILTS)),
        units=("rad", "rad", "rad/s", "rad/s"),
        step=linear_step(
            lambda dt: ca.kron(constant_velocity(dt), ca.SX.eye(2)),
            lambda dt: ca.kron(white_acceleration_factor(dt), densities),
        ),
        retract=lambda x, d: wrapped_angles(x + d, is_angle),
        difference=lambda to, of: wrapped_angles(to - of, is_angle),
        mean=np.array([p.angle_rad for p in priors] + [p.rate_rad_s for p in priors]),
        covariance=np.diag(np.square(std)),
        regularity=ca.cos(q[0]),
    )
