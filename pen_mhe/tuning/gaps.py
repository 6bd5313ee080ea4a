"""Noise levels by elevation in gaps of the camera, against the frames that are withheld.

    mean of ½ (e²/s² + log s²)

s² is what is claimed, and the frames' own noise: how far they are from an estimate that has
them all. A gap counts as one reading, however many frames it has: an error stays for a gap.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from models.arrays import Array
from models.errors import InputError
from models.pen_config import PenConfig
from pen_mhe.tuning.parts import ScoredPart
from pen_mhe.tuning.score import NATS, Filter, Judge, Score

GAPS_S = (2.0, 4.0, 6.0, 8.0, 10.0)
"""How long the camera is withheld, one after the other."""
SEEN_S = 1.0
"""How long it is seen between two gaps."""
FEWEST_FRAMES = 30
FIRST_GAPS = (0, 2, 4)
"""With which gap a pass begins: what one pass sees, another withholds."""


def gap_passes(start_s: float, end_s: float) -> list[list[tuple[float, float]]]:
    """Return for each pass the intervals (from, to) in which the camera is withheld."""
    passes = []
    for first in FIRST_GAPS:
        intervals, at, k = [], start_s, first
        while at < end_s:
            gap = GAPS_S[k % len(GAPS_S)]
            intervals.append((at, at + gap))
            at, k = at + gap + SEEN_S, k + 1
        passes.append(intervals)
    return passes


def camera_elevation(readings: Array, sensor_to_body: Array) -> Array:
    """Return the elevation (n,), rad, of a pen in poses of a target on it.

    Parameters
    ----------
    readings : (n, 6) position, m, and rotation vector, rad, of the target in the world
    sensor_to_body : (3, 3) rotation from target axes to body axes
    """
    from scipy.spatial.transform import Rotation  # slow to import

    axis: Any = Rotation.from_rotvec(readings[:, 3:]).apply(sensor_to_body.T[:, 2])
    return np.asarray(np.arcsin(np.clip(axis[:, 2], -1.0, 1.0)))


def by_gaps(part: ScoredPart) -> Judge:
    """Return the judge of a part; `InputError` where no frame can be withheld."""
    cameras = part.cameras
    if not cameras:
        raise InputError("objective without-camera: no camera is among the sensors to withhold")
    if not any(s.constant_reading is None and not s.sees_pose for s in part.model.sensors):
        raise InputError("objective without-camera: no other sensor is left when it is withheld")
    names = [camera.name for camera in cameras]
    time_s, _ = part.stacked
    passes = []
    span = (part.counts_from_s, float(time_s[-1]))
    for gaps in gap_passes(*span):
        hidden = np.any([(time_s >= low) & (time_s < high) for low, high in gaps], axis=0)
        rows, seen = [], []
        for camera in cameras:
            at, frames = part.frames(camera)
            at, frames = at[hidden[at]], frames[hidden[at]]
            turned = part.pen.sensors[camera.name].sensor_to_body  # type: ignore[attr-defined]
            rows.append(at)
            seen.append(camera_elevation(frames, np.array(turned)))
        y = part.without(names, hidden)
        passes.append((y, np.concatenate(rows), np.concatenate(seen)))
    if sum(len(at) for _, at, _ in passes) < FEWEST_FRAMES:
        raise InputError(
            f"recording {part.recording.name}: fewer than {FEWEST_FRAMES} frames of "
            f"{', '.join(names)} to withhold, expected more"
        )

    whole, n_gaps = part.stacked[1], sum(map(len, gap_passes(*span)))

    frame_variance: list[float] = []

    def judged(run: Filter, pen: PenConfig) -> Score:
        if not frame_variance:  # with the file's own numbers, whatever is judged
            elevation = run(part.pen, time_s, whole).column("elevation_rad")
            away = np.concatenate([elevation[at] - seen for _, at, seen in passes])
            frame_variance.append(float(np.mean(away**2)))
        errors, claims = [], []
        for y, at, seen in passes:
            history = run(pen, time_s, y)
            errors.append(history.column("elevation_rad")[at] - seen)
            claims.append(history.std_of("elevation_rad")[at])
        e, claimed = np.concatenate(errors), np.concatenate(claims)
        variance = claimed**2 + frame_variance[0]
        value = float(np.mean(0.5 * (e**2 / variance + np.log(variance))))
        return Score(
            value if math.isfinite(value) else math.inf,
            {
                "nats per frame": value,
                "elevation rms deg": math.degrees(float(np.sqrt(np.mean(e**2)))),
                "elevation claimed deg": math.degrees(float(np.sqrt(np.mean(claimed**2)))),
                "rms (error / claimed)": float(np.sqrt(np.mean(e**2 / variance))),
            },
            NATS / n_gaps,
        )

    return judged
