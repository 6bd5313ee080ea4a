"""Faults of readings: what a sensor's readings become while a fault lasts.

Each takes the readings of one sensor and returns those of the rows that it hits.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from models.arrays import Array
from models.sensor_model import SensorModel
from suites.faults.table import INSTANT_S, Fault

POSITION, TURN = slice(0, 3), slice(3, 6)
"""Of a pose: m, rotation vector in rad."""


@dataclass(frozen=True, eq=False)
class HitReadings:
    """All readings of a sensor, and the fault that hits some of them.

    Parameters
    ----------
    time_s, values : (n,), (n, n_y)
    hit : (k,) which of them are within the fault's time
    rng : of this sensor and fault
    """

    fault: Fault
    sensor: SensorModel
    time_s: Array
    values: Array
    hit: NDArray[np.int64]
    rng: np.random.Generator

    @property
    def hit_values(self) -> Array:
        """(k, n_y) as they were."""
        return self.values[self.hit].copy()


def lost(given: HitReadings) -> Array:
    """No reading; the instant stays."""
    return np.full_like(given.hit_values, np.nan)


def stuck(given: HitReadings) -> Array:
    """The last reading before, again and again."""
    last = given.values[max(int(given.hit[0]) - 1, 0)]
    return np.broadcast_to(last, given.hit_values.shape)


def spikes(given: HitReadings) -> Array:
    """A size is added to single readings: axes in turn, signs alternating."""
    values, fault = given.hit_values, given.fault
    for i in range(fault.spikes):
        row = np.searchsorted(given.time_s[given.hit], fault.at_s + i * fault.apart_s - INSTANT_S)
        values[row, i % values.shape[1]] += (-1) ** i * fault.size
    return values


def at_limit(given: HitReadings) -> Array:
    """Every axis at its end of the range, on the side on which it is."""
    limit = given.sensor.reading_limit
    assert limit is not None, f"{given.sensor.name} has no range"
    return np.copysign(limit, given.hit_values)


def clipped(given: HitReadings) -> Array:
    """No axis reads more than a share of the largest reading of the recording."""
    limit = given.fault.size * np.abs(given.values).max()
    return np.clip(given.hit_values, -limit, limit)


def biased(given: HitReadings) -> Array:
    """A constant more on one axis."""
    values = given.hit_values
    values[:, given.fault.axis] += given.fault.size
    return values


def scaled(given: HitReadings) -> Array:
    """All axes times a factor."""
    return given.fault.size * given.hit_values


def flipped(given: HitReadings) -> Array:
    """One axis of the other sign."""
    values = given.hit_values
    values[:, given.fault.axis] *= -1
    return values


def swapped_readings(given: HitReadings) -> Array:
    """Neighbours in each other's place, under stamps in order."""
    return given.values[swapped(given.hit)]


def one_pose_off(given: HitReadings) -> Array:
    """The first pose, moved and turned away."""
    values = given.hit_values
    values[:1] = _away(values[:1], given)
    return values


def poses_off(given: HitReadings) -> Array:
    """A share of the poses, each moved and turned away on its own."""
    values = given.hit_values
    off = given.rng.random(len(values)) < given.fault.share
    values[off] = _away(values[off], given)
    return values


def other_sign(given: HitReadings) -> Array:
    """Every second attitude as the rotation vector of the quaternion -q: the same attitude."""
    values = given.hit_values
    turn = values[1::2, TURN]
    angle = np.linalg.norm(turn, axis=1, keepdims=True)
    values[1::2, TURN] = turn * (1 - 2 * np.pi / angle)
    return values


def conjugated(given: HitReadings) -> Array:
    """Attitudes as the rotation vectors of the inverse."""
    values = given.hit_values
    values[:, TURN] *= -1
    return values


READINGS: Mapping[str, Callable[[HitReadings], Array]] = MappingProxyType(
    {
        each.__name__: each
        for each in (
            *(lost, stuck, spikes, at_limit, clipped, biased, scaled, flipped),
            *(swapped_readings, one_pose_off, poses_off, other_sign, conjugated),
        )
    }
)
"""What a fault does → how."""


def swapped(rows: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return rows (n,) with neighbours in each other's place; an odd last one stays."""
    changed = rows.copy()
    even = len(rows) // 2 * 2
    changed[0:even:2], changed[1:even:2] = rows[1:even:2], rows[0:even:2]
    return changed


def _away(poses: Array, given: HitReadings) -> Array:
    """Return poses (n, 6), each moved by the fault's size and turned by its angle, at random."""
    directions = given.rng.standard_normal((2, len(poses), 3))
    directions /= np.linalg.norm(directions, axis=2, keepdims=True)
    moved = poses.copy()
    moved[:, POSITION] += given.fault.size * directions[0]
    turned = Rotation.from_rotvec(given.fault.turn_rad * directions[1])
    moved[:, TURN] = (turned * Rotation.from_rotvec(poses[:, TURN])).as_rotvec()
    return moved
