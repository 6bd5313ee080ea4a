"""The kinds of sensors, a row each, and a sensor on a body as functions of the state."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, TypeAlias, Union

import casadi as ca
from pydantic import Field

from models.sensor_kinds.accelerometer import Accelerometer
from models.sensor_kinds.contact import Contact
from models.sensor_kinds.gyroscope import Gyroscope
from models.sensor_kinds.magnetometer import Magnetometer
from models.sensor_kinds.mounted import SensorBase
from models.sensor_kinds.pose_camera import PoseCamera
from models.sensor_kinds.reading import MovingBody
from models.sensor_kinds.rest import Rest
from models.sensor_kinds.tip_position import TipPosition
from models.sensor_kinds.writing_area import WritingArea
from models.sensor_model import SensorModel

KINDS: tuple[type[SensorBase], ...] = (
    Accelerometer,
    Gyroscope,
    Magnetometer,
    PoseCamera,
    TipPosition,
    Contact,
    WritingArea,
    Rest,
)
"""A kind of sensor exists, for pen files and everything after them, with its row here."""

SENSOR_KINDS: Mapping[str, type[SensorBase]] = MappingProxyType(
    {kind.model_fields["kind"].default: kind for kind in KINDS}
)
"""Name of a kind, the key ``kind`` of a pen file → its class."""

if TYPE_CHECKING:
    Sensor: TypeAlias = SensorBase
else:
    Sensor = Annotated[Union[KINDS], Field(discriminator="kind")]  # noqa: UP007


def sensor_model(
    name: str, sensor: SensorBase, body: MovingBody, x: ca.SX, bias: ca.SX
) -> SensorModel:
    """Turn a sensor as data into functions of the state.

    Parameters
    ----------
    name : the sensor's name
    sensor : of one of `KINDS`
    body : what it is mounted on, in symbols of `x`
    x : (n_x,) the whole state
    bias : the sensor's bias states, a part of x, possibly empty
    """
    reading = sensor.symbolic_reading(body, bias)
    axes, units = zip(*sensor.reading_axes, strict=True)
    biases = sensor.bias_states(name)
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
        seen=None if reading.seen is None else ca.Function(f"seen_{name}", [x], [reading.seen]),
        dropout_fraction=sensor.dropout_fraction,
        huber=sensor.huber,
        gate_probability=sensor.gate_probability,
        usual_innovations=sensor.usual_innovations,
        bias_states=biases.names,
        bias_walk=biases.walk,
        sees_pose=sensor.sees_pose,
        feels_gravity=sensor.feels_gravity,
        reads_rate=sensor.reads_rate,
        is_disturbed=sensor.is_disturbed,
        is_derived=sensor.is_rest,
        rest=reading.rest,
    )
