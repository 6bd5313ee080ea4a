"""An array of inertial sensors on one board: read, calibrated on its still moments.

Eight MPU-9150 at the corners of a board, held still in many poses and then shaken. The
accelerometers are calibrated against gravity: with a_ip the mean reading of sensor i in
pose p, and u_p the direction of gravity's reaction there, equal for all sensors,

    M_i a_ip + b_i = g u_p,    |u_p| = 1,

solved in turns for (M_i, b_i) by least squares, and for u_p as the mean direction over the
sensors. What the poses leave open, one rotation of all of it, is that of the mean sensor.

References
----------
Carlsson, Skog, Jaldén (2021), Self-calibration of inertial sensor arrays, IEEE Sensors
Journal 21(6), doi 10.1109/JSEN.2021.3050010: the recording, and calibration in turns.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from models.arrays import Array
from models.border import reading
from models.errors import InputError
from models.units import STANDARD_GRAVITY_M_S2
from recordings.formats.archives import read_arrays

FILE = "exp_1_raw_int16.npz"
KEYS = {"t": 1, "acc": 3, "gyr": 3, "pos_m": 2}
"""Key of the file → dimensions of its array."""

ACCELERATION_PER_COUNT = STANDARD_GRAVITY_M_S2 / 2048
RATE_PER_COUNT = math.radians(1 / 16.4)
LARGEST_COUNT = 32_000
"""Readings from here on count as clipped: the range ends at 32767."""

UNDERSIDE = np.array([[0.0, -1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
"""Every second sensor is on the underside: from its axes to the board's."""

STILL_RATE_RAD_S = math.radians(3.0)
STILL_S = 1.0
"""A pose is this long without a faster rate; its ends are left out."""

FEWEST_POSES = 8
TURNS = 2000
CONVERGED = 1e-12


@dataclass(frozen=True, eq=False)
class ImuArray:
    """Readings of k sensors in axes of the board.

    Parameters
    ----------
    time_s : (n,)
    force : (n, k, 3) specific forces, m/s²
    rate : (n, k, 3) angular rates, rad/s
    position_m : (k, 3)
    clipped : (n, k) true where a sensor was at the end of a range
    """

    time_s: Array
    force: Array
    rate: Array
    position_m: Array
    clipped: NDArray[np.bool_]

    @cached_property
    def mean_rate(self) -> Array:
        """(n, 3) mean over the sensors that are not clipped, NaN where all are."""
        rate = np.where(self.clipped[..., None], 0.0, self.rate)
        count = (~self.clipped).sum(axis=1)[:, None]
        return np.where(count > 0, rate.sum(axis=1) / np.maximum(count, 1), np.nan)


def read_imu_array(folder: str | Path) -> ImuArray:
    """Read the recording, not calibrated.

    Raises
    ------
    InputError
        If the file is missing or lacks an array; the message names it.
    """
    path = Path(folder) / FILE
    with reading(f"IMU array {path}", "a NumPy .npz file"):
        return _read(path)


def _read(path: Path) -> ImuArray:
    arrays = read_arrays(path, KEYS, f"IMU array {path}")
    for key, dimensions in KEYS.items():
        if key not in arrays or arrays[key].ndim != dimensions:
            raise InputError(f"IMU array {path}: key {key}: expected {dimensions} dimensions")
        if arrays[key].dtype.kind not in "iuf":
            raise InputError(
                f"IMU array {path}: key {key} has {arrays[key].dtype}, expected numbers"
            )
    acc, gyr, position = arrays["acc"], arrays["gyr"], arrays["pos_m"]
    expected = (len(arrays["t"]), len(position), 3)
    if acc.shape != expected or gyr.shape != expected:
        raise InputError(f"IMU array {path}: shapes {acc.shape}, {gyr.shape}, expected {expected}")
    # Counts are 16 bit: the size of -32768 is not.
    counts = np.maximum(*(np.abs(raw.astype(float)).max(axis=2) for raw in (acc, gyr)))
    force, rate = acc * ACCELERATION_PER_COUNT, gyr * RATE_PER_COUNT
    for readings in (force, rate):
        readings[:, 1::2] = readings[:, 1::2] @ UNDERSIDE.T
    return ImuArray(arrays["t"], force, rate, position, counts >= LARGEST_COUNT)


def calibrated(array: ImuArray, gravity_m_s2: float) -> ImuArray:
    """Return the array with calibrated accelerometers, and gyroscopes without their bias.

    Raises
    ------
    InputError
        If there are too few still poses.
    """
    poses = still_poses(array)
    if len(poses) < FEWEST_POSES:
        raise InputError(
            f"IMU array: {len(poses)} still poses of {STILL_S:g} s, expected at least "
            f"{FEWEST_POSES} to calibrate on"
        )
    means = np.array([array.force[pose].mean(axis=0) for pose in poses])
    M, b = affine_calibration(means, gravity_m_s2)
    force = np.einsum("iab,nib->nia", M, array.force) + b
    bias = np.concatenate([array.rate[pose] for pose in poses]).mean(axis=0)
    return dataclasses.replace(array, force=force, rate=array.rate - bias)


def still_poses(array: ImuArray) -> list[slice]:
    """Return the still stretches of at least `STILL_S`, without their first and last tenth."""
    # Most of the recording is still: the median is the bias.
    size = np.linalg.norm(np.median(array.rate - np.median(array.rate, axis=0), axis=1), axis=1)
    ends = np.flatnonzero(np.diff(np.concatenate([[0], size < STILL_RATE_RAD_S, [0]]).astype(int)))
    poses = []
    for start, end in ends.reshape(-1, 2):
        margin = (end - start) // 10
        if array.time_s[end - 1] - array.time_s[start] >= STILL_S:
            poses.append(slice(start + margin, end - margin))
    return poses


def affine_calibration(means: Array, gravity_m_s2: float) -> tuple[Array, Array]:
    """Return M (k, 3, 3) and b (k, 3) of M a + b, from mean readings in still poses.

    Parameters
    ----------
    means : (p, k, 3) of p poses and k sensors, m/s²
    gravity_m_s2 : length of what they should read
    """
    n_poses, n_sensors = means.shape[:2]
    augmented = np.concatenate([means, np.ones((n_poses, n_sensors, 1))], axis=2).swapaxes(0, 1)
    inverse = np.linalg.pinv(augmented)  # (k, 4, p)
    onto = (augmented @ inverse).mean(axis=0)
    first = u = _unit(means.mean(axis=1))
    for _ in range(TURNS):
        before, u = u, _unit(onto @ u)
        if np.abs(u - before).max() < CONVERGED:
            break
    left, _, right = np.linalg.svd(first.T @ u)
    turn = left @ np.diag([1, 1, np.linalg.det(left @ right)]) @ right
    theta = inverse @ (gravity_m_s2 * u @ turn.T)  # (k, 4, 3)
    return theta[:, :3].swapaxes(1, 2), theta[:, 3]


def _unit(vectors: Array) -> Array:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))
