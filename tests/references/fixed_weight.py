"""Fixed-weight fusion by rotation matrices: no angles, no formula (18).

The previous vector is turned about y alone and about x alone. Of the first result the
ratio x : z counts, of the second the ratio y : z; one vector has both ratios, up to its
sign.
"""

from __future__ import annotations

import numpy as np


def fixed_weight_by_rotations(weight, time_s, acceleration, rates, sign="turned"):
    """Return R (n, 3)."""
    found = [acceleration[0] / np.linalg.norm(acceleration[0])]
    for n in range(1, len(time_s)):
        before = found[-1]
        turned = turned_by_rotations(
            before, (rates[n] + rates[n - 1]) / 2 * (time_s[n] - time_s[n - 1]), sign
        )
        length = np.linalg.norm(acceleration[n])
        both = turned if length == 0 else acceleration[n] / length + weight * turned
        found.append(both / np.linalg.norm(both))
    return np.array(found)


def turned_by_rotations(before, turn, sign="turned"):
    """Return R_g for turns (about x, about y) of the carrier, rad."""
    # Gravity turns against the carrier.
    (about_x, _), (_, about_y) = (_against(turn, axis) for axis in (0, 1))
    by_x, by_y = about_x @ before, about_y @ before
    z = before[2] if sign == "previous" else by_x[2] + by_y[2] - before[2]
    ratios = np.array([by_y[0] / abs(by_y[2]), by_x[1] / abs(by_x[2]), -1.0 if z < 0 else 1.0])
    return ratios / np.linalg.norm(ratios)


def _against(turn, axis):
    c, s = np.cos(turn[axis]), np.sin(turn[axis])
    about_x = np.array([[1, 0, 0], [0, c, s], [0, -s, c]])
    about_y = np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])
    return about_x, about_y
