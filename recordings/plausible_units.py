"""Units recognised from the data: readings that only make sense in another unit.

Two laws of nature need no reference. A pen feels gravity, so the median of
|f| over a recording of specific force f is near g. And while it moves gently, gravity
turns in its axes as the gyroscope says, see `recordings.turn_factor`.

Evidence is a range of factors that would make the readings plausible. A unit is
refused only if another one in its row of `models.units.UNITS` lies in that range.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimation.recording import Recording
from models.arrays import Array
from models.errors import InputError
from models.pen_config import PenConfig
from models.sensor_kinds.mounted import SensorBase
from models.units import UNITS
from recordings.gravity_felt import felt_gravity
from recordings.turn_factor import turn_factor

GRAVITY_FACTOR = 2.0
"""How far the median of |f| may lie from gravity, either way."""
LARGEST_RATE_RAD_S = math.radians(2200.0)
"""The largest common range, 2000 deg/s, and a tenth for sensors that saturate there."""
RATE_QUANTILE = 0.99

MOST_ROWS, STRETCHES = 100_000, 20
"""Rows of a recording that are looked at, and in how many stretches."""
TURN_FACTOR = 2.0
"""How far k may lie from a unit's factor, either way."""


@dataclass(frozen=True)
class Evidence:
    """The readings, times any factor from low to high, make sense; and what says so."""

    low: float
    high: float
    finding: str


def check_units(
    recording: Recording, pen: PenConfig, *, read_as: Mapping[str, str] | None = None
) -> None:
    """Refuse a recording whose readings only make sense in another unit.

    Parameters
    ----------
    recording : its readings are in SI, converted from the units of `read_as`
    read_as : sensor name → the unit that its columns were read in; a sensor
        that it lacks is not checked, None reads all in SI

    Raises
    ------
    InputError
        The message names the sensor, what was found and the unit that it looks like.
    """
    for refusal in unit_verdicts(recording, pen, read_as=read_as).values():
        if refusal is not None:
            raise refusal


@np.errstate(over="ignore", invalid="ignore")  # readings beyond any unit
def unit_verdicts(
    recording: Recording, pen: PenConfig, *, read_as: Mapping[str, str] | None = None
) -> dict[str, InputError | None]:
    """Return by sensor the refusal of its unit, None where it makes sense; see `check_units`.

    Sensors whose readings do not tell are left out.
    """
    found: dict[str, InputError | None] = {}
    for name, sensor in pen.sensors.items():
        evidence = _evidence(sensor)
        if name not in recording.readings or evidence is None:
            continue
        (axis, si_unit), *_ = sensor.reading_axes
        unit = si_unit if read_as is None else read_as.get(name)
        said = None if unit is None else evidence(recording, pen, name)
        if unit is None or said is None:
            continue
        found[name] = None
        for other, factor in UNITS[si_unit].items():
            if other != unit and said.low <= factor / UNITS[si_unit][unit] <= said.high:
                found[name] = InputError(
                    f"recording {recording.name}: {name} was read in {unit} but looks like "
                    f"{other} ({said.finding}), expected --units {name}={other} or headers "
                    f"like {name}_{axis}_{other}"
                )
                break
    return found


def gravity_evidence(recording: Recording, pen: PenConfig, name: str) -> Evidence | None:
    """Return what the median of |f| says; None of fewer than three axes, or without gravity."""
    if len(pen.sensors[name].reading_axes) < 3:
        return None
    time_s, force = _in_body_axes(recording, pen, name)
    if not felt_gravity(time_s, force, pen.gravity_m_s2).is_there:
        return None
    median = float(np.median(np.linalg.norm(force, axis=1))) if len(force) else 0.0
    if median == 0:
        return None
    factor = pen.gravity_m_s2 / median
    return Evidence(
        factor / GRAVITY_FACTOR,
        factor * GRAVITY_FACTOR,
        f"the median of its norm is {median:.3g} m/s2, but gravity {pen.gravity_m_s2:.3g} m/s2",
    )


def rate_evidence(recording: Recording, pen: PenConfig, name: str) -> Evidence | None:
    """Return what the turning of gravity says of a gyroscope, else what its largest rates say."""
    sensor: Any = pen.sensors[name]
    reference = next((n for n in recording.readings if _feels_gravity(pen, n)), None)
    if reference is not None and len(sensor.axes) == 3:
        k = turn_factor(
            *_in_body_axes(recording, pen, reference), *_in_body_axes(recording, pen, name)
        )
        if k is not None:
            return Evidence(
                k / TURN_FACTOR,
                k * TURN_FACTOR,
                f"its rates are {1 / k:.3g} times as fast as gravity turns in {reference}",
            )
    limit = max(LARGEST_RATE_RAD_S, sensor.range_rad_s or 0.0)
    rates = recording.readings[name]
    largest = float(np.nanquantile(np.abs(rates[spread(len(rates))]), RATE_QUANTILE))
    if largest <= limit:
        return None
    return Evidence(
        0.0,
        limit / largest,
        f"one in a hundred of its rates is beyond {largest:.3g} rad/s, as of no common sensor",
    )


def spread(n: int) -> slice | NDArray[np.int64]:
    """Return which of n rows are looked at: all, or of many as many as tell, in even stretches."""
    if n <= MOST_ROWS:
        return slice(None)
    starts = np.linspace(0, n - MOST_ROWS // STRETCHES, STRETCHES).astype(np.int64)
    return (starts[:, None] + np.arange(MOST_ROWS // STRETCHES)).ravel()


def _feels_gravity(pen: PenConfig, name: str) -> bool:
    sensor = pen.sensors.get(name)
    return sensor is not None and sensor.feels_gravity and len(sensor.reading_axes) == 3


def _evidence(
    sensor: SensorBase,
) -> Callable[[Recording, PenConfig, str], Evidence | None] | None:
    """Return what tells the unit of a sensor's readings; None where nothing does."""
    if sensor.feels_gravity:
        return gravity_evidence
    return rate_evidence if sensor.reads_rate else None


def _in_body_axes(recording: Recording, pen: PenConfig, name: str) -> tuple[Array, Array]:
    """Return the times (n,) of a sensor's complete readings and these (n, 3) in body axes."""
    sensor: Any = pen.sensors[name]
    times, values = (
        part[spread(len(part))] for part in (recording.time_s, recording.readings[name])
    )
    rotation = np.array(sensor.sensor_to_body)[:, ["xyz".index(axis) for axis in sensor.axes]]
    if np.isnan(values.min(initial=0.0)):
        complete = ~np.isnan(values).any(axis=1)
        times, values = times[complete], values[complete]
    return times, values @ rotation.T
