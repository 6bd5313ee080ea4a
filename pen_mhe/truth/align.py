"""A truth's clock and frame, laid on those of an estimate."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from estimation.truth import Truth
from models.arrays import Array
from models.errors import InputError
from models.names import unknown
from pen_mhe.truth.clock import FoundOffset, found_offset
from pen_mhe.truth.fit import Fitted, Unknowns, fitted
from pen_mhe.truth.frame import UPS, Frame, about_vertical, upright
from pen_mhe.truth.frame_names import FRAMES, FREE, LEVEL, SAME
from pen_mhe.truth.motion import AXIS, AZIMUTH, ELEVATION, FULL, turns_shown
from pen_mhe.truth.residuals import Clocks, Compared
from pen_mhe.truth.signals import signals
from pen_mhe.truth.starts import MOST_TRIED, finds_heading, first_frame
from recordings.truths.columns import TIP
from recordings.truths.track import ANGLES, TruthTrack, angles_of

MOST_FITTED, LEAST_FITTED = 800, 20
"""Instants that clock and frame are fitted to."""
MOST_LOOKED_AT = 8000
"""Instants of the overlap of which they are chosen, where there is a truth."""
NEAR_AXIS_RAD = np.radians(10.0)
"""An axis of the truth that is so near to the vertical is meant to point along it."""
LEAST_FOR_DRIFT_S = 20.0
SURE, LEAST_DRIFT_S = 3.0, 1e-3
"""A drift matters that is so many standard deviations large, and moves an end by so much."""


@dataclass(frozen=True, eq=False)
class Alignment:
    """How a truth's clock and frame lie on those of an estimate.

    Parameters
    ----------
    track, turns : of what, and what of the attitude both tell
    fitted : clock and frame
    found : how the offset was found; None where it was said
    drift, drift_std : of the clocks, whether or not it matters; NaN where that is not looked for
    span_s : of the overlap
    """

    track: TruthTrack
    turns: str | None
    fitted: Fitted
    found: FoundOffset | None
    drift: float
    drift_std: float
    span_s: float

    @property
    def drift_matters(self) -> bool:
        """Whether the drift is fitted."""
        return self.fitted.unknowns.drift

    def truth(self, estimate: TruthTrack, time_s: Array) -> Truth:
        """Return the truth in the estimate's frame at instants (n,), NaN where there is none."""
        compared = Compared(self.track, estimate, self.turns, time_s)
        clocks, frame = self.fitted.clocks, self.fitted.frame
        values: dict[str, Array] = {}
        attitudes = compared.true_attitudes(clocks)
        if compared.width:
            seen = self.track.positions(clocks.of_truth(time_s))
            tips = frame.tips(seen, None if self.track.is_of_pen else attitudes)
            values |= dict(zip(TIP[: compared.width], tips.T, strict=False))
        if attitudes is not None:
            values |= dict(zip(ANGLES, angles_of(frame.turned(attitudes)).T, strict=True))
        elif self.track.angles is not None:
            angles = self.track.angles_at(clocks.of_truth(time_s))
            values |= {ANGLES[0]: angles[:, 0] + frame.heading_rad, ANGLES[1]: angles[:, 1]}
        shown = {FULL: ANGLES, AXIS: ANGLES[:2], ELEVATION: ANGLES[1:2], AZIMUTH: ANGLES[:1]}
        kept = TIP + (shown[self.turns] if self.turns else ())
        names = tuple(name for name in values if name in kept)
        return Truth(time_s, names, np.column_stack([values[name] for name in names]))


@dataclass(frozen=True)
class NotAligned:
    """Why a truth cannot be laid on an estimate, in words."""

    why: str


def check_said(offset_s: float | None, frame: str | None) -> None:
    """Raise `InputError` for an offset that is no number, or a frame that is none of `FRAMES`."""
    if frame is not None and frame not in FRAMES:
        raise unknown("frame of the truth", frame, FRAMES)
    if offset_s is not None and not np.isfinite(offset_s):
        raise InputError(f"offset of the truth is {offset_s}, expected seconds")


