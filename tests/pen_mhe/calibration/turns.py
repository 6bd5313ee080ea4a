"""Made-up readings of a pen that is turned about, with iron in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import pen_mhe as pm
from models.pen_file import parse_pen

Array = NDArray[np.float64]

STRENGTH_UT, DIP_RAD = 48.0, np.radians(64.0)
STEP_S, NOISE_UT = 0.01, 0.4
GRAVITY, FORCE_STD = 9.81, 0.02
FIELD = STRENGTH_UT * np.array([np.cos(DIP_RAD), 0.0, -np.sin(DIP_RAD)])
HARD_UT, SOFT = 20.0, 0.05
"""Deviations of hard iron in each axis, and of a sensitivity's entries."""


@dataclass(frozen=True, eq=False)
class TurnTruth:
    """A recording with its truth: ``y = S m + b``, S symmetric."""

    recording: pm.Recording
    S: Array
    bias: Array

    @property
    def parameters(self) -> Array:
        """(9,) as `pen_mhe.calibration.length.PARAMETERS`; scales as their distance from 1."""
        off = self.S - np.eye(3)
        return np.array([*self.bias, *np.diag(off), off[0, 1], off[0, 2], off[1, 2]])


def turned_pen() -> pm.PenConfig:
    """Return a pen with an accelerometer and a magnetometer, whose file tells twice its noise."""
    mag = {
        "kind": "magnetometer",
        "field_strength_ut": STRENGTH_UT,
        "field_dip_rad": DIP_RAD,
        "noise_std_ut": 2 * NOISE_UT,
        "bias_std_ut": HARD_UT,
    }
    accel = {
        "kind": "accelerometer",
        "noise_density_m_s2_per_sqrt_hz": 0.002,
        "bandwidth_hz": 50.0,
    }
    return parse_pen({"name": "turned", "sensors": {"accel": accel, "mag": mag}})


def turned(seed: int, *, duration_s: float = 30.0, noise: float = 1.0) -> TurnTruth:
    """Return a pen that a hand turns about all axes at about 1 rad/s, from any attitude.

    Parameters
    ----------
    noise : factor on `NOISE_UT` and `FORCE_STD`
    """
    rng = np.random.default_rng(seed)
    time_s = STEP_S * np.arange(round(duration_s / STEP_S))
    waves = rng.uniform(0.05, 0.25, (3, 3)), rng.uniform(0, 2 * np.pi, (3, 3))
    angles = 2 * np.pi * waves[0][..., None] * time_s + waves[1][..., None]
    rate = 0.8 * np.sin(angles).sum(axis=1).T + 0.5 * rng.standard_normal(3)
    steps = Rotation.from_rotvec(STEP_S * rate)
    attitude, attitudes = Rotation.random(rng=rng), []
    for step in steps:
        attitudes.append(attitude.as_matrix())
        attitude = attitude * step
    body_to_world = np.array(attitudes)
    field = np.einsum("nji,j->ni", body_to_world, FIELD)
    force = GRAVITY * body_to_world[:, 2]
    off = SOFT * rng.standard_normal((3, 3))
    S, bias = np.eye(3) + (off + off.T) / 2, HARD_UT * rng.standard_normal(3)
    read = field @ S.T + bias + noise * NOISE_UT * rng.standard_normal(field.shape)
    felt = force + noise * FORCE_STD * rng.standard_normal(force.shape)
    recording = pm.Recording.from_sensors(
        "turned", {"accel": (time_s, felt), "mag": (time_s, read)}
    )
    return TurnTruth(recording, S, bias)
