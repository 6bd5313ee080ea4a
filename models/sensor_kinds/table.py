"""What a sensor on a rigid body reads: symbols for every kind, derived.

One table, `SYMBOLIC_READINGS`, maps a sensor kind to a function that takes the
sensor, the moving body and its bias states and returns a `SymbolicReading`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Annotated, Any

import casadi as ca
from pydantic import Field

from models.sensor_kinds.contact import Contact, contact_reading
from models.sensor_kinds.inertial import (
    Accelerometer,
    Gyroscope,
    accelerometer_reading,
    gyroscope_reading,
)
from models.sensor_kinds.pose_camera import PoseCamera, pose_camera_reading
from models.sensor_kinds.reading import BiasStates, MovingBody, SymbolicReading
from models.sensor_kinds.writing_area import WritingArea, writing_area_reading
from models.sensor_model import SensorModel


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


Sensor = Annotated[
    Accelerometer | Gyroscope | PoseCamera | Contact | WritingArea,
    Field(discriminator="kind"),
]


SENSOR_KINDS: dict[str, type[Any]] = {
    kind.model_fields["kind"].default: kind
    for kind in (Accelerometer, Gyroscope, PoseCamera, Contact, WritingArea)
}


SYMBOLIC_READINGS: Mapping[str, Callable[[Any, MovingBody, ca.SX], SymbolicReading]] = (
    MappingProxyType(
        {
            "accelerometer": accelerometer_reading,
            "gyroscope": gyroscope_reading,
            "pose_camera": pose_camera_reading,
            "contact": contact_reading,
            "writing_area": writing_area_reading,
        }
    )
)


def sensor_model(name: str, sensor: Any, body: MovingBody, x: ca.SX, bias: ca.SX) -> SensorModel:
    """Turn a sensor as data into functions of the state.

    Parameters
    ----------
    name : the sensor's name
    sensor : one of `models.sensor_kinds.table.Sensor`
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
