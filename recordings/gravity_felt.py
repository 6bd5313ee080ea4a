"""Whether gravity is in an accelerometer's readings, or was taken out, as phones do.

Over a second, and more so over a rest, a hand's acceleration has no mean, gravity has. Readings
whose means are far below gravity are in another unit where these means are alike, as gravity
is; and without gravity where they are not, or are next to nothing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from models.arrays import Array
from models.units import UNITS

WINDOW_S = 1.0
FEWEST = 4
"""Windows, of so many readings each."""
LITTLE = 0.4
"""Part of gravity below which a mean is not it."""
ALIKE, MOSTLY, NEARLY_ALL = 0.1, 0.5, 0.8
"""How near to their median means of gravity are, and in which part of the windows: of a unit's
gravity in most, of any other in nearly all."""
WITHIN = 1.25
"""How far gravity in another unit may lie from the mean, either way."""
TURNED, STEADY = 0.998, 0.03
"""Length of the mean direction below which it has turned, and noise over the mean at rest."""
MOVED = 2.0
"""Times the mean that readings of gravity are at most, nine of ten of them."""
NOTHING = 0.05
"""Part of gravity that a bias makes of a mean."""


@dataclass(frozen=True)
class FeltGravity:
    """What means over a second say.

    Parameters
    ----------
    mean_m_s2 : median of their sizes
    is_there : whether gravity is in it, in whichever unit; True where too little is known
    """

    mean_m_s2: float
    is_there: bool


def felt_gravity(time_s: Array, force: Array, gravity_m_s2: float) -> FeltGravity:
    """Return whether gravity is in readings of an accelerometer.

    Parameters
    ----------
    time_s, force : (n,), (n, 3) complete readings
    """
    window = np.floor((time_s - time_s[:1]) / WINDOW_S)
    _, first, count = np.unique(window, return_index=True, return_counts=True)
    whole = count >= FEWEST
    if whole.sum() < 2:
        return FeltGravity(0.0, True)
    sums = np.add.reduceat(force, first, axis=0)[whole] / count[whole, None]
    means = np.linalg.norm(sums, axis=1)
    typical = float(np.median(means))
    if typical > LITTLE * gravity_m_s2:
        return FeltGravity(typical, True)
    near = np.abs(means - typical) < ALIKE * typical
    factors = UNITS["m_s2"].values()
    in_units = [gravity_m_s2 * one / other for one in factors for other in factors]
    is_unit = any(typical / WITHIN < one < typical * WITHIN for one in in_units)
    alike, moved = float(near.mean()), float(np.quantile(np.linalg.norm(force, axis=1), 0.9))
    if typical > NOTHING * gravity_m_s2:
        is_there = alike > MOSTLY if is_unit else alike > NEARLY_ALL and moved < MOVED * typical
    elif not near.any():
        is_there = False
    else:
        # A bias of what has no gravity is alike, too: it does not turn, and its noise is no less.
        turned = np.linalg.norm((sums[near] / means[near, None]).mean(axis=0)) < TURNED
        norms = np.linalg.norm(force, axis=1)
        squares = np.add.reduceat(norms**2, first)[whole] / count[whole]
        spread = squares - (np.add.reduceat(norms, first)[whole] / count[whole]) ** 2
        steady = float(np.median(np.sqrt(np.maximum(spread, 0.0)))) < STEADY * typical
        calm = bool(turned) or moved < MOVED * typical
        is_there = is_unit and ((alike > NEARLY_ALL and calm) or (alike > MOSTLY and steady))
    return FeltGravity(typical, is_there)
