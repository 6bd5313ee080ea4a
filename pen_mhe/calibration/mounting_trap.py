"""Tables of docs/calibrate.md: an IMU's mounting by all innovations and by frames, and profiles.

    python -m pen_mhe.calibration.mounting_trap path/to/dpoint_pen

The ink is for this table only: nothing that is fitted sees it.
"""

from __future__ import annotations

import sys

import numpy as np
from scipy.optimize import minimize

import pen_mhe as pm
from models.arrays import Array
from models.pen_config import PenConfig
from pen_mhe.calibration.camera_fit import Fit, fitted, gathered
from pen_mhe.calibration.frames import Frames
from pen_mhe.calibration.mounted_filter import MountedFilter
from pen_mhe.calibration.mounting import LEVEL, LEVER, OFFSET, TURN, MountingQuantity
from pen_mhe.calibration.mounting_keys import new_values
from pen_mhe.tuning.parameters import with_values
from recordings.ink import Ink, ink_match
from recordings.read import read_written
from recordings.written import WrittenRecording

SENSORS = ("accel", "gyro", "camera")
INK_RATES_HZ = (10.0, 3.0)
STEP = 1e-4
"""Of finite differences, in what is plausible."""


def all_innovations(filtered: MountedFilter, frames: Frames, values: Array) -> float:
    """Return the log likelihood of every sensor's innovations, with all frames."""
    time_s = np.concatenate([frames.frame_s, frames.other_s])
    order = np.lexsort([np.arange(len(time_s)) >= len(frames.frame_s), time_s])
    y = np.concatenate([frames.frame_y, frames.other_y])[order]
    counted = np.flatnonzero(time_s[order] > frames.starts_s)
    rows = np.ones(filtered.base.n_r, dtype=bool)
    return float(filtered.told(values, time_s[order], y, counted, rows=rows).log_density.sum())


def by_all_innovations(filtered: MountedFilter, frames: Frames) -> Array:
    """Return the numbers (k,) of the greatest likelihood of all innovations."""
    scale, start = filtered.plausible_std, np.zeros(len(filtered.numbers))
    offset = all_innovations(filtered, frames, start)

    def lost(x: Array) -> float:
        return offset - all_innovations(filtered, frames, scale * x)

    return np.asarray(scale * minimize(lost, start, method="L-BFGS-B", options={"eps": STEP}).x)


def changed(pen: PenConfig, filtered: MountedFilter, values: Array) -> PenConfig:
    """Return a pen with some numbers."""
    quantities: tuple[MountingQuantity, ...] = (OFFSET, TURN, LEVER, LEVEL)
    ends = np.cumsum([len(quantity.axes) for quantity in quantities])[:-1]
    changes = dict(zip(quantities, np.split(values, ends), strict=True))
    return with_values(pen, new_values(pen, filtered.sensors, changes))


def ink_mm(folder: str, pen: PenConfig, ink: Ink, rate_hz: float) -> float:
    """Return the mean ink distance over all phases of a camera rate, frames at their capture."""
    recording = pm.read_recording(folder, pen)
    ekf = pm.create_estimator("ekf", pm.pen_model(pen, SENSORS))
    every = round(float(pen.sensors["camera"].rate_hz or 0.0) / rate_hz)
    found = []
    for phase in range(every):
        history = pm.run(ekf, recording.subsampled("camera", every, phase))
        is_imu = np.isin(history.time_s, recording.sensor("accel")[0])
        match = ink_match(history[is_imu], ink)
        found.append(np.inf if match is None else match.mean_distance_mm)
    return float(np.mean(found))


def print_profiles(filtered: MountedFilter, frames: Frames, fit: Fit) -> None:
    """Print what frames lose, in nats with each counted once a rate, where one number changes."""

    def score(i: int, change: float) -> float:
        values = fit.values.copy()
        values[i] += change
        evidence = gathered(filtered, frames, values)
        return float(evidence.log_density.sum() / evidence.counted_once)

    best = score(0, 0.0)
    print(
        "\n| number | found | -4 deviations | -2 | +2 | +4 |\n| --- | --- | --- | --- | --- | --- |"
    )
    for i, number in enumerate(filtered.numbers):
        q = number.quantity
        found = f"{q.factor * fit.values[i]:+.3g} ± {q.factor * fit.std[i]:.2g} {q.unit}"
        lost = [f"{score(i, k * fit.std[i]) - best:+.1f}" for k in (-4, -2, 2, 4)]
        print(f"| {number.name} | {found} | {' | '.join(lost)} |", flush=True)


def main(folder: str) -> None:
    """Print the tables."""
    pen = pm.load_pen("dpoint")
    written: WrittenRecording = read_written(folder, pen)
    assert written.ink is not None
    filtered = MountedFilter(pen, SENSORS)
    frames, k = Frames.of(written.recording, filtered.base), len(filtered.numbers)
    start = np.zeros(k)
    before = gathered(filtered, frames, start)
    fit, _ = fitted(filtered, frames, before, free=np.ones(k, dtype=bool))
    rows = {
        "pen file": start,
        "frames only": fit.values,
        "all innovations": by_all_innovations(filtered, frames),
    }
    first = all_innovations(filtered, frames, start)
    print(
        "| by | lever moved (mm) | turned (deg) | all innovations (nats) | frames (nats a frame) |",
        end="",
    )
    print(" ink at 10 Hz (mm) | at 3 Hz (mm) |\n| --- | --- | --- | --- | --- | --- | --- |")
    for name, values in rows.items():
        cells = [
            name,
            f"{1e3 * np.linalg.norm(values[4:7]):.1f}",
            f"{np.degrees(np.linalg.norm(values[1:4])):.2f}",
            f"{all_innovations(filtered, frames, values) - first:+.0f}",
            f"{gathered(filtered, frames, values).log_density.mean():.2f}",
        ]
        new = changed(pen, filtered, values)
        cells += [f"{ink_mm(folder, new, written.ink, rate):.3f}" for rate in INK_RATES_HZ]
        print(f"| {' | '.join(cells)} |", flush=True)
    print_profiles(filtered, frames, fit)


if __name__ == "__main__":
    main(sys.argv[1])
