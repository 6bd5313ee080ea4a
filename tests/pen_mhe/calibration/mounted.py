"""Simulated pens whose sensors are not mounted as their file says."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import pen_mhe as pm
from models.motion import AttitudeWhiteJerk, Motion, TipBoundedVelocity
from pen_mhe.calibration.mounting import LEVEL, LEVER, OFFSET, TURN, MountingQuantity
from pen_mhe.calibration.mounting_keys import new_values
from pen_mhe.tuning.parameters import with_values

Array = NDArray[np.float64]

SENSORS = ("accel", "gyro", "camera")
OFF: dict[MountingQuantity, float] = {
    OFFSET: 5e-3,
    TURN: math.radians(1.0),
    LEVER: 5e-3,
    LEVEL: math.radians(0.5),
}
"""Standard deviations of what is wrong with the file."""


@dataclass(frozen=True, eq=False)
class MountedTruth:
    """A recording with what its pen file has to be changed by (9,)."""

    recording: pm.Recording
    values: Array


def handwriting_pen() -> pm.PenConfig:
    """Return the D-POINT pen on a level paper, in the hand of the simulated motion ``handwriting``.

    Its motion is what ``pen-mhe tune --objective innovations --parameters motion`` finds on 40 s
    of it (seed 0, all of it): 0.04062 m/s, 0.2529 s, 7.402 rad/s³/√Hz.
    """
    motion = Motion(
        tip=TipBoundedVelocity(speed_m_s=0.0406, correlation_time_s=0.253),
        attitude=AttitudeWhiteJerk(jerk_density_rad_s3_per_sqrt_hz=7.4),
    )
    return pm.load_pen("dpoint").model_copy(update={"motion": motion, "level_rad": (0.0, 0.0)})


def mounted(seed: int, duration_s: float = 40.0, off: float = 1.0) -> MountedTruth:
    """Return a recording of handwriting with a pen that is not as `handwriting_pen` says.

    Parameters
    ----------
    off : factor on `OFF`
    """
    rng, pen = np.random.default_rng([seed, 19]), handwriting_pen()
    changes = {q: off * std * rng.standard_normal(len(q.axes)) for q, std in OFF.items()}
    kept = {q: change for q, change in changes.items() if q is not OFFSET}
    true_pen = with_values(pen, new_values(pen, SENSORS, kept))
    recording = pm.simulate(
        true_pen, SENSORS, motion="handwriting", duration_s=duration_s, seed=seed
    )
    parts = {name: recording.sensor(name) for name in SENSORS}
    captured, frames = parts["camera"]
    parts["camera"] = (captured - changes[OFFSET], frames)
    return MountedTruth(
        pm.Recording.from_sensors(f"mounted {seed}", parts),
        np.concatenate([changes[q] for q in (OFFSET, TURN, LEVER, LEVEL)]),
    )
