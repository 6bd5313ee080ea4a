"""Fewer camera frames than were recorded, and the error against those left out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from estimation.arrivals import arrival_of
from estimation.estimate import EstimateHistory
from estimation.recording import Recording
from models.arrays import Array
from models.errors import InputError
from models.sensor_model import SensorModel
from models.state_space import StateSpaceModel

RATE_TOLERANCE = 0.1


def frames_per_kept(recorded_rate_hz: float | None, rate_hz: float) -> int:
    """Return m such that every m-th frame makes `rate_hz`; it must divide the recorded rate.

    Raises
    ------
    InputError
        If it does not, or there is no recorded rate.
    """
    if recorded_rate_hz is None:
        raise InputError("camera without rate_hz in the pen file, expected one to lower its rate")
    every = round(recorded_rate_hz / rate_hz) if rate_hz > 0 else 0
    if every < 1 or abs(every * rate_hz - recorded_rate_hz) > 1e-6 * recorded_rate_hz:
        raise InputError(
            f"camera rate {rate_hz:g} Hz does not divide the recorded {recorded_rate_hz:g} Hz"
        )
    return every


def check_recorded_rate(sensor: SensorModel, recording: Recording) -> None:
    """Refuse a recording whose camera ran at another rate than its pen file says.

    Raises
    ------
    InputError
        If it did.
    """
    times, _ = recording.sensor(sensor.name)
    if len(times) > 1:
        check_rate(sensor, recording.name, float(np.median(np.diff(times))))


def check_rate(sensor: SensorModel, name: str, interval_s: float) -> None:
    """Refuse a recording by its name and the median time between a camera's frames.

    Raises
    ------
    InputError
        If its pen file says another rate.
    """
    if sensor.rate_hz is None:
        return
    rate_hz = 1 / interval_s
    if abs(rate_hz - sensor.rate_hz) > RATE_TOLERANCE * sensor.rate_hz:
        raise InputError(
            f"recording {name}: {sensor.name} ran at {rate_hz:.3g} Hz, "
            f"expected the pen file's {sensor.rate_hz:g} Hz"
        )


@dataclass(frozen=True)
class CameraThinning:
    """Keep only the frames whose index ≡ phase, modulo recorded rate / `rate_hz`."""

    rate_hz: float
    phase: int = 0


def thinned(model: StateSpaceModel, recorded: Recording, thinning: CameraThinning) -> Recording:
    """Return a recording with fewer frames of a model's one camera.

    Raises
    ------
    InputError
        If there is not exactly one camera, it ran at another rate than its pen file says,
        or rate or phase do not fit that.
    """
    camera = thinned_camera(model)
    check_recorded_rate(camera, recorded)
    return recorded.subsampled(camera.name, kept_of(camera, thinning), thinning.phase)


def thinned_camera(model: StateSpaceModel) -> SensorModel:
    """Return a model's one camera; raises `InputError` unless there is exactly one."""
    cameras = [sensor for sensor in model.sensors if sensor.sees_pose]
    if len(cameras) != 1:
        raise InputError("camera rate given, expected exactly one pose_camera among the sensors")
    return cameras[0]


def kept_of(camera: SensorModel, thinning: CameraThinning) -> int:
    """Return m such that every m-th frame is kept; raises `InputError` for a rate or phase."""
    every = frames_per_kept(camera.rate_hz, thinning.rate_hz)
    if not 0 <= thinning.phase < every:
        raise InputError(f"camera phase {thinning.phase}, expected 0 to {every - 1}")
    return every


@dataclass(frozen=True)
class LeftOutError:
    """RMS of an estimate against frames that it was not given, per unit of the residual."""

    frames: int
    rms: dict[str, float]


def left_out_error(
    model: StateSpaceModel,
    sensor: SensorModel,
    history: EstimateHistory,
    recorded: Recording,
    used: Recording,
) -> LeftOutError | None:
    """Compare an estimate with the readings of a sensor that were left out.

    The newest estimate before a frame is predicted to the frame's time, so no
    later measurement takes part. Frames count from when the first one that was given arrived.

    Returns
    -------
    None where no frame was left out after the first estimate.
    """
    history = history.first_told()
    times, frames = recorded.sensor(sensor.name)
    used_times, _ = used.sensor(sensor.name)
    left_out = ~np.isin(times, used_times)
    arrives = arrival_of(used.time_s, used.arrivals, sensor)[used.time_s == used_times[0]]
    begins = max(history.time_s[0], float(arrives[0]))
    known = left_out & (times >= begins) & (times <= history.time_s[-1])
    if not known.any():
        return None
    times, frames = times[known], frames[known]
    squares = residual_squares(
        model, sensor, times, frames, time_s=history.time_s, mean=history.mean
    )
    return LeftOutError(len(times), rms_by_unit(sensor, squares.mean(axis=1)))


def residual_squares(
    model: StateSpaceModel,
    sensor: SensorModel,
    times: Array,
    frames: Array,
    *,
    time_s: Array,
    mean: Array,
) -> Array:
    """Return squared residuals (n_r, m) of frames (m, n_y) from the newest estimates before them.

    Parameters
    ----------
    times : (m,) of the frames, none before the first estimate
    time_s, mean : (n,) ascending and (n, n_x), the estimates
    """
    newest = np.searchsorted(time_s, times, side="right") - 1
    dt = times - time_s[newest]
    x = model.f(mean[newest].T, np.zeros((model.n_w, len(dt))), dt[None])
    squares: Array = np.asarray(sensor.residual(frames.T, x)) ** 2
    return squares


def rms_by_unit(sensor: SensorModel, mean: Array) -> dict[str, float]:
    """Return the RMS per unit of the mean squares (n_r,) of a sensor's residual."""
    return {
        unit: float(
            np.sqrt(sum(m for m, u in zip(mean, sensor.unit_of_row, strict=True) if u == unit))
        )
        for unit in dict.fromkeys(sensor.unit_of_row)
    }
