"""Limits of a watch's statistics: what a sensor says is usual, else what chance explains."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from estimation.chi_square import quantile, upper_quantile
from models.arrays import Array
from models.sensor_model import SensorModel
from models.state_space import StateSpaceModel

WINDOWS_S = (0.1, 1.0)
"""How long the windows of mean and energy remember, s, at the sensor's own rate."""
MEASURES = ("mean_fast", "mean_slow", "energy_fast", "energy_slow")
USUAL = (*MEASURES, "peak")
"""What a sensor says is usual: those, and d² per row of a single sample."""
USUAL_RATE_HZ = 100.0
"""Of a sensor that says none."""
OUTLIER_PROBABILITY = 1 - 1e-7
OUTLIERS_S, FEWEST_OUTLIERS = 0.08, 4
"""How long, and how many, outliers in a row make an alarm."""
FEWEST_SAME, SAME_MARGIN = 6, 1.5
"""Of an axis alone: a sensor at rest is often quieter than its pen file says."""
QUIETER = 1.5
"""By how much a sensor may be quieter than its pen file says, before repeats count: many are at
rest, and samples behind a low-pass filter are like their neighbours."""
REPEATS_S = 0.5
"""Repeats that are no further apart count together."""
FALSE_STUCK_S = 3600.0
"""Between two alarms of a sensor that repeats itself by chance, s."""
CHANCE, ALLOWANCE = 1e-9, (3.0, 8.0)
"""Of a sensor that does not say what is usual: the probability at an instant, and by how much
means and energies may exceed it. Hands pause and hurry: on the D-POINT pen energies that are one
on average reach ten times that, while nothing is wrong."""
MARGIN = 1.6
FLOORS = (12.0, 8.0, 0.5, 0.3)
"""An alarm is what exceeds the usual by this factor, and these values; those of means only where
gravity is felt: at a start from a wide prior an accelerometer's are far above the usual."""


@dataclass(frozen=True)
class SensorLimits:
    """Limits of one sensor.

    Parameters
    ----------
    weights : of a sample in each window
    squared : largest d² of 1, 2, … rows that is no outlier
    outliers : so many in a row are an alarm
    same : so many samples in a row that one axis repeats are an alarm; inf is none
    repeats : so many within `REPEATS_S` of each other are an alarm; 0 is none, however many
    usual, limit : of `MEASURES`; the largest of clean data, and those that are an alarm
    """

    weights: tuple[float, ...]
    squared: tuple[float, ...]
    outliers: int
    repeats: int
    same: float
    usual: tuple[float, ...]
    limit: tuple[float, ...]


def limits_of(model: StateSpaceModel) -> list[SensorLimits | None]:
    """Return the limits of a model's sensors; None for those without readings of their own."""
    return [_limits(sensor) if sensor.is_measured else None for sensor in model.sensors]


def _limits(sensor: SensorModel) -> SensorLimits:
    rate_hz = sensor.rate_hz or USUAL_RATE_HZ
    weights = tuple(-math.expm1(-1 / (rate_hz * tau)) for tau in WINDOWS_S)
    *usual, peak = sensor.usual_innovations or _by_chance(sensor.n_r, weights)
    squared = tuple(
        max(float(quantile(OUTLIER_PROBABILITY, n)), MARGIN * peak * n)
        for n in range(1, sensor.n_r + 1)
    )
    means = FLOORS[:2] if sensor.feels_gravity else (0.0, 0.0)
    return SensorLimits(
        weights=weights,
        squared=squared,
        outliers=max(FEWEST_OUTLIERS, round(OUTLIERS_S * rate_hz)),
        repeats=_repeats(sensor, rate_hz),
        same=_same(sensor, rate_hz),
        usual=tuple(usual),
        limit=tuple(np.maximum(MARGIN * np.array(usual), (*means, *FLOORS[2:])).tolist()),
    )


def _by_chance(n: int, weights: tuple[float, ...]) -> tuple[float, ...]:
    """Return what white samples of n rows exceed with probability `CHANCE`, and `ALLOWANCE`."""
    of_mean, of_energy = ALLOWANCE
    means = [of_mean * float(upper_quantile(CHANCE, n))] * len(weights)
    samples = [(2 - a) / a * n for a in weights]
    energies = (of_energy * float(upper_quantile(CHANCE, many)) / many for many in (*samples, n))
    return (*means, *energies)


def _repeats(sensor: SensorModel, rate_hz: float) -> int:
    """Return how many repeats, each within `REPEATS_S` of one before, chance makes seldom enough.

    Two samples with noise σ of a quantiser of step Δ are equal with probability Δ / (2 √π σ) at
    most; one is compared with two. N repeats in a chain come by chance at a rate of
    rate p (REPEATS_S rate p)ᴺ⁻¹, once in `FALSE_STUCK_S` at most. A sensor that reads nothing but
    the height of what it touches repeats itself always.
    """
    if sensor.touched_height is not None:
        return 0
    if sensor.resolution <= 0 or sensor.n_r != sensor.n_y:
        return 1
    chance = 2 * math.exp(float(_log_chances(sensor).sum()))
    next_one = chance * REPEATS_S * rate_hz
    if next_one >= 1:
        return 0
    alone = math.log(FALSE_STUCK_S * rate_hz * chance) / -math.log(next_one)
    return 1 + max(0, math.ceil(alone))


def _same(sensor: SensorModel, rate_hz: float) -> float:
    """Return how often one axis repeats itself by chance once in `FALSE_STUCK_S` at most.

    Of a sensor without a quantiser, or with rows that are not its axes, nobody knows.
    """
    if sensor.resolution <= 0 or sensor.n_r != sensor.n_y or sensor.touched_height is not None:
        return math.inf
    most = -math.log(FALSE_STUCK_S * rate_hz) / float(_log_chances(sensor).max())
    return max(FEWEST_SAME, math.ceil(SAME_MARGIN * most))


def _log_chances(sensor: SensorModel) -> Array:
    """Return the logarithm of the chance that a sample equals another, (n_r,)."""
    chance = QUIETER * sensor.resolution / (2 * math.sqrt(math.pi) * sensor.noise_std)
    return np.asarray(np.log(np.minimum(chance, 0.9)))
