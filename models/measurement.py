"""What a sensor on a rigid body reads: symbols for every kind, derived.

One table, `SYMBOLIC_READINGS`, maps a sensor kind to a function that takes the
sensor, the moving body and its bias states and returns a `SymbolicReading`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import casadi as ca
import numpy as np

from models.arrays import Array
from models.kinematics import Body
from models.rotation import axis_difference, rotation_matrix, rotation_vector
from models.sensor_model import SensorModel, quantiser_variance
from models.sensors import (
    Accelerometer,
    Contact,
    Gyroscope,
    InertialSensor,
    PoseCamera,
    WritingArea,
    sample_noise_std,
)

_AXIS = {"x": 0, "y": 1, "z": 2}


@dataclass(frozen=True)
class MovingBody:
    """A body in a field of gravity, and whether it may spin about its axis."""

    rigid: Body
    gravity_m_s2: float
    has_spin: bool


@dataclass(frozen=True)
class SymbolicReading:
    """A sensor's reading as an expression of the state.

    Parameters
    ----------
    h : (n_y,) expression of a reading without noise
    noise_std : (n_r,)
    row_units : (n_r,) units of the residual's rows; those of the axes where it is None
    residual : takes y (n_y,) and returns (n_r,); y - h where it is None
    """

    h: ca.SX
    noise_std: Array
    residual: Callable[[ca.SX], ca.SX] | None = None
    constant_reading: Array | None = None
    reading_limit: float | None = None
    resolution: float = 0.0
    touched_height: float | None = None
    row_units: tuple[str, ...] | None = None


def reading_axes(sensor: Any) -> tuple[tuple[str, str], ...]:
    """Return (axis, SI unit) of each component of a sensor's reading.

    ``(("x", "m_s2"), …)`` for an accelerometer; the units are keys of `models.units.UNITS`.
    """
    match sensor:
        case Accelerometer():
            return tuple((axis, "m_s2") for axis in sensor.axes)
        case Gyroscope():
            return tuple((axis, "rad_s") for axis in sensor.axes)
        case PoseCamera():
            return tuple((axis, "m") for axis in "xyz") + tuple((f"r{a}", "rad") for a in "xyz")
        case Contact():
            return (("z", "m"),)
        case WritingArea():
            return tuple((axis, "m") for axis in "xyz")
    raise TypeError(f"{type(sensor).__name__} is not a sensor")


@dataclass(frozen=True)
class BiasStates:
    """The bias states that a sensor asks for: names, unit, initial std, walk density."""

    names: tuple[str, ...] = ()
    unit: str = ""
    std: float = 0.0
    walk: float = 0.0


def bias_states(name: str, sensor: Any) -> BiasStates:
    """Return the bias states of a sensor; none unless its initial std is positive."""
    match sensor:
        case Accelerometer():
            unit, std, walk = "m_s2", sensor.bias_std_m_s2, sensor.bias_walk_m_s2_per_sqrt_s
        case Gyroscope():
            unit, std, walk = "rad_s", sensor.bias_std_rad_s, sensor.bias_walk_rad_s_per_sqrt_s
        case _:
            return BiasStates()
    if std == 0:
        return BiasStates()
    names = tuple(f"{name}_bias_{axis}_{unit}" for axis in sensor.axes)
    return BiasStates(names, unit, std, walk)


def _inertial(
    sensor: InertialSensor, body_vector: ca.SX, bias: ca.SX, density: float, resolution: float
) -> tuple[ca.SX, Array]:
    rows = [_AXIS[axis] for axis in sensor.axes]
    in_sensor_axes = ca.DM(sensor.sensor_to_body).T @ body_vector
    h = in_sensor_axes[rows]
    if bias.numel():
        h = h + bias
    variance = sample_noise_std(density, sensor.bandwidth_hz) ** 2 + quantiser_variance(resolution)
    return h, np.full(len(rows), np.sqrt(variance))


def _accelerometer(sensor: Accelerometer, body: MovingBody, bias: ca.SX) -> SymbolicReading:
    force = body.rigid.specific_force(ca.SX(sensor.position_m), body.gravity_m_s2)
    h, noise_std = _inertial(
        sensor, force, bias, sensor.noise_density_m_s2_per_sqrt_hz, sensor.resolution_m_s2
    )
    return SymbolicReading(
        h, noise_std, reading_limit=sensor.range_m_s2, resolution=sensor.resolution_m_s2
    )


def _gyroscope(sensor: Gyroscope, body: MovingBody, bias: ca.SX) -> SymbolicReading:
    h, noise_std = _inertial(
        sensor,
        body.rigid.body_rate(),
        bias,
        sensor.noise_density_rad_s_per_sqrt_hz,
        sensor.resolution_rad_s,
    )
    return SymbolicReading(
        h, noise_std, reading_limit=sensor.range_rad_s, resolution=sensor.resolution_rad_s
    )


def _pose_camera(sensor: PoseCamera, body: MovingBody, bias: ca.SX) -> SymbolicReading:
    """Position plainly; orientation by the rotation vector between seen and predicted.

    A body that cannot spin is compared by the direction of its axis only,
    because a seen spin would otherwise be explained by tilting the axis.
    """
    world_to_body = body.rigid.world_to_body
    target_to_body = ca.DM(sensor.sensor_to_body)
    position = body.rigid.point(ca.SX(sensor.position_m))
    h = ca.vertcat(position, rotation_vector(world_to_body.T @ target_to_body))

    def residual(y: ca.SX) -> ca.SX:
        seen_body_to_world = rotation_matrix(y[3:6]) @ target_to_body.T
        seen_in_body = world_to_body @ seen_body_to_world
        if body.has_spin:
            turn = rotation_vector(seen_in_body)
        else:
            turn = axis_difference(seen_in_body[:, 2])
        return ca.vertcat(y[:3] - position, turn)

    n_turn = 3 if body.has_spin else 2
    noise_std = np.array([sensor.position_std_m] * 3 + [sensor.orientation_std_rad] * n_turn)
    row_units = ("m",) * 3 + ("rad",) * n_turn
    return SymbolicReading(h, noise_std, residual, row_units=row_units)


def _contact(sensor: Contact, body: MovingBody, bias: ca.SX) -> SymbolicReading:
    noise_std = np.array([sensor.std_m])
    return SymbolicReading(body.rigid.tip[2], noise_std, touched_height=sensor.height_m)


def _writing_area(sensor: WritingArea, body: MovingBody, bias: ca.SX) -> SymbolicReading:
    centre = np.array(sensor.centre_m)
    return SymbolicReading(body.rigid.tip, np.full(3, sensor.std_m), constant_reading=centre)


SYMBOLIC_READINGS: Mapping[str, Callable[[Any, MovingBody, ca.SX], SymbolicReading]] = (
    MappingProxyType(
        {
            "accelerometer": _accelerometer,
            "gyroscope": _gyroscope,
            "pose_camera": _pose_camera,
            "contact": _contact,
            "writing_area": _writing_area,
        }
    )
)


def sensor_model(name: str, sensor: Any, body: MovingBody, x: ca.SX, bias: ca.SX) -> SensorModel:
    """Turn a sensor as data into functions of the state.

    Parameters
    ----------
    name : the sensor's name
    sensor : one of `models.sensors.Sensor`
    body : what it is mounted on, in symbols of `x`
    x : (n_x,) the whole state
    bias : the sensor's bias states, a part of x, possibly empty
    """
    reading = SYMBOLIC_READINGS[sensor.kind](sensor, body, bias)
    axes, units = zip(*reading_axes(sensor), strict=True)
    biases = bias_states(name, sensor)
    y = ca.SX.sym("y", len(axes))
    residual = reading.residual(y) if reading.residual else y - reading.h
    return SensorModel(
        name=name,
        kind=sensor.kind,
        axes=axes,
        unit_of_axis=units,
        h=ca.Function(f"h_{name}", [x], [ca.densify(reading.h)], ["x"], ["y"]),
        residual=ca.Function(f"residual_{name}", [y, x], [ca.densify(residual)], ["y", "x"], ["r"]),
        noise_std=reading.noise_std,
        unit_of_row=reading.row_units or units,
        rate_hz=sensor.rate_hz,
        delay_s=sensor.delay_s,
        constant_reading=reading.constant_reading,
        reading_limit=reading.reading_limit,
        resolution=reading.resolution,
        touched_height=reading.touched_height,
        dropout_fraction=sensor.dropout_fraction,
        bias_states=biases.names,
        bias_walk=biases.walk,
    )
