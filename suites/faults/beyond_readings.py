"""Faults of readings beyond the table: what a watch was not made for, see ``beyond.toml``."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from models.arrays import Array
from suites.faults.inject_readings import POSITION, TURN, HitReadings

BURST_S = (0.05, 0.4)
"""Shortest and longest of no readings."""


def drifts(given: HitReadings) -> Array:
    """A size more on one axis each second."""
    values = given.hit_values
    values[:, given.fault.axis] += given.fault.size * _since(given)
    return values


def axis_scaled(given: HitReadings) -> Array:
    """One axis times a factor."""
    values = given.hit_values
    values[:, given.fault.axis] *= given.fault.size
    return values


def axis_stuck(given: HitReadings) -> Array:
    """One axis as it was before, again and again."""
    values, axis = given.hit_values, given.fault.axis
    values[:, axis] = given.values[max(int(given.hit[0]) - 1, 0), axis]
    return values


def axis_lost(given: HitReadings) -> Array:
    """No reading of one axis."""
    values = given.hit_values
    values[:, given.fault.axis] = np.nan
    return values


def axes_swapped(given: HitReadings) -> Array:
    """One axis and the next in each other's place."""
    values, axes = given.hit_values, [given.fault.axis, (given.fault.axis + 1) % 3]
    values[:, axes] = values[:, axes[::-1]]
    return values


def quantised(given: HitReadings) -> Array:
    """Whole multiples of a size."""
    return given.fault.size * np.round(given.hit_values / given.fault.size)


def low_passed(given: HitReadings) -> Array:
    """Behind a filter of the first order; the size is its corner in Hz."""
    weights = -np.expm1(-2 * np.pi * given.fault.size * np.diff(given.time_s))
    filtered = given.values.copy()
    for k, a in enumerate(weights, start=1):
        filtered[k] = filtered[k - 1] + a * (given.values[k] - filtered[k - 1])
    return filtered[given.hit]


def high_passed(given: HitReadings) -> Array:
    """What a filter of the first order takes off; the size is its corner in Hz."""
    return given.hit_values - low_passed(given)


def vibrates(given: HitReadings) -> Array:
    """A size more on every axis, to and fro in `apart_s`."""
    phase = 2 * np.pi * _since(given) / given.fault.apart_s
    return given.hit_values + given.fault.size * np.cos(phase)[:, None]


def noisier(given: HitReadings) -> Array:
    """White noise of a size more."""
    values = given.hit_values
    return values + given.fault.size * given.rng.standard_normal(values.shape)


def lost_in_bursts(given: HitReadings) -> Array:
    """None in every second of intervals of random length."""
    lengths = given.rng.uniform(*BURST_S, 1 + int(np.ceil(given.fault.duration_s / BURST_S[0])))
    values, interval = given.hit_values, np.searchsorted(np.cumsum(lengths), _since(given))
    values[interval % 2 == 1] = np.nan
    return values


def packets_repeated(given: HitReadings) -> Array:
    """Every second packet, a size in s long, is the one before it."""
    rows, n = np.arange(len(given.hit)), _packet(given)
    return given.hit_values[np.where(rows // n % 2 == 1, rows - n, rows)]


def packets_reversed(given: HitReadings) -> Array:
    """Each whole packet, a size in s long, from its end to its begin."""
    values, n = given.hit_values, _packet(given)
    whole = len(values) // n * n
    values[:whole] = values[:whole].reshape(-1, n, values.shape[1])[:, ::-1].reshape(whole, -1)
    return values


def held(given: HitReadings) -> Array:
    """The first of each few readings in place of all of them; the size is how many."""
    rows, n = np.arange(len(given.hit)), round(given.fault.size)
    return given.hit_values[rows // n * n]


def poses_turned(given: HitReadings) -> Array:
    """A share of the attitudes, turned about an axis of the world."""
    values = given.hit_values
    off = given.rng.random(len(values)) < given.fault.share
    values[off, TURN] = _turned(values[off, TURN], np.full(off.sum(), given.fault.turn_rad), given)
    return values


def poses_turning(given: HitReadings) -> Array:
    """Attitudes turned about an axis of the world, by an angle more each second."""
    values = given.hit_values
    values[:, TURN] = _turned(values[:, TURN], given.fault.turn_rad * _since(given), given)
    return values


def positions_scaled(given: HitReadings) -> Array:
    """Positions times a factor."""
    values = given.hit_values
    values[:, POSITION] *= given.fault.size
    return values


BEYOND_READINGS: Mapping[str, Callable[[HitReadings], Array]] = MappingProxyType(
    {
        each.__name__: each
        for each in (
            *(drifts, axis_scaled, axis_stuck, axis_lost, axes_swapped, quantised),
            *(low_passed, high_passed, vibrates, noisier, lost_in_bursts),
            *(packets_repeated, packets_reversed, held),
            *(poses_turned, poses_turning, positions_scaled),
        )
    }
)
"""What a fault does → how."""


def _since(given: HitReadings) -> Array:
    """Return how long the fault has lasted at each reading that it hits, (k,) s."""
    return given.time_s[given.hit] - given.fault.at_s


def _packet(given: HitReadings) -> int:
    """Return the readings of a packet."""
    assert given.sensor.rate_hz is not None
    return max(1, round(given.fault.size * given.sensor.rate_hz))


def _turned(turns: Array, angles: Array, given: HitReadings) -> NDArray[np.float64]:
    """Return rotation vectors (k, 3) behind turns by angles (k,) about the fault's axis."""
    away = Rotation.from_rotvec(np.outer(angles, np.eye(3)[given.fault.axis]))
    return np.asarray((away * Rotation.from_rotvec(turns)).as_rotvec())
