"""A pen with a sensor of one's own on it."""

from __future__ import annotations

from typing import Any

import casadi as ca
from pydantic import ValidationError

from models.errors import InputError
from models.own_arguments import check_arguments
from models.own_checks import check_sensor
from models.own_noise import varies
from models.own_sensors import OwnSensor
from models.pen import pen_model
from models.pen_config import PenConfig
from models.pen_file import AnyPen, as_pen, first_error
from models.plain_names import check_name
from models.sensor_kinds.own import OwnPenSensor


def with_sensor(pen: AnyPen, name: str, sensor: OwnSensor, **keys: Any) -> PenConfig:
    """Return a pen with one more sensor, that reads an expression of the pen's quantities.

    It is simulated, read from recordings, judged, estimated with and exported as those of the file
    are; its columns are ``<name>_<axis>_<unit>``.

    Parameters
    ----------
    pen : a pen, the name of a bundled one, or the path of a pen file
    name : of the new sensor
    sensor : its `reads` takes `models.pen_quantities.PenQuantities` (tip, velocity, attitude, …)
        in place of a state; its noise is constant
    keys : what a pen file may say of any sensor (``delay_ms``, ``huber``, ``dropout_fraction``, …,
        see `models.sensor_kinds.mounted.SensorBase`), ``bias_std`` and ``bias_walk``, the deviation
        of an unknown bias in each axis and of its walk, per √s, and ``holds_tip``, whether the
        tip's position stays bounded with it

    Raises
    ------
    InputError
        If a name is taken, a part does not fit, or what it reads is of something else than the pen.
    """
    config = as_pen(pen)
    where = f"pen {config.name}: sensor"
    check_name(name, where)
    if name in config.sensors:
        raise InputError(f"{where} {name} is there already, expected another name")
    check_sensor(name, sensor, where)
    for axis in sensor.axes:
        check_name(axis, f"{where} {name}: axis")
    check_arguments(f"{where} {name}: reads", sensor.reads, ("pen",))
    noise = sensor.noise_std, sensor.noise_covariance
    if noise.count(None) != 1 or varies(*noise):
        raise InputError(
            f"{where} {name}: expected either noise_std or noise_covariance, of numbers"
        )
    given = {"rate_hz": sensor.rate_hz, **keys, "name": name, "own": sensor}
    try:
        added = OwnPenSensor.model_validate(given)
    except ValidationError as error:
        raise InputError(f"{where} {name}: {first_error(error)}") from None
    if added.bias_std > 0 and len({unit for _, unit in added.reading_axes}) > 1:
        raise InputError(f"{where} {name}: its axes have several units, expected no bias_std")
    longer = config.model_copy(update={"sensors": {**config.sensors, name: added}})
    try:
        found = pen_model(longer, [name]).sensor(name)
    except RuntimeError:  # CasADi's, of symbols that are of no pen
        raise InputError(
            f"{where} {name}: its reading has symbols that are not the pen's, "
            "expected an expression of the pen that it is called with"
        ) from None
    if not any(ca.DM(found.h.sparsity_jac(0, 0), 1).full().ravel()):
        raise InputError(f"{where} {name}: its reading does not depend on the pen, expected it to")
    return longer
