"""What is compared: the estimated motion of a pen, and what a truth can show of one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import cumulative_trapezoid

from estimation.history import EstimateHistory
from models.arrays import Array
from models.errors import InputError
from recordings.truths.columns import TIP
from recordings.truths.track import ANGLES, TruthTrack, attitude_of

RATES = tuple(f"body_rate_{axis}_rad_s" for axis in "xyz")
FULL, AXIS, ELEVATION, AZIMUTH = "attitude", "axis", "elevation", "azimuth"


def track_of_estimate(history: EstimateHistory) -> TruthTrack:
    """Return the tip and the angles that a run estimated, one row for each instant.

    Raises
    ------
    InputError
        If it is no pen's.
    """
    told = history.first_told()
    if not set(TIP) <= set(told.names):
        raise InputError(f"the states of {told.estimator} are no pen's, expected a tip to compare")
    tip = np.column_stack([told.column(name) for name in TIP])
    angles = np.full((len(told), 3), np.nan)
    for k, name in enumerate(ANGLES):
        if name in told.names:
            angles[:, k] = told.column(name)
    rates = None
    if set(RATES) <= set(told.names):
        rates = np.column_stack([told.column(name) for name in RATES])
    turned = rates
    if rates is not None:
        turned = np.asarray(cumulative_trapezoid(rates, told.time_s, axis=0, initial=0))
    return TruthTrack(
        told.estimator,
        told.time_s,
        tip,
        attitude_of(angles),
        angles,
        turned=turned,
        is_level=True,
    )


def turns_shown(track: TruthTrack, estimate: TruthTrack) -> str | None:
    """Return what of the pen's attitude both tell; None for nothing."""
    assert estimate.angles is not None
    has_spin = bool(np.isfinite(estimate.angles[:, 2]).any())
    if track.attitude is not None:
        return FULL if has_spin else AXIS
    if track.angles is None:
        return None
    azimuth, elevation, spin = (bool(np.isfinite(one).any()) for one in track.angles.T)
    if azimuth and elevation:
        return FULL if spin and has_spin else AXIS
    return ELEVATION if elevation else AZIMUTH if azimuth else None


@dataclass(frozen=True, eq=False)
class Signal:
    """What is the same in every frame, but for a turn: samples of it, NaN where there is none.

    Parameters
    ----------
    name : in a sentence
    true, estimated : (n, k), (m, k) at a step of `step_s`, from `true_s`, `estimated_s` on
    """

    name: str
    step_s: float
    true_s: float
    true: Array
    estimated_s: float
    estimated: Array
