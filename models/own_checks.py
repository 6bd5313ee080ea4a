"""Parts of a model of one's own: whether they are what they should be at all."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from models.arrays import is_real, is_whole
from models.errors import InputError
from models.own_sensors import OwnSensor
from models.plain_names import check_name, check_text
from models.shown_text import short


def check_parts(
    model: str, n_noises: object, sensors: object, by_name: Mapping[str, object]
) -> None:
    """Raise `InputError` unless there is a number of noises, sensors by name, and mappings.

    Parameters
    ----------
    model : its name
    by_name : what it is → a mapping by name, or None
    """
    if not (is_whole(n_noises) and n_noises >= 0):
        raise InputError(f"model {model}: n_noises is {n_noises!r}, expected a whole number from 0")
    for what, given in {"sensors": sensors, **by_name}.items():
        if given is not None and not isinstance(given, Mapping):
            raise InputError(f"model {model}: {what} are {given!r}, expected a mapping by name")
    assert isinstance(sensors, Mapping)
    check_text(model, "model")
    for name, sensor in sensors.items():
        check_name(name, f"model {model}: sensor {short(name)}")
        check_sensor(name, sensor, f"model {model}: sensor")


def check_sensor(name: str, sensor: object, where: str) -> None:
    """Raise `InputError` unless a sensor is one, with axes and a rate.

    Parameters
    ----------
    where : for messages, in front of its name
    """
    if not isinstance(sensor, OwnSensor):
        raise InputError(f"{where} {name} is {sensor!r}, expected an OwnSensor")
    if not isinstance(sensor.axes, Mapping) or not _are_texts(sensor.axes.values()):
        raise InputError(
            f"{where} {name}: its axes are {sensor.axes!r}, "
            'expected axis → unit ("" where it has none)'
        )
    for axis in sensor.axes:
        check_text(axis, f"{where} {name}: axis")
    rate = sensor.rate_hz
    if rate is not None and not (is_real(rate) and 0 < rate < np.inf):
        raise InputError(
            f"{where} {name}: its rate_hz is {rate!r}, expected a positive number or None"
        )


def _are_texts(values: Iterable[object]) -> bool:
    return all(isinstance(value, str) for value in values)
