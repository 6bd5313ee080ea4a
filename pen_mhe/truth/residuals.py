"""How far an estimate is from a truth, given how their clocks and frames lie."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from models.arrays import Array
from pen_mhe.truth.frame import Frame
from pen_mhe.truth.motion import AXIS, AZIMUTH, ELEVATION, FULL
from pen_mhe.truth.signals import SPAN_S, angular_velocity, attitudes_at, axis_at
from recordings.truths.track import TruthTrack, matrices_of

MARGIN_S = 0.02
"""Around an instant that is fitted to, so that no gap comes in as the clock moves."""


@dataclass(frozen=True)
class Clocks:
    """What is added to a truth's time, s: offset + drift · (t - middle), t of the estimate."""

    offset_s: float = 0.0
    drift: float = 0.0
    middle_s: float = 0.0

    def of_truth(self, time_s: Array) -> Array:
        """Return the truth's times (n,) of instants of the estimate."""
        return np.asarray(time_s - self.offset_s - self.drift * (time_s - self.middle_s))

    def of_estimate(self, time_s: Array) -> Array:
        """Return the estimate's times (n,) of instants of the truth."""
        k = 1 - self.drift
        return np.asarray((time_s + self.offset_s - self.drift * self.middle_s) / k)


class Compared:
    """A truth and an estimate at some instants of the estimate.

    Parameters
    ----------
    turns : what of the attitude both tell, of `pen_mhe.truth.motion`; None for nothing
    time_s : (n,)
    has_rate : whether it is compared too how fast they change
    """

    def __init__(
        self,
        track: TruthTrack,
        estimate: TruthTrack,
        turns: str | None,
        time_s: Array,
        *,
        has_rate: bool = True,
    ) -> None:
        self.track, self.turns, self.time_s = track, turns, time_s
        self._estimate = estimate
        self.width = 0 if track.position is None else track.position.shape[1]
        self.tip = estimate.positions(time_s)
        self.angles = estimate.angles_at(time_s)
        self.attitude = matrices_of(estimate.attitudes(time_s)) if turns == FULL else None
        self.axis = axis_at(estimate, time_s)
        self._ends: tuple[Compared, Compared] | None = None
        self.rate = angular_velocity(estimate, time_s) if turns == FULL else None
        if has_rate and turns != FULL:
            self._ends = (
                Compared(track, estimate, turns, time_s - SPAN_S / 2, has_rate=False),
                Compared(track, estimate, turns, time_s + SPAN_S / 2, has_rate=False),
            )

    def thinned(self, most: int) -> Compared:
        """Return the same at fewer instants, without rates."""
        rows = np.unique(np.linspace(0, len(self.time_s) - 1, most).astype(int))
        return Compared(self.track, self._estimate, self.turns, self.time_s[rows], has_rate=False)

    def true_attitudes(self, clocks: Clocks) -> Array | None:
        """Return the truth's attitudes (n, 3, 3) in its own frame; None where it tells none."""
        if self.track.attitude is None and self.turns != FULL:
            return None
        return matrices_of(attitudes_at(self.track, clocks.of_truth(self.time_s)))

    def errors(self, clocks: Clocks, frame: Frame) -> tuple[Array, Array, Array]:
        """Return errors (n, k) of turning, rad, of place, m, and of how fast that changes.

        The last tells clocks best: an estimate that is off by a bias, or has lost its heading,
        still moves when the truth does. NaN where there is no truth.
        """
        attitudes = self.true_attitudes(clocks)
        return (
            self._turning(clocks, frame, attitudes),
            self._place(clocks, frame, attitudes),
            self._rate(clocks, frame),
        )

    def shown(self, clocks: Clocks, frame: Frame) -> Array:
        """Return the errors (n, k) of turning, or where nothing turns, of place."""
        attitudes = self.true_attitudes(clocks)
        part = self._turning if self.turns is not None else self._place
        return part(clocks, frame, attitudes)

    def known(self, clocks: Clocks) -> NDArray[np.bool_]:
        """Return at which instants (n,) the truth says anything, and does so all around."""
        found = np.ones(len(self.time_s), dtype=bool)
        for side in (-MARGIN_S, 0.0, MARGIN_S):
            moved = replace(clocks, offset_s=clocks.offset_s + side)
            turning, place, _ = self.errors(moved, Frame())
            found &= np.isfinite(np.column_stack([turning, place])).any(axis=1)
        return found

    def _turning(self, clocks: Clocks, frame: Frame, attitudes: Array | None) -> Array:
        if self.turns == FULL:
            assert attitudes is not None
            assert self.attitude is not None
            return _rotation_vectors(self.attitude.transpose(0, 2, 1) @ frame.turned(attitudes))
        if self.turns == AXIS:
            if attitudes is not None:
                true = frame.turned(attitudes)[:, :, 2]
            else:
                true = axis_at(self.track, clocks.of_truth(self.time_s)) @ frame.world.T
            return np.asarray(self.axis - true)
        if self.turns in (ELEVATION, AZIMUTH):
            which = (AZIMUTH, ELEVATION).index(self.turns)
            true = self.track.angles_at(clocks.of_truth(self.time_s))[:, which]
            if self.turns == AZIMUTH:
                true = true + frame.heading_rad
            away = self.angles[:, which] - true
            return np.asarray((away - 2 * np.pi * np.round(away / (2 * np.pi)))[:, None])
        return np.zeros((len(self.time_s), 0))

    def _rate(self, clocks: Clocks, frame: Frame) -> Array:
        if self._ends is not None:
            before, after = (one.shown(clocks, frame) for one in self._ends)
            return np.asarray((after - before) / SPAN_S)
        if self.rate is None:
            return np.zeros((len(self.time_s), 0))
        true = angular_velocity(self.track, clocks.of_truth(self.time_s))
        return np.asarray(self.rate - true @ frame.mount)

    def _place(self, clocks: Clocks, frame: Frame, attitudes: Array | None) -> Array:
        if not self.width:
            return np.zeros((len(self.time_s), 0))
        seen = self.track.positions(clocks.of_truth(self.time_s))
        moved = frame.tips(seen, None if self.track.is_of_pen else attitudes)
        return np.asarray((self.tip - moved)[:, : self.width])


def _rotation_vectors(matrices: Array) -> Array:
    found = np.full((len(matrices), 3), np.nan)
    known = np.isfinite(matrices).all(axis=(1, 2))
    if known.any():
        found[known] = Rotation.from_matrix(matrices[known]).as_rotvec()
    return found
