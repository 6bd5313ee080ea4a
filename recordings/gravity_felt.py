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
ALIKE = 0.25
"""Half the spread of the windows' means, 10 to 90 %, over their median: above, they are not gravity
in another unit."""
WITHIN = 1.25
"""How far gravity in another unit may lie from the mean, either way."""
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
    sure : 0 to 1
    """

    mean_m_s2: float
    is_there: bool
    sure: float


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
        return FeltGravity(0.0, True, 0.0)
    sums = np.add.reduceat(force, first, axis=0)[whole] / count[whole, None]
    means = np.linalg.norm(sums, axis=1)
    typical = float(np.median(means))
    if typical > LITTLE * gravity_m_s2:
        return FeltGravity(typical, True, 1.0)
    low, high = np.quantile(means, [0.1, 0.9])
    varies = float(high - low) > 2 * ALIKE * typical
    if not varies and float(np.quantile(np.linalg.norm(force, axis=1), 0.9)) < MOVED * typical:
        factors = UNITS["m_s2"].values()
        in_units = [gravity_m_s2 * one / other for one in factors for other in factors]
        is_unit = any(typical / WITHIN < one < typical * WITHIN for one in in_units)
        if is_unit or typical > NOTHING * gravity_m_s2:  # or of a scale of its own
            return FeltGravity(typical, True, 0.9)
    return FeltGravity(typical, False, 0.98)
