"""An accelerometer's bias, scale and misalignment from the length of gravity.

Its mean readings in still poses, see `pen_mhe.calibration.length`.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from models.arrays import Array
from models.errors import InputError
from pen_mhe.calibration.length import N_BIAS, N_SCALE, PARAMETERS, LengthFit, fit_length

COUNTS: Mapping[str, int] = MappingProxyType(
    {"noise": 0, "bias": N_BIAS, "scale": N_SCALE, "misalignment": len(PARAMETERS)}
)
"""What is looked for → how many of `PARAMETERS`, from the first."""

DIFFERENT_RAD = np.radians(10.0)
"""Poses count as different from here on."""


def different_poses(means: Array) -> int:
    """Return how many mean readings (p, 3) point elsewhere than all counted before."""
    counted: list[Array] = []
    for direction in means / np.linalg.norm(means, axis=1, keepdims=True):
        if all(direction @ other < np.cos(DIFFERENT_RAD) for other in counted):
            counted.append(direction)
    return len(counted)


def fit_gravity(
    means: Array,
    variances: Array,
    gravity_m_s2: float,
    find: str,
    *,
    bias: Array,
    sensitivity: Array,
    name: str = "accelerometer",
) -> LengthFit:
    """Find an accelerometer's parameters from its mean readings in still poses.

    Parameters
    ----------
    means : (p, 3) m/s²
    variances : (p, 3) of the means, by noise alone
    find : a key of `COUNTS` with parameters; what is not found stays as it is
    bias, sensitivity : (3,), (3, 3) to begin from
    name : for messages

    Raises
    ------
    InputError
        If the poses are too few, or too similar to tell the parameters apart.
    """
    count = COUNTS[find]
    poses = different_poses(means)
    if poses < count + 1:
        raise InputError(
            f"{name} was still in {poses} different {'pose' if poses == 1 else 'poses'} "
            f"({np.degrees(DIFFERENT_RAD):g}° apart), expected at least {count + 1} "
            f"to find its {find}{_or_less(find)}"
        )
    return fit_length(
        means,
        variances,
        gravity_m_s2,
        count,
        bias=bias,
        sensitivity=sensitivity,
        too_similar=f"{name}: its poses are too similar to tell {{0}} from {{1}}, expected "
        f"poses on all sides, each axis up and down{_or_less(find)}",
    )


def _or_less(find: str) -> str:
    names = tuple(COUNTS)
    less = names[1 : names.index(find)]
    return f"; less is found by --find {' or '.join(less)}" if less else "; or --find noise"
