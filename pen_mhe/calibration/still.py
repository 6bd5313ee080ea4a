"""Calibrate inertial sensors on a pen that is held still in poses.

Accelerometers: bias, scale and misalignment from the length of gravity (`gravity`).
Gyroscopes: bias, the mean rate. Both: noise by Allan variance (`allan`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from estimation.recording import Recording
from models.arrays import Array
from models.errors import InputError
from models.names import unknown
from models.pen_config import PenConfig
from models.pen_file import AnyPen, as_pen, pen_name
from models.sensor_kinds.inertial import InertialSensor
from pen_mhe.calibration.allan import NoiseLevels, allan_curve, has_library, noise_levels
from pen_mhe.calibration.given import as_written, recordings_of, sensors_asked
from pen_mhe.calibration.gravity import COUNTS, fit_gravity
from pen_mhe.calibration.length import LengthFit
from pen_mhe.calibration.rate import RateFit, fit_rate
from pen_mhe.calibration.result import StillCalibration
from pen_mhe.calibration.sensor_result import CalibratedSensor
from pen_mhe.calibration.stills import Still, find_stills
from pen_mhe.tuning.parameters import with_values
from pen_mhe.tuning.pen_text import PenText
from recordings.read import read_noted

DEFAULT_FIND = "misalignment"
CLUSTER_S = 0.25
"""Means over so long are taken for independent: what they scatter by says how well a longer mean
is known."""
SMALLEST_STD = 1e-6
"""Of a sample's noise in the pen file: a mean's deviation where readings do not scatter at all."""


def calibrate_still(
    recordings: Recording | str | Path | Sequence[Recording | str | Path],
    pen: AnyPen = "reference",
    *,
    sensors: Sequence[str] | str | None = None,
    find: str = DEFAULT_FIND,
    units: Mapping[str, str] | None = None,
) -> StillCalibration:
    """Find biases, scales, misalignment and noise of inertial sensors from still stretches.

    Parameters
    ----------
    recordings : one with several poses, or several; a recording, or the path of one
    pen : a pen, the name of a bundled one, or the path of a pen file
    sensors : names from the pen file; None takes all inertial ones that every recording has
    find : the most that is looked for, of `pen_mhe.calibration.gravity.COUNTS`: ``noise``,
        ``bias``, ``scale`` (and bias), ``misalignment`` (and both); what is not found stays as
        the pen file has it
    units : of a file's columns, see `recordings.read.read_written`

    Returns
    -------
    The pen with its numbers, which shows itself as a table, and writes itself as a pen file.

    Raises
    ------
    InputError
        If a name is unknown, nothing was still, or poses are too few or too similar.
    """
    if find not in COUNTS:
        raise unknown("find", find, COUNTS)
    config, text = as_pen(pen), PenText.of(pen)
    read = recordings_of(recordings, lambda path: read_noted(path, config, units=units))
    used = _inertial(config, read, sensors)
    stills = find_stills(read, used)
    found = {
        name: CalibratedSensor(
            name,
            sensor,
            _gravity(name, sensor, stills.kept, config, find) if sensor.feels_gravity else None,
            _rate(name, stills.kept, sensor, find) if sensor.reads_rate else None,
            _noise(name, stills.kept),
            _rate_hz(name, stills.kept),
        )
        for name, sensor in used.items()
    }
    values = as_written((each.values() for each in found.values()), text)
    return StillCalibration(
        pen=with_values(config, values),
        find=find,
        stills=stills,
        sensors=found,
        recording_names=tuple(recording.name for recording in read),
        pen_name=pen_name(pen),
        values=values,
        text=text,
        has_noise=has_library(),
    )


def _inertial(
    pen: PenConfig, recordings: Sequence[Recording], names: Sequence[str] | str | None
) -> dict[str, InertialSensor]:
    """Return the sensors to calibrate, by name."""
    known = {name: s for name, s in pen.sensors.items() if isinstance(s, InertialSensor)}
    names = sensors_asked(
        recordings, list(known), names, kind="sensor", example="an accelerometer or gyroscope"
    )
    return {name: known[name] for name in names}


def mean_variances(stills: Sequence[Still], name: str, floor_std: float) -> Array:
    """Return the variances (p, n_axes) of a sensor's mean readings, by noise alone.

    Pooled over stretches, from differences of neighbouring means over `CLUSTER_S`.
    """
    squares = []
    for still in stills:
        values = still.readings[name]
        m = max(1, round(CLUSTER_S * still.rate_hz[name]))
        means = values[: len(values) // m * m].reshape(-1, m, values.shape[1]).mean(axis=1)
        squares.append(np.diff(means, axis=0) ** 2 / 2 * m)
    of_one = np.concatenate(squares).mean(axis=0)
    counts = np.array([len(still.readings[name]) for still in stills])
    return np.maximum(of_one, floor_std**2) / counts[:, None]


def _gravity(
    name: str, sensor: InertialSensor, stills: Sequence[Still], pen: PenConfig, find: str
) -> LengthFit | None:
    if not COUNTS[find]:
        return None
    if sorted(sensor.axes) != ["x", "y", "z"]:
        raise InputError(
            f"{name} has the axes {', '.join(sensor.axes)} only, expected three to compare with "
            "gravity; or --find noise"
        )
    order = np.argsort(sensor.axes)
    means = np.array([still.mean(name) for still in stills])[:, order]
    variances = mean_variances(stills, name, SMALLEST_STD * sensor.sample_std)[:, order]
    return fit_gravity(
        means,
        variances,
        pen.gravity_m_s2,
        find,
        bias=np.array(sensor.bias),
        sensitivity=np.array(sensor.sensitivity),
        name=name,
    )


def _rate(name: str, stills: Sequence[Still], sensor: InertialSensor, find: str) -> RateFit | None:
    if not COUNTS[find]:
        return None
    means = np.array([still.mean(name) for still in stills])
    return fit_rate(means, mean_variances(stills, name, SMALLEST_STD * sensor.sample_std))


def _rate_hz(name: str, stills: Sequence[Still]) -> float:
    return float(np.median([still.rate_hz[name] for still in stills]))


def _noise(name: str, stills: Sequence[Still]) -> NoiseLevels | None:
    if not has_library():
        return None
    curve = allan_curve([still.readings[name] for still in stills], _rate_hz(name, stills))
    return None if curve is None else noise_levels(curve)
