"""When readings arrive: by stamps of their own, or their sensor's delay after capture."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from estimation.reading_columns import check_mapping
from models.arrays import Array, numbers
from models.errors import InputError
from models.names import expected_one_of
from models.sensor_model import SensorModel
from models.units import TIME_DIGITS


def given_arrivals(
    where: str, time_s: Array, readings: Mapping[str, Array], given: Mapping[str, Any]
) -> dict[str, Array]:
    """Return arrivals (n,) by sensor, s, NaN where it has no reading.

    Parameters
    ----------
    where : ``recording run 3``

    Raises
    ------
    InputError
        If they are no mapping, of no sensor or have another shape, or a reading arrives before
        its capture or at no finite time.
    """
    expected = f"{time_s.shape} seconds"
    check_mapping(given, f"{where}: arrivals", f"sensor name → {expected}")
    if not given:
        return {}
    found = {}
    # Written and read again, a stamp may lie a digit before its capture.
    rounding = np.maximum(10.0**-TIME_DIGITS, 2 * np.spacing(np.abs(time_s)))
    for sensor, values in given.items():
        if sensor not in readings:
            raise InputError(
                f"{where}: arrivals of {sensor}, which has no readings; "
                f"{expected_one_of(sensor, readings)}"
            )
        arrival_s = numbers(values, f"{where}: arrivals of {sensor}", expected)
        if arrival_s.shape != time_s.shape:
            raise InputError(
                f"{where}: arrivals of {sensor} have shape {np.shape(values)}, expected {expected}"
            )
        there = has_reading(readings[sensor])
        wrong = there & ~(np.isfinite(arrival_s) & (arrival_s >= time_s - rounding))
        if wrong.any():
            row = int(np.argmax(wrong))
            raise InputError(
                f"{where}: the reading of {sensor} at {time_s[row]:.12g} s arrives at "
                f"{arrival_s[row]:.12g} s, expected a time not before that"
            )
        found[sensor] = np.where(there, np.maximum(arrival_s, time_s), np.nan)
    return found


def merged_arrivals(
    where: str, time_s: Array, stamps: Mapping[str, Array], given: Mapping[str, Any]
) -> dict[str, Array]:
    """Return arrivals, one per reading of a sensor, on the axis (n,) of all instants.

    Parameters
    ----------
    stamps : sensor → the instants of its readings, each one of `time_s`

    Raises
    ------
    InputError
        If they are of no sensor, or not as many as its readings.
    """
    found = {}
    for sensor, values in given.items():
        if sensor not in stamps:
            raise InputError(
                f"{where}: arrivals of {sensor}, which has no readings; "
                f"{expected_one_of(sensor, stamps)}"
            )
        rows, expected = np.searchsorted(time_s, stamps[sensor]), f"{stamps[sensor].shape} seconds"
        arrival_s = numbers(values, f"{where}: arrivals of {sensor}", expected)
        if arrival_s.shape != rows.shape:
            raise InputError(
                f"{where}: arrivals of {sensor} have shape {np.shape(values)}, expected {expected}"
            )
        found[sensor] = np.full(time_s.shape, np.nan)
        found[sensor][rows] = arrival_s
    return found


def has_reading(values: Array) -> Any:
    """Return where (n,) a sensor's readings (n, n_y) have any number."""
    return ~np.isnan(values).all(axis=1)


def arrival_of(time_s: Array, arrivals: Mapping[str, Array], sensor: SensorModel) -> Array:
    """Return when readings captured at times (n,) arrive: as is known, else the sensor's delay."""
    if sensor.name in arrivals:
        return arrivals[sensor.name]
    if sensor.delay_s == 0:  # to the last bit
        return time_s
    return np.maximum(time_s, np.round(time_s + sensor.delay_s, TIME_DIGITS))
