"""Calibrate how a pen's sensors are mounted, by how well they predict its camera's frames.

Delay (or offset of the camera's clock), turn and lever arm of the inertial sensors, level and
slope of the paper. Neither ink nor truth takes part, and inertial readings are not judged: the
likelihood of all innovations moves what is mounted to where it explains their noise.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from estimation.recording import Recording
from models.arrays import Array
from models.errors import InputError
from models.names import several, unknown
from models.pen_config import PenConfig
from models.pen_file import AnyPen, as_pen, pen_name
from pen_mhe.calibration.camera_fit import Fit, FrameEvidence, Progress, fitted, gathered, solved
from pen_mhe.calibration.camera_result import CameraCalibration, RateScore
from pen_mhe.calibration.frames import Frames
from pen_mhe.calibration.halves import in_halves, worth_taking
from pen_mhe.calibration.mounted_filter import MountedFilter
from pen_mhe.calibration.mounting import HEIGHT, OFFSET, MountingQuantity
from pen_mhe.calibration.mounting_keys import new_values
from pen_mhe.tuning.parameters import with_values
from pen_mhe.tuning.pen_text import PenText
from recordings.read import read_recording, read_written

PROBED = 1e-3
"""Change of a delay (s) and of a height (m) to see whether a recording's readings follow."""


def calibrate_camera(
    recording: Recording | str | Path,
    pen: AnyPen = "reference",
    *,
    sensors: Sequence[str] | str | None = None,
    units: Mapping[str, str] | None = None,
    on_progress: Progress | None = None,
) -> CameraCalibration:
    """Find delay, turn, lever arm, level and slope from a recording with a camera.

    Parameters
    ----------
    recording : of a pen that moves and turns as it does in use, or the path of one
    pen : a pen, the name of a bundled one, or the path of a pen file
    sensors : names from the pen file; None takes all that the recording has
    units : of a file's columns, see `recordings.read.read_written`
    on_progress : called with the round's number and the mean log density of a frame

    Returns
    -------
    The pen with its numbers, which shows itself as a table, and writes itself as a pen file.

    Raises
    ------
    InputError
        If a name is unknown, camera or inertial sensors are missing, or frames tell nothing.
    """
    config, text = as_pen(pen), PenText.of(pen)
    path = None if isinstance(recording, Recording) else recording
    if not isinstance(recording, Recording):
        recording = read_recording(recording, config, units=units)
    used = _used(config, recording, sensors)
    filtered = MountedFilter(config, used)
    frames = Frames.of(recording, filtered.base)
    free = np.ones(len(filtered.numbers), dtype=bool)
    before = gathered(filtered, frames, np.zeros(len(filtered.numbers)))
    whole, after = fitted(filtered, frames, before, free=free, on_progress=on_progress)
    fit, kept = whole, worth_taking(after, filtered.numbers, whole.told)
    if not kept.any():
        raise InputError(
            f"recording {recording.name}: what one half finds predicts the other worse than pen "
            f"{config.name} does, expected a longer recording, or nothing to be found"
        )
    if (kept != whole.told).any():
        fit, after = fitted(filtered, frames, before, free=kept, on_progress=on_progress)
    fixed = {HEIGHT, OFFSET} - _followed(path, recording, config, used, units)
    changes = {q: v for q, v in _changes(filtered, fit).items() if q not in fixed}
    values = new_values(config, used, changes)
    if text is not None:
        values = {p: text.written(p, value) for p, value in values.items()}
    halves = tuple(solved(half, fit.told) for half in in_halves(after))
    others = [gathered(filtered, frames, half.values) for half in halves]
    return CameraCalibration(
        pen=with_values(config, values),
        sensors=tuple(used),
        numbers=filtered.numbers,
        fit=fit,
        whole=whole,
        halves=halves,
        scores=_scores(frames, before, after, others),
        frame_count=frames.count,
        recording_name=recording.name if path is None else str(path),
        pen_name=pen_name(pen),
        values=values,
        fixed=frozenset(fixed),
        delay_s=next(s.delay_s for n, s in config.sensors.items() if n in used and s.sees_pose),
        text=text,
    )


def _used(
    pen: PenConfig, recording: Recording, names: Sequence[str] | str | None
) -> tuple[str, ...]:
    """Return the sensors to calibrate with: one camera, and inertial ones."""
    if names is None:
        names = [name for name in pen.sensors if name in recording.readings]
    for name in (names := several(names)):
        if name not in pen.sensors:
            raise unknown("sensor", name, pen.sensors)
        recording.sensor(name)
    chosen = [pen.sensors[name] for name in names]
    cameras = sum(sensor.sees_pose for sensor in chosen)
    if cameras != 1:
        raise InputError(
            f"recording {recording.name} with {', '.join(names) or 'no sensor'} of pen {pen.name} "
            f"has {cameras or 'no'} pose_camera{'s' * (cameras > 1)}, expected one to calibrate by"
        )
    if not any(sensor.reads_rate for sensor in chosen):
        raise InputError(
            f"recording {recording.name} has no gyroscope of pen {pen.name}, expected one: between "
            "frames nothing else tells how the pen turns"
        )
    if pen.printed_errors:
        raise InputError(f"pen {pen.name} has printed_errors, expected the rigid body")
    return tuple(names)


def _changes(filtered: MountedFilter, fit: Fit) -> dict[MountingQuantity, Array]:
    """Return quantity → its numbers, of those of which any is told."""
    found = {}
    for quantity in dict.fromkeys(n.quantity for n in filtered.numbers):
        own = np.array([n.quantity is quantity for n in filtered.numbers])
        if fit.told[own].any():
            found[quantity] = fit.values[own]
    return found


def _followed(
    path: str | Path | None,
    recording: Recording,
    pen: PenConfig,
    used: Sequence[str],
    units: Mapping[str, str] | None,
) -> set[MountingQuantity]:
    """Return which of delay and height a file's readings are made with, so that its pen has them.

    Stamps of capture, and heights that were recorded, are the recording's own.
    """
    if path is None:
        return set()
    probe = new_values(pen, used, {OFFSET: np.array([-PROBED]), HEIGHT: np.array([PROBED])})
    again = read_written(path, with_values(pen, probe), units=units).recording

    def differs(what: str) -> bool:
        name = next((n for n in used if getattr(pen.sensors[n], what)), None)
        if name is None:
            return False
        pairs: Any = zip(recording.sensor(name), again.sensor(name), strict=True)
        return not all(np.array_equal(a, b, equal_nan=True) for a, b in pairs)

    found = {OFFSET: differs("sees_pose"), HEIGHT: differs("reads_touch")}
    return {quantity for quantity, follows in found.items() if follows}


def _scores(
    frames: Frames, before: FrameEvidence, after: FrameEvidence, others: Sequence[FrameEvidence]
) -> tuple[RateScore, ...]:
    """Return a score per rate: mean log density of a frame before, after, by the other half.

    Parameters
    ----------
    others : with what the first half found, and the second
    """
    second, first = (in_halves(each)[1 - i] for i, each in enumerate(others))

    def mean(every: int, *parts: FrameEvidence) -> float:
        return float(np.concatenate([p.log_density[p.every == every] for p in parts]).mean())

    return tuple(
        RateScore(rate_hz, mean(every, before), mean(every, after), mean(every, first, second))
        for every, rate_hz in frames.choices.items()
    )
