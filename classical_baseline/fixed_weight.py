"""Fixed-weight fusion: the direction of gravity from an accelerometer and two rates.

With R the unit vector that a resting accelerometer reads, in body axes, and R_acc the
reading, normalised (7)-(9), R(0) = R_acc(0) (10), for every sample n:

    φ = atan2(R_x, R_z),   θ = atan2(R_y, R_z)                 of R(n - 1)                (13)
    φ ← φ - ω̄_y T,         θ ← θ + ω̄_x T                                            (14)-(17)
    ω̄ = (ω(n) + ω(n - 1)) / 2                                                             (15)
    R_gx = sinφ / √(1 + cos²φ tan²θ),   R_gy = sinθ / √(1 + cos²θ tan²φ)
    R_gz = sign(R_z(n - 1)) √(1 - R_gx² - R_gy²)                                          (18)
    R(n) ∝ R_acc + w R_g                                                             (19)-(21)

The copy of the paper that we have has lost (18) to (21): nothing of them is as printed. A convex
sum, R(n) ∝ (1 - w) R_acc + w R_g, is as natural a reading; `weight_of_sum` leads from one to the
other.

φ and θ turn by a rate each. While the carrier turns about its axis x or y, and that axis
is level, this is exact for a constant rate and of second order in T otherwise. While it
turns about both, about z, or about one that is not level, something is missing that does
not vanish with T: φ̇ = -ω_y + (ω_x R_x + ω_z R_z) R_y / (R_x² + R_z²).

Two things need care. The radicand of (18) can be negative from rounding: it counts as
zero. And the sign of R_z(n - 1) is late where this very turn takes R through R_z = 0: R_g
is then turned back by as much, and a large w holds R up at 90° until R_acc has turned
far enough to outweigh it. The sign here is that of

    √(R_x² + R_z²) cosφ + √(R_y² + R_z²) cosθ - R_z(n - 1)

with the turned angles: each turn's own z, which is exact where one of them is zero.

References
----------
[Tilt] (7)-(21); (8), (12)-(15) and (18)-(21) re-derived.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from models.arrays import Array
from models.errors import InputError
from models.names import expected_one_of

Vector = tuple[float, float, float]
Rates = tuple[float, float]
Form = Literal["smooth", "tangents"]
Sign = Literal["turned", "previous"]

GYROSCOPE_ALONE = 1e-15
"""Part of the accelerometer in a convex sum that is as good as none."""

SMALLEST = 1e-12
"""A vector shorter than this has no direction."""


@dataclass(frozen=True)
class FixedWeightConfig:
    """How accelerometer and gyroscope are weighed.

    Parameters
    ----------
    weight : w of the gyroscope; the accelerometer has 1. Larger is smoother, forgets an
        error later (within about w samples), and trusts the gyroscope's bias and the
        neglected second axis more. 0 is the accelerometer alone
    form : of (18); ``tangents`` as above, ``smooth`` without them,
        R_g ∝ (sinφ |cosθ|, |cosφ| sinθ, ± |cosφ cosθ|)
    sign : of R_gz; ``previous`` as in (18) above, ``turned`` as below it

    Raises
    ------
    InputError
        If the weight is negative, or a form is unknown.
    """

    weight: float = 0.25
    form: Form = "smooth"
    sign: Sign = "turned"

    def __post_init__(self) -> None:
        if not 0 <= self.weight < math.inf:
            raise InputError(f"weight is {self.weight}, expected a number from 0 on")
        for name, allowed in (("form", get_args(Form)), ("sign", get_args(Sign))):
            if getattr(self, name) not in allowed:
                raise InputError(
                    f"{name} is {getattr(self, name)}, "
                    f"{expected_one_of(getattr(self, name), allowed)}"
                )


def weight_of_sum(convex: float) -> float:
    """Return w of R_acc + w R_g for that of (1 - w) R_acc + w R_g, from 0 to 1.

    1 is the gyroscope alone, for which the sum has no weight: one that leaves the accelerometer
    as much as rounding does.
    """
    return convex / max(1 - convex, GYROSCOPE_ALONE)


@dataclass(frozen=True)
class FixedWeightState:
    """R(n), a unit vector in body axes, and the rates (ω_x, ω_y) of sample n, rad/s."""

    direction: Vector
    rates: Rates


def init(acceleration: Vector, rates: Rates) -> FixedWeightState:
    """Return the state of the first sample, (10).

    Parameters
    ----------
    acceleration : in any unit
    rates : (ω_x, ω_y), rad/s

    Raises
    ------
    InputError
        If the acceleration is zero: it has no direction to begin with.
    """
    direction = _normalised(*acceleration)
    if direction is None:
        raise InputError("the first acceleration is zero, expected one with a direction")
    return FixedWeightState(direction, rates)


def step(
    config: FixedWeightConfig,
    state: FixedWeightState,
    acceleration: Vector,
    rates: Rates,
    step_s: float,
) -> FixedWeightState:
    """Take one sample, equations (13)-(21).

    Where the acceleration is zero, or cancels R_g, what the gyroscope says is kept.

    Parameters
    ----------
    acceleration, rates : as for `init`
    step_s : T since the sample before, s
    """
    turn_phi = -(rates[1] + state.rates[1]) / 2 * step_s
    turn_theta = (rates[0] + state.rates[0]) / 2 * step_s
    turned = turn(state.direction, turn_phi, turn_theta, config.form, config.sign)
    return FixedWeightState(_fused(acceleration, turned, config.weight), rates)


def run(config: FixedWeightConfig, time_s: Array, acceleration: Array, rates: Array) -> Array:
    """Return R (n, 3) of all samples.

    Parameters
    ----------
    time_s : (n,) increasing instants, s
    acceleration : (n, 3) in any unit
    rates : (n, 2) (ω_x, ω_y), rad/s

    Raises
    ------
    InputError
        If shapes disagree, a number is not finite, times do not increase, or the first
        acceleration is zero.
    """
    _check(time_s, acceleration, rates)
    vectors, pairs = acceleration.tolist(), rates.tolist()  # scalars: ten times as fast
    state = init(tuple(vectors[0]), tuple(pairs[0]))
    directions = [state.direction]
    for vector, pair, step_s in zip(vectors[1:], pairs[1:], np.diff(time_s).tolist(), strict=True):
        state = step(config, state, vector, pair, step_s)
        directions.append(state.direction)
    return np.array(directions)


def turn(direction: Vector, turn_phi: float, turn_theta: float, form: Form, sign: Sign) -> Vector:
    """Return R_g: a unit vector whose projected angles have turned, (13)-(18).

    Where R_g would have no direction (R_x and R_y both far from zero, R_z zero to rounding:
    the two angles no longer tell R_x from R_y) the vector stays.

    Parameters
    ----------
    turn_phi, turn_theta : rad
    """
    x, y, z = direction
    phi = math.atan2(x, z) + turn_phi
    theta = math.atan2(y, z) + turn_theta
    sin_phi, cos_phi, sin_theta, cos_theta = (
        math.sin(phi),
        math.cos(phi),
        math.sin(theta),
        math.cos(theta),
    )
    side = z
    if sign == "turned":
        side = math.hypot(x, z) * cos_phi + math.hypot(y, z) * cos_theta - z
    if form == "tangents":
        gx = sin_phi / math.sqrt(1 + (cos_phi * sin_theta / cos_theta) ** 2)
        gy = sin_theta / math.sqrt(1 + (cos_theta * sin_phi / cos_phi) ** 2)
        gz = math.copysign(math.sqrt(max(1 - gx * gx - gy * gy, 0.0)), side)
    else:
        gx = sin_phi * abs(cos_theta)
        gy = abs(cos_phi) * sin_theta
        gz = math.copysign(abs(cos_phi * cos_theta), side)
    return _normalised(gx, gy, gz) or direction


def _fused(acceleration: Vector, turned: Vector, weight: float) -> Vector:
    """Return R, (19)-(21)."""
    measured = _normalised(*acceleration)
    if measured is None:
        return turned
    x, y, z = (a + weight * g for a, g in zip(measured, turned, strict=True))
    return _normalised(x, y, z) or turned


def _normalised(x: float, y: float, z: float) -> Vector | None:
    """Return a unit vector, (8) and (21); None where there is no direction."""
    length = math.hypot(x, y, z)
    if not SMALLEST <= length < math.inf:
        return None
    return x / length, y / length, z / length


def _check(time_s: Array, acceleration: Array, rates: Array) -> None:
    n = len(time_s)
    for name, values, width in (("accelerations", acceleration, 3), ("rates", rates, 2)):
        if values.shape != (n, width):
            raise InputError(f"{name} have shape {values.shape}, expected ({n}, {width})")
        if not np.isfinite(values).all():
            row = int(np.argwhere(~np.isfinite(values))[0, 0])
            raise InputError(f"{name} of sample {row} are not finite, expected numbers")
    if n == 0:
        raise InputError("there are no samples, expected at least one")
    if not (np.diff(time_s) > 0).all():
        raise InputError("times of the samples do not increase, expected increasing times")
