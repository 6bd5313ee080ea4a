"""A true motion at its own rate, on its own clock, in its own frame, with gaps."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline
from scipy.spatial.transform import Rotation

from models.arrays import Array
from models.errors import InputError

ANGLES = ("azimuth_rad", "elevation_rad", "spin_rad")
"""Of the pen, in the order of their columns."""
GAP_STEPS, LEAST_GAP_S = 5.0, 0.02
"""A step of more than so many usual ones, and of so much, is a gap …"""
MOST_BETWEEN_S = 0.2
"""… and so is any longer one: a hand turns back within it."""
NEAR_S = 0.005
"""An instant in a gap, but so near to one of the truth, has its value."""
LEAST_STEP = 0.2
"""Rows that follow each other by less than this part of a usual step are one."""


@dataclass(frozen=True, eq=False)
class TruthTrack:
    """What a file tells of a pen, SI, NaN where it tells nothing.

    Parameters
    ----------
    name : of the file
    time_s : (n,) increasing, on the file's clock
    position : (n, 2) or (n, 3) of the tip, or of a point that is fixed to the pen; None if not told
    attitude : (n, 4) quaternions (x, y, z, w), body to the file's frame; None if not told
    angles : (n, 3) azimuth, elevation and spin of the pen, NaN for what is not told; None likewise
    is_of_pen : whether place and attitude are the tip's and the pen's own, and not those of a
        marker that is fixed to it somehow
    is_level : whether the file's z is known to point against gravity
    turned : (n, 3) integral of the body's rates over time, rad, where these are told themselves
    said : sentences on how it was read

    Raises
    ------
    InputError
        If there are fewer than two instants, or they do not increase.
    """

    name: str
    time_s: Array
    position: Array | None = None
    attitude: Array | None = None
    angles: Array | None = None
    is_of_pen: bool = True
    is_level: bool = False
    turned: Array | None = None
    said: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if len(self.time_s) < 2:
            raise InputError(
                f"truth {self.name}: {len(self.time_s)} rows with a time, expected at least two"
            )
        if not (np.diff(self.time_s) > 0).all():
            raise InputError(f"truth {self.name}: its times go back, expected increasing ones")

    @property
    def rate_hz(self) -> float:
        """The usual rate."""
        return 1 / float(np.median(np.diff(self.time_s)))

    def positions(self, time_s: Array) -> Array:
        """Return positions (m, 2) or (m, 3) at any instants, NaN in gaps and outside."""
        return self._places(time_s)

    def attitudes(self, time_s: Array) -> Array:
        """Return unit quaternions (m, 4) at any instants, NaN in gaps and outside."""
        found = self._turns(time_s)
        return found / np.linalg.norm(found, axis=1, keepdims=True)

    def angles_at(self, time_s: Array) -> Array:
        """Return azimuth, elevation and spin (m, 3) at any instants, likewise."""
        return np.column_stack([one(time_s)[:, 0] for one in self._bends])

    def turned_at(self, time_s: Array) -> Array:
        """Return the integral of the body's rates (m, 3) at any instants, likewise."""
        return self._turned(time_s)

    @cached_property
    def _turned(self) -> Between:
        assert self.turned is not None
        return Between(self.time_s, self.turned)

    @cached_property
    def _places(self) -> Between:
        assert self.position is not None
        return Between(self.time_s, self.position)

    @cached_property
    def _turns(self) -> Between:
        assert self.attitude is not None
        return Between(self.time_s, _continuous(self.attitude))

    @cached_property
    def _bends(self) -> tuple[Between, ...]:
        assert self.angles is not None
        return tuple(Between(self.time_s, _unwound(one)[:, None]) for one in self.angles.T)


