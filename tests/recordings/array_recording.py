"""A made-up recording of an array of inertial sensors, with its exact truth.

A board with eight sensors rests in poses, is turned from one to the next about an axis fixed
in it, and at last is spun fast. Each accelerometer has a scale, misalignment and bias of its
own, each gyroscope a bias.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]

GRAVITY = 9.81
STEP_S = 0.016
REST_S, TURN_S, SPIN_S = 2.0, 0.8, 3.0
POSES = 14
UNDERSIDE = np.array([[0.0, -1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
POSITIONS = np.array([[x, y, z] for x in (-1, 1) for y in (1, -1) for z in (1, -1)]) * [
    0.00945,
    0.00945,
    0.001,
]


@dataclass(frozen=True, eq=False)
class ArrayTruth:
    """Times (n,), rate and its derivative (n, 3), true forces (n, 8, 3), and what was wrong."""

    time_s: Array
    rate: Array
    rate_derivative: Array
    force: Array
    matrices: Array
    biases: Array


def write_array(folder: Path, seed: int = 0) -> ArrayTruth:
    """Write a recording and return its truth."""
    rng = np.random.default_rng(seed)
    attitude, parts = Rotation.random(random_state=seed), []
    for pose in range(POSES):
        axis = rng.standard_normal(3)
        axis /= np.linalg.norm(axis)
        last = pose == POSES - 1
        angle, duration = (40.0, SPIN_S) if last else (1.5, TURN_S)
        for moves, length in ((False, REST_S), (True, duration)):
            tau = np.arange(round(length / STEP_S)) * STEP_S / length
            scale = angle if moves else 0.0
            turned = scale * (10 * tau**3 - 15 * tau**4 + 6 * tau**5)
            speed = scale * (30 * tau**2 - 60 * tau**3 + 30 * tau**4) / length
            growth = scale * (60 * tau - 180 * tau**2 + 120 * tau**3) / length**2
            here = attitude * Rotation.from_rotvec(np.outer(turned, axis))
            parts.append((here.as_quat(), np.outer(speed, axis), np.outer(growth, axis)))
        attitude = attitude * Rotation.from_rotvec(angle * axis)
    n = round(REST_S / STEP_S)
    parts.append((np.tile(attitude.as_quat(), (n, 1)), np.zeros((n, 3)), np.zeros((n, 3))))
    quaternions, rate, derivative = (np.concatenate(part) for part in zip(*parts, strict=True))
    up = Rotation.from_quat(quaternions).inv().apply([0.0, 0.0, GRAVITY])
    spun = [np.cross(derivative, r) + np.cross(rate, np.cross(rate, r)) for r in POSITIONS]
    force = np.stack([up + one for one in spun], axis=1)
    matrices = np.eye(3) + 0.02 * rng.standard_normal((8, 3, 3))
    biases = 0.3 * rng.standard_normal((8, 3))
    read = np.einsum("iab,nib->nia", matrices, force) + biases
    turning = rate[:, None] + np.radians(rng.standard_normal((8, 3)))
    for values in (read, turning):
        values[:, 1::2] = values[:, 1::2] @ UNDERSIDE  # its own inverse, turned back
    time_s = np.arange(len(rate)) * STEP_S
    folder.mkdir(parents=True, exist_ok=True)
    np.savez(
        folder / "exp_1_raw_int16.npz",
        t=time_s,
        acc=np.clip(np.round(read / 9.80665 * 2048), -32768, 32767).astype(np.int16),
        gyr=np.clip(np.round(np.degrees(turning) * 16.4), -32768, 32767).astype(np.int16),
        pos_m=POSITIONS,
    )
    return ArrayTruth(time_s, rate, derivative, force, matrices, biases)