def aligned(
    track: TruthTrack,
    estimate: TruthTrack,
    *,
    offset_s: float | None = None,
    frame: str | None = None,
) -> Alignment | NotAligned:
    """Lay a truth's clock and frame on those of an estimate.

    Parameters
    ----------
    estimate : of `pen_mhe.truth.motion.track_of_estimate`
    offset_s : what is added to the truth's times, where somebody knows it
    frame : `same` fits none; `level` a turn about the vertical, and a shift; `free` a whole turn;
        None takes `level` where one of the truth's axes is vertical

    Raises
    ------
    InputError
        If the frame is none of these, or the offset is no number.
    """
    check_said(offset_s, frame)
    turns = turns_shown(track, estimate)
    if turns is None and track.position is None:
        return NotAligned("it tells nothing that is estimated")
    found = None
    if offset_s is None:
        found = _offset(track, estimate)
        offset_s = found.offset_s
    if offset_s is None:
        why = "" if found is None else found.why
        return NotAligned(f"the offset of its clock is not seen ({why}); --truth-offset S says it")
    clocks = Clocks(offset_s)
    compared, span_s = _compared(track, estimate, turns, clocks)
    if compared is None:
        at = clocks.of_estimate(track.time_s[[0, -1]])
        return NotAligned(
            f"it is of {at[0]:.6g} to {at[1]:.6g} s, the estimate of {estimate.time_s[0]:.6g} to "
            f"{estimate.time_s[-1]:.6g} s, with fewer than {LEAST_FITTED} instants of both"
        )
    clocks = replace(clocks, middle_s=float(compared.time_s.mean()))
    best = _framed(compared, clocks, frame, clock=found is not None)
    drift = drift_std = np.nan
    if found is not None and span_s >= LEAST_FOR_DRIFT_S:
        more = replace(best.unknowns, drift=True)
        drifting = fitted(compared, best.clocks, best.frame, more)
        drift, drift_std = drifting.clocks.drift, drifting.drift_std
        if abs(drift) > SURE * drift_std and abs(drift) * span_s / 2 > LEAST_DRIFT_S:
            best = drifting
    return Alignment(track, turns, best, found, drift, drift_std, span_s)


def _offset(track: TruthTrack, estimate: TruthTrack) -> FoundOffset:
    found = [FoundOffset(None, 0.0, "", "it tells nothing that is the same in every frame")]
    for signal in signals(track, estimate):
        found.append(found_offset(signal))
        if found[-1].offset_s is not None:
            return found[-1]
    whys = [one.why for one in found[1:]]
    return replace(found[0], why="; ".join(whys)) if whys else found[0]


def _compared(
    track: TruthTrack, estimate: TruthTrack, turns: str | None, clocks: Clocks
) -> tuple[Compared | None, float]:
    start, end = clocks.of_estimate(track.time_s[[0, -1]])
    times = estimate.time_s[(estimate.time_s >= start) & (estimate.time_s <= end)]
    if len(times) < LEAST_FITTED:
        return None, 0.0
    times = times[_evenly(len(times), MOST_LOOKED_AT)]
    known = times[Compared(track, estimate, turns, times).known(clocks)]
    if len(known) < LEAST_FITTED:
        return None, 0.0
    chosen = known[_evenly(len(known), MOST_FITTED)]
    return Compared(track, estimate, turns, chosen), float(known[-1] - known[0])


def _evenly(n: int, most: int) -> NDArray[np.int64]:
    return np.unique(np.linspace(0, n - 1, min(n, most)).astype(np.int64))


def _framed(compared: Compared, clocks: Clocks, frame: str | None, *, clock: bool) -> Fitted:
    if frame == SAME:
        return fitted(compared, clocks, Frame(), Unknowns(clock=clock))
    track = compared.track
    if frame == LEVEL:
        compared.track = track = replace(track, is_level=True)
    start = first_frame(compared.thinned(MOST_TRIED), clocks)
    is_marker = not track.is_of_pen
    mounted = is_marker and compared.turns in (FULL, AXIS)
    unknowns = Unknowns(
        clock=clock,
        turns=1 if finds_heading(compared) else 0,
        shifts=compared.width,
        mount=3 if mounted else 0,
        lever=3 if is_marker and compared.width else 0,
    )
    if track.is_level and frame != FREE:
        return fitted(compared, clocks, start, unknowns)
    free = fitted(compared, clocks, start, replace(unknowns, turns=3))
    nearest = max(UPS, key=lambda up: float(up @ free.frame.up))
    if frame == FREE or np.arccos(np.clip(nearest @ free.frame.up, -1, 1)) > NEAR_AXIS_RAD:
        return free
    level = replace(free.frame, world=about_vertical(free.frame.heading_rad) @ upright(nearest))
    return fitted(compared, free.clocks, level, unknowns)
