"""What tells two clocks' offset: velocities, which the frame turns and nothing else.

Both sides are taken over the same span, so that smoothing moves neither.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from scipy.spatial.transform import Rotation

from models.arrays import Array
from pen_mhe.truth.motion import AXIS, AZIMUTH, ELEVATION, FULL, Signal, turns_shown
from recordings.truths.track import TruthTrack, attitude_of, matrices_of

SPAN_S = 0.1
"""Over which a velocity is taken; longer hears less noise, and less of a fast hand."""
FINEST_S, COARSEST_S = 0.005, 0.04
PEAK = 1.5
"""Velocities beyond so many times the largest twentieth are cut: an estimate that settles."""


def signals(track: TruthTrack, estimate: TruthTrack) -> Iterator[Signal]:
    """Yield what both tell, the most telling first."""
    step_s = float(np.clip(1 / min(track.rate_hz, estimate.rate_hz), FINEST_S, COARSEST_S))
    turns = turns_shown(track, estimate)

    def signal(name: str, velocity: Callable[[TruthTrack, Array], Array]) -> Signal:
        return _signal(name, velocity, track, estimate, step_s)

    if turns == FULL:
        yield signal("angular velocity", angular_velocity)
    if turns == AXIS and track.is_of_pen:
        yield signal("the velocity of the axis", lambda one, t: _slope(axis_at, one, t))
    if turns in (ELEVATION, AZIMUTH):
        which = (AZIMUTH, ELEVATION).index(turns)
        yield signal(
            f"the rate of {turns}",
            lambda one, t: _slope(lambda it, at: it.angles_at(at)[:, [which]], one, t),
        )
    if track.position is not None and track.is_of_pen:
        width = track.position.shape[1]
        yield signal(
            "the tip's velocity",
            lambda one, t: _slope(lambda it, at: it.positions(at)[:, :width], one, t),
        )


def _signal(
    name: str,
    velocity: Callable[[TruthTrack, Array], Array],
    track: TruthTrack,
    estimate: TruthTrack,
    step_s: float,
) -> Signal:
    found = []
    for one in (track, estimate):
        n = int((one.time_s[-1] - one.time_s[0]) / step_s) + 1
        values = velocity(one, one.time_s[0] + step_s * np.arange(n))
        sizes = np.linalg.norm(values, axis=1, keepdims=True)
        if np.isfinite(sizes).any():
            most = PEAK * float(np.nanquantile(sizes, 0.95))
            values = values * np.minimum(1.0, most / np.maximum(sizes, np.finfo(float).tiny))
        found.append(values)
    return Signal(
        name, step_s, float(track.time_s[0]), found[0], float(estimate.time_s[0]), found[1]
    )


def angular_velocity(track: TruthTrack, t: Array) -> Array:
    """Return (m, 3), rad/s, in the axes of the body: the mean over a span.

    Of the body's rates where they are told: an estimated attitude may leap, its rates do not.
    """
    if track.turned is not None:
        return _slope(TruthTrack.turned_at, track, t)
    before, after = (attitudes_at(track, t + side * SPAN_S / 2) for side in (-1, 1))
    known = np.isfinite(before).all(axis=1) & np.isfinite(after).all(axis=1)
    found = np.full((len(t), 3), np.nan)
    if known.any():
        turn = Rotation.from_quat(before[known]).inv() * Rotation.from_quat(after[known])
        found[known] = turn.as_rotvec() / SPAN_S
    return found


def _slope(values: Callable[[TruthTrack, Array], Array], track: TruthTrack, t: Array) -> Array:
    before, after = (values(track, t + side * SPAN_S / 2) for side in (-1, 1))
    return np.asarray((after - before) / SPAN_S)


def attitudes_at(track: TruthTrack, t: Array) -> Array:
    """Return quaternions (m, 4) at any instants, of what tells a whole attitude."""
    return track.attitudes(t) if track.attitude is not None else attitude_of(track.angles_at(t))


def axis_at(track: TruthTrack, t: Array) -> Array:
    """Return the pen's axis (m, 3) at any instants, in the track's frame."""
    if track.angles is None:
        return np.asarray(matrices_of(track.attitudes(t))[:, :, 2])
    azimuth, elevation, _ = track.angles_at(t).T
    cosine = np.cos(elevation)
    return np.column_stack([cosine * np.cos(azimuth), cosine * np.sin(azimuth), np.sin(elevation)])
