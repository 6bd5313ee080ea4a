"""A first frame: every way up and heading is tried, the rest follows from each in closed form."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from models.arrays import Array
from pen_mhe.truth.frame import UPS, Frame, about_vertical, upright
from pen_mhe.truth.motion import AXIS, AZIMUTH, FULL
from pen_mhe.truth.residuals import Clocks, Compared

HEADINGS = 12
MOST_TRIED = 200
"""Instants that a start is judged by."""
LEVER_STD_M = 0.3
"""How far a marker may be from the tip: keeps what the motion does not show near zero."""


def first_frame(compared: Compared, clocks: Clocks) -> Frame:
    """Return the frame, of every way up that the truth may have, that fits best."""
    track = compared.track
    if track.is_level:
        # A tablet's y may point down the page, and its z into it.
        flat = compared.width == 2 and compared.turns is None
        ups = [np.array([0, 0, 1.0]), *([np.array([0, 0, -1.0])] if flat else [])]
    else:
        ups = list(UPS)
    attitudes = compared.true_attitudes(clocks)
    best, least = Frame(), np.inf
    for up in ups:
        for angle in np.arange(HEADINGS) * 2 * np.pi / HEADINGS:
            frame = _completed(compared, clocks, about_vertical(angle) @ upright(up), attitudes)
            cost = _cost(compared, clocks, frame)
            if cost < least - 1e-12:
                best, least = frame, cost
    return best


def _cost(compared: Compared, clocks: Clocks, frame: Frame) -> float:
    turning, place, _ = compared.errors(clocks, frame)
    spread = float(np.nanmedian(np.abs(compared.tip - np.nanmedian(compared.tip, axis=0)))) + 1e-6
    total = 0.0
    for errors, unit in ((turning, 1.0), (place, 3 * spread)):
        known = errors[np.isfinite(errors).all(axis=1)]
        if known.size:
            total += float(np.median(np.linalg.norm(known, axis=1))) / unit
    return total


def _completed(compared: Compared, clocks: Clocks, world: Array, attitudes: Array | None) -> Frame:
    """Return a frame of that turn, with the mount, the lever and the shift that fit best."""
    mount, lever, shift = np.eye(3), np.zeros(3), np.zeros(3)
    is_marker = not compared.track.is_of_pen
    if is_marker and attitudes is not None and compared.turns in (FULL, AXIS):
        seen = attitudes.transpose(0, 2, 1) @ world.T
        if compared.turns == FULL and compared.attitude is not None:
            mount = _mean_turn(seen @ compared.attitude)
        else:
            axis = np.nanmean(np.einsum("nij,nj->ni", seen, compared.axis), axis=0)
            mount = upright(axis / np.linalg.norm(axis)).T
    if compared.width:
        p = Frame(world).tips(compared.track.positions(clocks.of_truth(compared.time_s)), None)
        away = compared.tip - p
        if is_marker and attitudes is not None:
            lever, shift = _lever(world @ attitudes, away)
        else:
            shift = np.nan_to_num(np.nanmedian(away, axis=0))
        shift = shift * (np.arange(3) < compared.width)
    return Frame(world, shift, mount, lever)


def _lever(turns: Array, away: Array) -> tuple[Array, Array]:
    known = np.isfinite(away).all(axis=1) & np.isfinite(turns).all(axis=(1, 2))
    n = int(known.sum())
    if not n:
        return np.zeros(3), np.zeros(3)
    A = np.concatenate([turns[known], np.broadcast_to(np.eye(3), (n, 3, 3))], axis=2)
    spread = float(np.median(np.abs(away[known] - np.median(away[known], axis=0)))) + 1e-6
    ridge = np.diag([spread / LEVER_STD_M] * 3 + [0.0] * 3)
    found = np.linalg.lstsq(
        np.vstack([A.reshape(-1, 6), ridge]), np.append(away[known].ravel(), np.zeros(6)), None
    )[0]
    return found[:3], found[3:]


def _mean_turn(matrices: Array) -> Array:
    known = matrices[np.isfinite(matrices).all(axis=(1, 2))]
    if not len(known):
        return np.eye(3)
    return np.asarray(Rotation.from_matrix(known).mean().as_matrix())


def finds_heading(compared: Compared) -> bool:
    """Whether a turn about the vertical changes anything that is compared."""
    return compared.width > 0 or compared.turns in (FULL, AXIS, AZIMUTH)
