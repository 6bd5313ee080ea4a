"""Pairs and segments of the real array: two accelerometers of it, and the rate by gyroscopes.

A pair's axes: x from its lower to its upper sensor, z that of the board. A turn begins at
rest, which tells how the pair stands, and takes off what the calibration has left of the
difference there. The board is in a solid that is tilted over its edges on a table: turns
begin and end with knocks of up to 16 m/s² between sensors 19 mm apart, for a sample or two,
which 62.5 Hz cannot resolve. Between the knocks the difference is what the gyroscopes
predict, to the noise. Stretches that begin in motion are told their first rate.
Gyroscopes choose the segments, tell that rate, and judge; no estimate uses them otherwise.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from pathlib import Path
from types import MappingProxyType

import numpy as np

from models.arrays import Array
from recordings.formats.imu_array import ImuArray, calibrated, read_imu_array, still_poses
from suites.gyro_free.readings import GRAVITY_M_S2

FOLDER = "isa_imu_array"
REST_S = 0.5
"""Of a turn's rest before it, by which it is zeroed and levelled."""

LEAD_S = 0.1
"""A turn begins this long before the gyroscopes see it."""

KNOCK_S = 0.06
LEAST_BETWEEN_S = 0.2
"""What a knock takes, and what is left between two of them at least."""

MOVING_RAD_S = np.radians(20.0)
LONGEST_S = 2.0
SHORTEST_S = 0.6
SEGMENTS = 12
"""Of a part of the recording at most."""


@dataclass(frozen=True, eq=False)
class PairSegment:
    """A segment of the recording as one pair sees it, in the pair's axes.

    Parameters
    ----------
    time_s : (n,) from 0
    f1, f2 : (n, 3) m/s²
    half_distance_m : l
    rate : (n, 3) rad/s, by the gyroscopes
    start_rate : (3,) told
    C : (3, 3) attitude at the rest before; heading taken for zero. The unit matrix where
        there was none to tell it
    """

    time_s: Array
    f1: Array
    f2: Array
    half_distance_m: float
    rate: Array
    start_rate: Array
    C: Array


@cache
def load_array(data: str) -> ImuArray:
    """Return the calibrated array of a folder of recordings."""
    return calibrated(read_imu_array(Path(data) / FOLDER), GRAVITY_M_S2)


@dataclass(frozen=True)
class Segment:
    """A segment of the recording.

    Parameters
    ----------
    samples : of the recording
    rest : samples at rest before it; None where there are none
    from_rest : whether it begins at rest; else its first rate is told
    """

    samples: slice
    rest: slice | None
    from_rest: bool


@cache
def turns(data: str) -> tuple[Segment, ...]:
    """Return the turns from pose to pose, the fastest first."""
    array = load_array(data)
    rate, found = array.mean_rate, []
    lead, longest = _samples(array, LEAD_S), _samples(array, LONGEST_S)
    for before, after in pairwise(still_poses(array)):
        between = slice(before.stop, after.start)
        fast = before.stop + np.flatnonzero(_size(rate[between]) > MOVING_RAD_S)
        if not len(fast):
            continue
        start = int(fast[0]) - lead
        samples = slice(start, min(int(fast[-1]), start + longest))
        rest = slice(start - _samples(array, REST_S), start)
        if not array.clipped[rest.start : samples.stop].any():
            found.append(Segment(samples, rest, from_rest=True))
    found.sort(key=lambda turn: -float(np.mean(rate[turn.samples] ** 2)))
    return tuple(found[:SEGMENTS])


@cache
def between_knocks(data: str) -> tuple[Segment, ...]:
    """Return the turns without their first and last knocks, those that leave enough."""
    array = load_array(data)
    lead, knock = _samples(array, LEAD_S), _samples(array, KNOCK_S)
    found = []
    for turn in turns(data):
        samples = slice(turn.samples.start + lead + knock, turn.samples.stop - knock)
        if samples.stop - samples.start >= _samples(array, LEAST_BETWEEN_S):
            found.append(Segment(samples, turn.rest, from_rest=False))
    return tuple(found)


@cache
def shaken(data: str) -> tuple[Segment, ...]:
    """Return stretches of the shaking without a clipped sample, evenly over its time."""
    array = load_array(data)
    poses = still_poses(array)
    shaking = slice(poses[-2].stop, poses[-1].start)
    good = np.zeros(len(array.time_s), dtype=int)
    good[shaking] = ((_size(array.mean_rate) > MOVING_RAD_S) & ~array.clipped.any(axis=1))[shaking]
    ends = np.flatnonzero(np.diff(np.concatenate([[0], good, [0]]))).reshape(-1, 2)
    least, most = _samples(array, SHORTEST_S), _samples(array, LONGEST_S)
    whole = [slice(a, min(b, a + most)) for a, b in ends.tolist() if b - a >= least]
    chosen = np.unique(np.linspace(0, len(whole) - 1, SEGMENTS).round().astype(int))
    return tuple(Segment(whole[i], None, from_rest=False) for i in chosen)


PARTS: Mapping[str, Callable[[str], tuple[Segment, ...]]] = MappingProxyType(
    {"turns": turns, "between knocks": between_knocks, "shaken": shaken}
)
"""Part of the recording → its segments, from a folder of recordings."""


def pair_segment(array: ImuArray, segment: Segment, pair: tuple[int, int]) -> PairSegment:
    """Return a segment as a pair sees it."""
    lower, upper = pair
    along = array.position_m[upper] - array.position_m[lower]
    distance = float(np.linalg.norm(along))
    x, z = along / distance, np.array([0.0, 0.0, 1.0])
    axes = np.array([x, np.cross(z, x), z])  # board to pair
    f1, f2 = (array.force[segment.samples, sensor] @ axes.T for sensor in pair)
    rate = array.mean_rate[segment.samples] @ axes.T
    C = np.eye(3)
    if segment.rest is not None:
        rest1, rest2 = (
            (array.force[segment.rest, sensor] @ axes.T).mean(axis=0) for sensor in pair
        )
        f1, f2 = f1 + (rest2 - rest1) / 2, f2 - (rest2 - rest1) / 2
        C = levelled(rest1 + rest2)
    time_s = array.time_s[segment.samples] - array.time_s[segment.samples.start]
    start_rate = np.zeros(3) if segment.from_rest else rate[0]
    return PairSegment(time_s, f1, f2, distance / 2, rate, start_rate, C)


def levelled(force: Array) -> Array:
    """Return C (3, 3) at rest from a specific force (3,), the pair's axis of azimuth zero."""
    up = force / np.linalg.norm(force)
    ahead = np.array([1.0, 0.0, 0.0]) - up[0] * up
    ahead /= np.linalg.norm(ahead)
    return np.column_stack([ahead, np.cross(up, ahead), up])


def _samples(array: ImuArray, duration_s: float) -> int:
    return round(duration_s / float(np.median(np.diff(array.time_s))))


def _size(vectors: Array) -> Array:
    return np.asarray(np.linalg.norm(vectors, axis=-1))
