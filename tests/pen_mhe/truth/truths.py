"""A simulated recording, and its truth as others would have measured it: shifted, turned, in mm."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

import pen_mhe as pm
from models.arrays import Array
from recordings.truths.of_recording import track_of_truth
from recordings.truths.track import TruthTrack, attitude_of, matrices_of

OFFSET_S = 103.2174
"""What is added to a truth's times here."""
Y_UP = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
WORLD = Rotation.from_rotvec([0, 0, 0.7]).as_matrix() @ Y_UP
MOUNT = Rotation.from_rotvec([0.4, -1.1, 0.3]).as_matrix()
LEVER_M, SHIFT_M = np.array([0.01, -0.12, 0.03]), np.array([0.5, 0.2, -0.1])


@cache
def recording() -> pm.Recording:
    """Return twelve seconds of a simulated hand, seen by a camera."""
    return pm.simulate(
        "reference", ["accel", "gyro", "camera"], motion="handwriting", duration_s=12.0, seed=3
    )


@cache
def exact() -> TruthTrack:
    """Return its true motion as a track that tells place and attitude."""
    truth = recording().truth
    assert truth is not None
    track = track_of_truth(truth, "exact")
    assert track.angles is not None
    return TruthTrack(
        "exact", track.time_s, track.position, attitude_of(track.angles), track.angles,
        is_level=True,
    )  # fmt: skip


def marker(start_s: float = 1.0, end_s: float = 9.0, rate_hz: float = 240.0) -> pd.DataFrame:
    """Return a marker's poses in a world whose y is up, on a clock of its own."""
    t = np.arange(start_s, end_s, 1 / rate_hz)
    turned = WORLD.T @ matrices_of(exact().attitudes(t)) @ MOUNT.T
    place = (exact().positions(t) - SHIFT_M) @ WORLD - turned @ LEVER_M
    q = Rotation.from_matrix(turned).as_quat()
    return _table(
        t - OFFSET_S,
        {f"{axis}_mm": 1e3 * column for axis, column in zip("xyz", place.T, strict=True)}
        | {f"q{axis}": column for axis, column in zip("xyzw", q.T, strict=True)},
    )


def tablet() -> pd.DataFrame:
    """Return the tip on a tablet whose y points down the page: 200 Hz, mm, pen up and down."""
    t = np.arange(0.5, 11.0, 1 / 200)
    cos, sin = np.cos(2.1), np.sin(2.1)
    level = exact().positions(t)[:, :2] - np.array([0.03, -0.02])
    xy = 1e3 * level @ np.array([[cos, -sin], [sin, cos]]) * [1, -1] + 100
    down = np.floor(t / 0.7) % 4 != 3
    stamps = np.round(1e3 * (t - OFFSET_S + 200))
    table = pd.DataFrame({"timestamp_ms": stamps.astype(int), "x": xy[:, 0], "y": xy[:, 1]})
    table["pen_down"] = down.astype(int)
    return table


def angles(*, azimuth_rad: float = 0.0) -> pd.DataFrame:
    """Return azimuth, elevation and spin in degrees at 100 Hz, turned about the vertical."""
    t = np.arange(0.5, 11.0, 0.01)
    turned = exact().angles_at(t) + np.array([azimuth_rad, 0.0, 0.0])
    names = ("azimuth_deg", "elevation_deg", "spin_deg")
    return _table(t - OFFSET_S, dict(zip(names, np.degrees(turned).T, strict=True)))


def written(table: pd.DataFrame, folder: Path, name: str = "truth.csv") -> Path:
    """Write a table and return its path."""
    table.to_csv(folder / name, index=False)
    return folder / name


def _table(time_s: Array, columns: dict[str, Array]) -> pd.DataFrame:
    return pd.DataFrame({"time_s": time_s, **columns})
