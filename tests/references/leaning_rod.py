"""A rod that leans and turns about its tip, with an IMU on it and the angles that are true.

Attitudes are Euler angles, rates and forces their differences: nothing of the project takes part.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]
GRAVITY = 9.81
FINE_HZ = 2000.0


@dataclass(frozen=True, eq=False)
class LeaningRod:
    """Readings in the chip's axes, and what is true.

    Parameters
    ----------
    time_s : (n,) as stamped
    force, rate : (n, 3)
    elevation, azimuth : (n,) rad
    attitude, place : n body-to-world rotations, and (n, 3) of the chip in the world
    bias_tilt : by which the accelerometer's bias tilts what is seen at the beginning, rad
    """

    time_s: Array
    force: Array
    rate: Array
    elevation: Array
    azimuth: Array
    attitude: Rotation
    place: Array
    bias_tilt: float


def leaning_rod(
    seed: int,
    mounting: Array,
    *,
    duration_s: float = 12.0,
    rest_s: float = 3.0,
    rate_hz: float = 100.0,
    lever_m: float = 0.1,
    tip_m: float = 0.0,
    jitter_s: float = 0.0,
) -> LeaningRod:
    """Return a rod at rest, and then turned by sines of a hand.

    Parameters
    ----------
    mounting : (3, 3) sensor_to_body
    tip_m : how far the tip moves; at 0 it rests on the table
    jitter_s : deviation of its stamps
    """
    r = np.random.default_rng(seed)
    t = np.arange(-0.01, duration_s + 0.01, 1 / FINE_HZ)
    ramp = np.clip(t - rest_s, 0, 1)
    ramp = ramp**3 * (10 - 15 * ramp + 6 * ramp**2)

    def sines(total: float) -> Array:
        f, p, a = r.uniform(0.15, 1.5, 3), r.uniform(0, 2 * np.pi, 3), r.dirichlet(np.ones(3))
        waves = (
            A * np.sin(2 * np.pi * F * (t - rest_s) + P) for A, F, P in zip(a, f, p, strict=True)
        )
        return np.asarray(total * ramp * sum(waves))

    elevation = np.radians(r.uniform(50, 70)) + sines(np.radians(r.uniform(8, 20)))
    azimuth = r.uniform(-np.pi, np.pi) + sines(np.radians(r.uniform(10, 40)))
    spin = sines(np.radians(r.uniform(10, 40)))
    attitude = Rotation.from_euler("ZYZ", np.column_stack([azimuth, np.pi / 2 - elevation, spin]))
    place = attitude.apply([0, 0, lever_m])
    place = place + np.column_stack([sines(tip_m), sines(tip_m), 0 * t])
    rate, moved = np.zeros_like(place), np.zeros_like(place)
    rate[1:-1] = (attitude[:-2].inv() * attitude[2:]).as_rotvec() * FINE_HZ / 2
    moved[1:-1] = np.diff(place, n=2, axis=0) * FINE_HZ**2
    force = attitude.inv().apply(moved + np.array([0, 0, GRAVITY]))
    time_s = np.arange(0, duration_s, 1 / rate_hz)
    k = np.round((time_s + 0.01) * FINE_HZ).astype(int)
    bias, drift = r.normal(0, 0.12, 3), np.radians(r.normal(0, 1.0, 3))
    read = force[k] @ mounting + bias + r.normal(0, 0.012, (len(k), 3))
    turned = rate[k] @ mounting + drift + r.normal(0, np.radians(0.08), (len(k), 3))
    seen = force[k[0]] + mounting @ bias
    tilt = np.arcsin(seen[2] / np.linalg.norm(seen)) - elevation[k[0]]
    stamps = np.sort(time_s + r.normal(0, jitter_s, len(k))) + 1e-9 * np.arange(len(k))
    return LeaningRod(
        stamps, read, turned, elevation[k], azimuth[k], attitude[k], place[k], float(tilt)
    )
