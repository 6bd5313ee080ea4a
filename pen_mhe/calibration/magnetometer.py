"""Calibrate magnetometers on a recording of a pen that is turned about, far from iron.

Hard iron, a bias, and soft iron, a symmetric sensitivity, from the length of the Earth's field in
every attitude: `ellipsoid` begins, `length` ends. Noise is what neighbouring readings differ by
beyond a steady turn. Where an accelerometer reads beside it and hardly more than gravity, the
angle between both is the field's dip.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from estimation.recording import Recording
from models.arrays import Array
from models.errors import InputError
from models.pen_config import PenConfig
from models.pen_file import AnyPen, as_pen, pen_name
from pen_mhe.calibration.ellipsoid import ellipsoid
from pen_mhe.calibration.given import (
    as_written,
    complete_readings,
    recordings_of,
    sensors_asked,
)
from pen_mhe.calibration.length import N_BIAS, PARAMETERS, fit_length
from pen_mhe.calibration.magnetometer_result import (
    CalibratedMagnetometer,
    MagnetometerCalibration,
)
from pen_mhe.tuning.parameters import with_values
from pen_mhe.tuning.pen_text import PenText
from recordings.read import read_recording

FEWEST, MOST = 100, 5000
"""Readings; of more, as many are taken, spread over all."""
NEAR_GRAVITY_M_S2 = 0.3
"""Of |f|: a hand that turns a pen slowly hardly accelerates it."""


def calibrate_magnetometer(
    recordings: Recording | str | Path | Sequence[Recording | str | Path],
    pen: AnyPen,
    *,
    sensors: Sequence[str] | str | None = None,
    units: Mapping[str, str] | None = None,
) -> MagnetometerCalibration:
    """Find hard iron, soft iron and noise of magnetometers from a pen that is turned about.

    Parameters
    ----------
    recordings : one or several; a recording, or the path of one
    pen : the path of a pen file, or a pen; its `field_strength_ut` is the length of the field
    sensors : names from the pen file; None takes all magnetometers that every recording has
    units : of a file's columns, see `recordings.read.read_written`

    Returns
    -------
    The pen with its numbers, which shows itself as a table, and writes itself as a pen file.

    Raises
    ------
    InputError
        If a name is unknown, or the turns are too few to tell the numbers apart.
    """
    config, text = as_pen(pen), PenText.of(pen)
    read = recordings_of(recordings, lambda path: read_recording(path, config, units=units))
    known = [name for name, s in config.sensors.items() if s.field_strength is not None]
    names = sensors_asked(read, known, sensors, kind="magnetometer", example="a magnetometer")
    found = {name: _calibrated(name, config, read) for name in names}
    values = as_written((each.values() for each in found.values()), text)
    return MagnetometerCalibration(
        pen=with_values(config, values),
        sensors=found,
        recording_names=tuple(recording.name for recording in read),
        pen_name=pen_name(pen),
        values=values,
        text=text,
    )


def _calibrated(
    name: str, pen: PenConfig, recordings: Sequence[Recording]
) -> CalibratedMagnetometer:
    sensor: Any = pen.sensors[name]
    if sorted(sensor.axes) != ["x", "y", "z"]:
        raise InputError(
            f"{name} has the axes {', '.join(sensor.axes)} only, expected three to compare with "
            "the field's strength"
        )
    order = np.argsort(sensor.axes)
    series = [complete_readings(each, name)[1][:, order] for each in recordings]
    readings = np.concatenate(series)
    if len(readings) < FEWEST:
        raise InputError(
            f"{name} has {len(readings)} complete readings, expected at least {FEWEST}"
        )
    noise = _noise(series)
    rows = np.unique(np.linspace(0, len(readings) - 1, MOST).astype(int))
    readings, strength = readings[rows], sensor.field_strength_ut
    first = ellipsoid(readings, strength)
    too_similar = (
        f"{name}: its turns are too few to tell {{0}} from {{1}}, expected the pen turned about "
        "all its axes, tip up and down"
    )
    if first is None:
        raise InputError(too_similar.format(*PARAMETERS[:2]))
    fit = fit_length(
        readings,
        np.full(readings.shape, max(noise, 1e-6 * strength) ** 2),
        float(np.hypot(strength, np.sqrt(2) * noise)),  # noise across it makes it longer
        len(PARAMETERS),
        bias=first[0],
        sensitivity=first[1],
        too_similar=too_similar,
    )
    before = np.linalg.norm(
        np.linalg.solve(np.array(sensor.sensitivity), (readings - np.array(sensor.bias)).T), axis=0
    )
    return CalibratedMagnetometer(
        name=name,
        sensor=sensor,
        fit=fit,
        off_before_ut=float(np.sqrt(np.mean((before - strength) ** 2))),
        noise_ut=noise,
        n_noise=sum(map(len, series)) * N_BIAS,
        dip_rad=_dip(name, pen, recordings, fit.bias, fit.sensitivity),
    )


def _noise(series: Sequence[Array]) -> float:
    """Return the deviation of a reading's noise, by second differences: a steady turn has none."""
    steps = np.concatenate([np.diff(values, 2, axis=0) for values in series])
    return float(np.sqrt(np.mean(steps**2) / 6)) if len(steps) else 0.0


def _dip(
    name: str, pen: PenConfig, recordings: Sequence[Recording], bias: Array, sensitivity: Array
) -> tuple[float, float] | None:
    """Return the field's dip and its deviation, rad, where an accelerometer tells it.

    Dip is how far the field is below level: f points up at rest.
    """
    field: Any = pen.sensors[name]
    for other, sensor in pen.sensors.items():
        if not (sensor.feels_gravity and len(sensor.reading_axes) == 3):
            continue
        force: Any = sensor
        found = []
        for each in recordings:
            if other not in each.readings:
                continue
            times, read = complete_readings(each, other)
            at, m = complete_readings(each, name)
            f = np.linalg.solve(
                np.array(force.sensitivity), (read[:, np.argsort(force.axes)] - force.bias).T
            ).T
            near = np.abs(np.linalg.norm(f, axis=1) - pen.gravity_m_s2) < NEAR_GRAVITY_M_S2
            _, rows, others = np.intersect1d(times[near], at, return_indices=True)
            up = f[near][rows] @ np.array(force.sensor_to_body).T
            of_field = m[others][:, np.argsort(field.axes)] - bias
            north = np.linalg.solve(sensitivity, of_field.T).T @ np.array(field.sensor_to_body).T
            lengths = np.linalg.norm(up, axis=1) * np.linalg.norm(north, axis=1)
            found.append(-np.arcsin((up * north).sum(axis=1) / lengths))
        dips = np.concatenate(found) if found else np.zeros(0)
        if len(dips) >= FEWEST:
            return float(np.median(dips)), float(dips.std())
    return None