class Between:
    """Values (n, k) of instants (n,) between these, smooth, but not across a gap."""

    def __init__(self, time_s: Array, values: Array) -> None:
        known = np.isfinite(values).all(axis=1)
        t, v = time_s[known], values[known]
        if len(t) > 1:
            steps = np.diff(t)
            usual = float(np.median(steps))
            kept = np.append(True, steps >= LEAST_STEP * usual)
            t, v = t[kept], v[kept]
            longest = min(max(GAP_STEPS * usual, LEAST_GAP_S), MOST_BETWEEN_S)
            self._is_gap: NDArray[np.bool_] = np.diff(t) > longest
        self._time, self._width = t, values.shape[1]
        self._spline = None
        if len(t) > 1:
            self._spline = CubicHermiteSpline(t, v, _slopes(t, v, self._is_gap))

    def __call__(self, time_s: Array) -> Array:
        """Return the values (m, k), NaN where none is known."""
        found = np.full((len(time_s), self._width), np.nan)
        if self._spline is None:
            return found
        t = self._time
        before = np.clip(np.searchsorted(t, time_s, side="right") - 1, 0, len(t) - 2)
        away = np.minimum(np.abs(time_s - t[before]), np.abs(time_s - t[before + 1]))
        inside = (time_s >= t[0]) & (time_s <= t[-1])
        known = inside & (~self._is_gap[before] | (away <= NEAR_S))
        found[known] = self._spline(time_s[known])
        return found


def _slopes(t: Array, v: Array, is_gap: NDArray[np.bool_]) -> Array:
    """Return slopes (n, k) of second order, one-sided beside gaps."""
    if len(t) < 3:
        return np.repeat((v[1:] - v[:-1]) / (t[1:] - t[:-1])[:, None], 2, axis=0)
    slopes = np.gradient(v, t, axis=0)
    straight = np.diff(v, axis=0) / np.diff(t)[:, None]
    ends = np.flatnonzero(is_gap)
    before = np.append(True, ~is_gap)  # whether the step that leads to a row is none
    for row in (*ends, *(ends + 1)):
        is_first, is_last = not before[row], row == len(t) - 1 or is_gap[row]
        if is_first and is_last:
            slopes[row] = 0.0
        else:
            slopes[row] = straight[row] if is_first else straight[row - 1]
    return np.asarray(slopes)


def _continuous(quaternions: Array) -> Array:
    """Return the same attitudes, each by the quaternion that is nearer to the one before."""
    found = quaternions.copy()
    known = np.flatnonzero(np.isfinite(found).all(axis=1))
    signs = np.sign((found[known[1:]] * found[known[:-1]]).sum(axis=1))
    signs = np.cumprod(np.where(signs == 0, 1.0, signs))
    found[known[1:]] *= signs[:, None]
    return found


def _unwound(angle: Array) -> Array:
    found, known = angle.copy(), np.isfinite(angle)
    found[known] = np.unwrap(angle[known])
    return found


def attitude_of(angles: Array) -> Array:
    """Return quaternions (n, 4) of azimuth, elevation and spin (n, 3); NaN stays NaN."""
    found = np.full((len(angles), 4), np.nan)
    known = np.isfinite(angles).all(axis=1)
    if known.any():
        turns = angles[known] * [1, -1, 1] + [0, np.pi / 2, 0]
        found[known] = Rotation.from_euler("ZYZ", turns).as_quat()
    return found


def angles_of(matrices: Array) -> Array:
    """Return azimuth, elevation and spin (n, 3) of body to world (n, 3, 3)."""
    axis = matrices[:, :, 2]
    return np.column_stack(
        [
            np.arctan2(axis[:, 1], axis[:, 0]),
            np.arcsin(np.clip(axis[:, 2], -1, 1)),
            np.arctan2(matrices[:, 2, 1], -matrices[:, 2, 0]),
        ]
    )


def matrices_of(quaternions: Array) -> Array:
    """Return the rotation matrices (n, 3, 3) of quaternions (n, 4), NaN where there is none."""
    found = np.full((len(quaternions), 3, 3), np.nan)
    known = np.isfinite(quaternions).all(axis=1)
    if known.any():
        found[known] = Rotation.from_quat(quaternions[known]).as_matrix()
    return found
