"""A truth out of a recording: its true states, or what a camera of the pen saw."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from estimation.recording import Recording
from estimation.truth import Truth
from models.arrays import Array
from models.errors import InputError
from models.pen_file import AnyPen, as_pen
from recordings.truths.columns import TIP
from recordings.truths.track import ANGLES, TruthTrack


def track_of_recording(recording: Recording, pen: AnyPen) -> TruthTrack:
    """Return the tip and the pen's attitude by a recording's true states, else by its camera.

    Raises
    ------
    InputError
        If it has neither.
    """
    truth, name = recording.truth, recording.name
    if truth is not None:
        return track_of_truth(truth, name)
    for sensor, config in as_pen(pen).sensors.items():
        if config.sees_pose and sensor in recording.readings:
            time_s, pose = recording.sensor(sensor)
            return _seen(name, sensor, config, time_s, pose)
    raise InputError(
        f"truth {name}: no true states and no camera of the pen, expected a recording with one"
    )


def track_of_truth(truth: Truth, name: str) -> TruthTrack:
    """Return the tip and the angles that true states name.

    Raises
    ------
    InputError
        If they name neither.
    """
    places = TIP if set(TIP) <= set(truth.names) else TIP[:2]
    tip = _columns(truth, places) if set(places) <= set(truth.names) else None
    angles = _columns(truth, ANGLES) if set(ANGLES) & set(truth.names) else None
    if tip is None and angles is None:
        raise InputError(
            f"truth {name}: true states {', '.join(truth.names[:12])}, "
            f"expected some of {', '.join(TIP + ANGLES)}"
        )
    said = (f"{name}: its true states",)
    return TruthTrack(name, truth.time_s, tip, angles=angles, is_level=True, said=said)


def _columns(truth: Truth, names: Sequence[str]) -> Array:
    found = np.full((len(truth.time_s), len(names)), np.nan)
    for k, name in enumerate(names):
        if name in truth.names:
            found[:, k] = truth.values[:, truth.names.index(name)]
    return found


def _seen(name: str, sensor: str, config: Any, time_s: Array, pose: Array) -> TruthTrack:
    """Return the tip and the pen's attitude by a camera whose target has a known place on it."""
    turned = Rotation.from_rotvec(pose[:, 3:]) * Rotation.from_matrix(config.sensor_to_body).inv()
    tip = pose[:, :3] - turned.apply(config.position_m)
    return TruthTrack(
        name, time_s, tip, turned.as_quat(), is_level=True, said=(f"{name}: what {sensor} saw",)
    )
