"""Angular rate without gyroscopes: integrated, and compensated inside the integration.

Without roll (ωx ≈ 0) the differential solution c says (12)

    ω̇y = -c_Z,   ω̇z = c_Y,   ωy² + ωz² = -c_X.

The first two are integrated. The third is redundant: with ω̂ the integrated rate and ε its
error (true = integrated - ε), to first order in ε,

    [ 2ω̂y    2ω̂z ] [εy]   [ ω̂y² + ω̂z² + c_X              ]
    [ c_Z   -c_Y  ] [εz] = [ ω̂y c_Z - ω̂z c_Y - ċ_X / 2   ]                      (13)-(16)

The determinant -2 (ω̂y c_Y + ω̂z c_Z) vanishes at rest and while the rate keeps its
direction: there the integration goes on by itself. The equations allow ω and -ω alike: the
sign comes from the start and the first motion.

References
----------
[GyroFree]; (13)-(16) re-derived.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from classical_baseline.differentiators import DIFFERENTIATORS, Differentiator
from models.arrays import Array
from models.errors import InputError


@dataclass(frozen=True)
class Compensation:
    """How the integrated rate is compensated.

    Parameters
    ----------
    differentiator : gives ċ_X; one with more noise does more harm
    least_determinant : rad³/s³; below this size nothing is compensated. Larger leaves more of
        the motion alone, smaller lets noise in where the rate is small or does not turn
    greatest_condition : of the matrix of (13)-(16); beyond it nothing is compensated. Smaller
        is more careful
    gain : part of ε that is taken off at a sample. 1 is the paper's; smaller averages the
        noise over more samples and follows later

    Raises
    ------
    InputError
        If a number is outside its range.
    """

    differentiator: Differentiator = DIFFERENTIATORS["savitzky-golay"]
    least_determinant: float = 2.0
    greatest_condition: float = 20.0
    gain: float = 1.0

    def __post_init__(self) -> None:
        if not self.least_determinant > 0:
            # At rest the determinant is zero, and zero must not be divided by.
            raise InputError(
                f"least_determinant is {self.least_determinant}, expected a positive number"
            )
        if not self.greatest_condition >= 1:
            raise InputError(
                f"greatest_condition is {self.greatest_condition}, expected at least 1"
            )
        if not 0 < self.gain <= 1:
            raise InputError(f"gain is {self.gain}, expected between 0 and 1")


@dataclass(frozen=True, eq=False)
class GyroFreeRate:
    """A gyroscope-free rate.

    Parameters
    ----------
    rate : (n, 3) rad/s, body axes; x is taken for zero
    compensated : (n,) true at the samples where the compensation applied
    """

    rate: Array
    compensated: NDArray[np.bool_]


def integrate_rate(
    c: Array,
    step_s: float,
    start: tuple[float, float] = (0.0, 0.0),
    compensation: Compensation | None = None,
) -> GyroFreeRate:
    """Integrate the differential solution by the trapezoidal rule.

    Parameters
    ----------
    c : (n, 3) differential solution, rad/s²
    step_s : of even samples, s
    start : ωy and ωz at the first sample, rad/s
    compensation : None integrates only

    Returns
    -------
    Rate of n samples; one with a NaN in c stays NaN from there on, as an integral must.

    Raises
    ------
    InputError
        If c has another shape, or the step is not positive.
    """
    if c.ndim != 2 or c.shape[1] != 3:
        raise InputError(f"differential solution has shape {c.shape}, expected (n, 3)")
    if not 0 < step_s < math.inf:
        raise InputError(f"step is {step_s} s, expected a positive time")
    rate, compensated = np.zeros((len(c), 3)), np.zeros(len(c), dtype=bool)
    if not len(c):
        return GyroFreeRate(rate, compensated)
    if compensation is None:
        wy_dot, wz_dot = -c[:, 2], c[:, 1]
        for column, first, derivative in ((1, start[0], wy_dot), (2, start[1], wz_dot)):
            chords = step_s / 2 * (derivative[1:] + derivative[:-1])
            rate[:, column] = first + np.concatenate([[0.0], np.cumsum(chords)])
        return GyroFreeRate(rate, compensated)

    cx_dot = compensation.differentiator(c[:, 0], step_s).tolist()
    samples = c.tolist()  # scalars of Python: a loop over these is ten times as fast
    wy, wz = start
    rate[0, 1:] = wy, wz
    for k in range(1, len(c)):
        cx, cy, cz = samples[k]
        wy += step_s / 2 * (-samples[k - 1][2] - cz)
        wz += step_s / 2 * (samples[k - 1][1] + cy)
        error = rate_error(wy, wz, (cx, cy, cz), cx_dot[k], compensation)
        if error is not None:
            wy -= compensation.gain * error[0]
            wz -= compensation.gain * error[1]
            compensated[k] = True
        rate[k, 1:] = wy, wz
    return GyroFreeRate(rate, compensated)


def rate_error(
    wy: float,
    wz: float,
    c: tuple[float, float, float],
    cx_dot: float,
    compensation: Compensation,
) -> tuple[float, float] | None:
    """Return the error (εy, εz) of an integrated rate, rad/s, equations (13)-(16).

    Parameters
    ----------
    wy, wz : integrated rate, rad/s
    c : differential solution of the sample, rad/s²
    cx_dot : ċ_X, rad/s³; NaN where it is not known yet

    Returns
    -------
    None where the matrix is too badly conditioned, or ċ_X is not known
    """
    cx, cy, cz = c
    determinant = -2 * (wy * cy + wz * cz)
    # Comparisons with NaN are false: whatever is not known is not compensated.
    if not (abs(determinant) >= compensation.least_determinant and math.isfinite(cx_dot)):
        return None
    squares = 4 * (wy * wy + wz * wz) + cy * cy + cz * cz
    root = math.sqrt(max(squares * squares - 4 * determinant * determinant, 0.0))
    # Largest over smallest singular value: their squares have this sum, and det² as product.
    if not squares + root <= 2 * abs(determinant) * compensation.greatest_condition:
        return None
    b1 = wy * wy + wz * wz + cx
    b2 = wy * cz - wz * cy - cx_dot / 2
    return (-cy * b1 - 2 * wz * b2) / determinant, (2 * wy * b2 - cz * b1) / determinant
