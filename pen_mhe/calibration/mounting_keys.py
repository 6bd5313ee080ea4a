"""What a pen file says of how sensors are mounted, with numbers that were found."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from models.arrays import Array
from models.errors import InputError
from models.pen_config import PenConfig
from pen_mhe.calibration.mounting import HEIGHT, LEVEL, LEVER, OFFSET, SLOPE, TURN, MountingQuantity
from pen_mhe.tuning.parameters import SENSORS, Parameter

ROLE = "mounting"


def new_values(
    pen: PenConfig, sensors: Sequence[str], changes: Mapping[MountingQuantity, Array]
) -> dict[Parameter, Any]:
    """Return what the keys of a pen file become, SI.

    Parameters
    ----------
    sensors : that were used; inertial ones are turned and moved together
    changes : quantity → the change of its numbers; one that stays is not among them

    Raises
    ------
    InputError
        If a camera's delay becomes negative.
    """
    found: dict[tuple[tuple[str, ...], str], Any] = {}
    if LEVEL in changes:
        found[(), "level_rad"] = _moved(pen.level_rad, changes[LEVEL])
    for name in sensors:
        table, sensor = (SENSORS, name), pen.sensors[name]
        has: Any = sensor  # its fields are known by what it does
        if sensor.sees_pose and OFFSET in changes:
            delay_s = float(sensor.delay_s - changes[OFFSET][0])
            if delay_s < 0:
                raise InputError(
                    f"sensor {name}: frames say that its delay is {1e3 * delay_s:.3g} ms, expected "
                    "stamps that are not before the capture"
                )
            found[table, "delay_s"] = delay_s
        if sensor.feels_gravity or sensor.reads_rate:
            if TURN in changes:
                turned = Rotation.from_rotvec(changes[TURN]).as_matrix() @ has.sensor_to_body
                found[table, "sensor_to_body"] = tuple(map(tuple, turned.tolist()))
            if LEVER in changes:
                found[table, "position_m"] = _moved(has.position_m, changes[LEVER])
        if sensor.reads_touch and SLOPE in changes:
            found[table, "slope"] = _moved(has.slope, changes[SLOPE])
        if sensor.reads_touch and HEIGHT in changes:
            found[table, "height_m"] = float(has.height_m + changes[HEIGHT][0])
    return {Parameter(ROLE, table, field): value for (table, field), value in found.items()}


def _moved(told: Sequence[float], change: Array) -> tuple[float, ...]:
    return tuple((np.array(told) + change).tolist())
