"""Made-up readings of a board that is held still in poses, with what is wrong with its sensors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import pen_mhe as pm
from models.pen_file import parse_pen

Array = NDArray[np.float64]

GRAVITY = 9.81
STEP_S = 0.01
TURN_S = 0.8
FORCE_STD, RATE_STD = 0.01, 0.002
"""Of a sample; the pen file says twice as much."""

PHI = (1 + np.sqrt(5)) / 2
TWENTY = np.array(
    [[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    + [
        np.roll([0.0, a / PHI, b * PHI], shift)
        for shift in range(3)
        for a in (-1, 1)
        for b in (-1, 1)
    ]
) / np.sqrt(3)
"""Directions (20, 3) of a dodecahedron's corners: an icosahedron laid on each of its sides."""


@dataclass(frozen=True, eq=False)
class BoardTruth:
    """A recording with its truth: ``y = S f + b``, S symmetric, and a rate's bias."""

    recording: pm.Recording
    S: Array
    bias: Array
    rate_bias: Array

    @property
    def parameters(self) -> Array:
        """(9,) as `pen_mhe.calibration.length.PARAMETERS`; scales as their distance from 1."""
        off = self.S - np.eye(3)
        return np.array([*self.bias, *np.diag(off), off[0, 1], off[0, 2], off[1, 2]])


def board_pen(**accel: object) -> pm.PenConfig:
    """Return a pen with an accelerometer and a gyroscope."""
    bandwidth_hz = 2 / np.pi / STEP_S  # a density of σ √STEP_S then has samples of σ
    return parse_pen(
        {
            "name": "board",
            "gravity_m_s2": GRAVITY,
            "sensors": {
                "accel": {
                    "kind": "accelerometer",
                    "noise_density_m_s2_per_sqrt_hz": 2 * FORCE_STD * np.sqrt(STEP_S),
                    "bandwidth_hz": bandwidth_hz,
                    "bias_std_m_s2": 0.3,
                    **accel,
                },
                "gyro": {
                    "kind": "gyroscope",
                    "noise_density_rad_s_per_sqrt_hz": 2 * RATE_STD * np.sqrt(STEP_S),
                    "bandwidth_hz": bandwidth_hz,
                    "bias_std_rad_s": 0.03,
                },
            },
        }
    )


def board(
    seed: int,
    directions: Array = TWENTY,
    *,
    rest_s: float = 3.0,
    noise: float = 1.0,
    name: str = "board",
) -> BoardTruth:
    """Return a board that rests in poses, (p, 3) directions of "up", and turns between them.

    Parameters
    ----------
    noise : factor on `FORCE_STD` and `RATE_STD`
    """
    rng = np.random.default_rng(seed)
    off = 0.02 * rng.standard_normal((3, 3))
    S, bias = np.eye(3) + (off + off.T) / 2, 0.3 * rng.standard_normal(3)
    rate_bias = np.radians(rng.standard_normal(3))
    n_rest, n_turn = round(rest_s / STEP_S), round(TURN_S / STEP_S)
    ups, rates = [], []
    for i, up in enumerate(directions):
        ups.append(np.tile(up, (n_rest, 1)))
        rates.append(np.zeros((n_rest, 3)))
        if i + 1 < len(directions):
            tau = (np.arange(n_turn) / n_turn)[:, None]
            blend = up + (3 * tau**2 - 2 * tau**3) * (directions[i + 1] + [0.01, 0.02, 0.03] - up)
            ups.append(blend / np.linalg.norm(blend, axis=1, keepdims=True))
            rates.append(np.tile([1.0, 2.0, 3.0], (n_turn, 1)) * np.sin(np.pi * tau))
    force, rate = GRAVITY * np.concatenate(ups), np.concatenate(rates)
    read = force @ S.T + bias + noise * FORCE_STD * rng.standard_normal(force.shape)
    turning = rate + rate_bias + noise * RATE_STD * rng.standard_normal(rate.shape)
    time_s = STEP_S * np.arange(len(force))
    recording = pm.Recording.from_sensors(
        name, {"accel": (time_s, read), "gyro": (time_s, turning)}
    )
    return BoardTruth(recording, S, bias, rate_bias)
