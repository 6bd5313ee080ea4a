"""Limits of a watch's statistics: of clean data by the kind of a sensor, of chance for others."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources

import numpy as np
from scipy.stats import chi2

from models.arrays import Array
from models.sensor_model import SensorModel
from models.state_space import StateSpaceModel

WINDOWS_S = (0.1, 1.0)
"""How long the windows of mean and energy remember, s, at the sensor's own rate."""
MEASURES = ("mean_fast", "mean_slow", "energy_fast", "energy_slow")
USUAL_RATE_HZ = 100.0
"""Of a sensor that says none."""
OUTLIER_PROBABILITY = 1 - 1e-7
OUTLIERS_S, FEWEST_OUTLIERS = 0.08, 4
"""How long, and how many, outliers in a row make an alarm."""
FEWEST_SAME, SAME_MARGIN = 6, 1.5
"""Of an axis alone: a sensor at rest is often quieter than its pen file says."""
FALSE_STUCK_S = 3600.0
"""Between two alarms of a sensor that repeats itself by chance, s."""
CHANCE, MARGIN = 1e-9, 1.6
"""Of a sensor whose kind has no limits: probability of an alarm at an instant, and a margin."""


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


@cache
def limit_table() -> Mapping[str, Mapping[str, list[float]]]:
    """Return kind → ``usual`` and ``limit`` of `MEASURES`, as limits.toml says."""
    return tomllib.loads((resources.files("estimation.watch") / "limits.toml").read_text("utf-8"))


def limits_of(model: StateSpaceModel) -> list[SensorLimits | None]:
    """Return the limits of a model's sensors; None for those without readings of their own."""
    return [_limits(sensor) if sensor.is_measured else None for sensor in model.sensors]


def _limits(sensor: SensorModel) -> SensorLimits:
    rate_hz = sensor.rate_hz or USUAL_RATE_HZ
    weights = tuple(-math.expm1(-1 / (rate_hz * tau)) for tau in WINDOWS_S)
    squared = tuple(float(chi2.ppf(OUTLIER_PROBABILITY, n)) for n in range(1, sensor.n_r + 1))
    known = limit_table().get(sensor.kind)
    usual = tuple(known["usual"]) if known else _by_chance(sensor.n_r, weights)
    return SensorLimits(
        weights=weights,
        squared=squared,
        outliers=max(FEWEST_OUTLIERS, round(OUTLIERS_S * rate_hz)),
        repeats=_repeats(sensor, rate_hz),
        same=_same(sensor, rate_hz),
        usual=usual,
        limit=tuple(known["limit"]) if known else tuple(MARGIN * each for each in usual),
    )


def _by_chance(n: int, weights: tuple[float, ...]) -> tuple[float, ...]:
    """Return what white samples of n rows exceed with probability `CHANCE`."""
    means = [float(chi2.isf(CHANCE, n))] * len(weights)
    samples = [(2 - a) / a * n for a in weights]
    return (*means, *(float(chi2.isf(CHANCE, many)) / many for many in samples))


def _repeats(sensor: SensorModel, rate_hz: float) -> int:
    """Return how many repeats chance makes once in `FALSE_STUCK_S` at most.

    Two samples with noise σ of a quantiser of step Δ are equal with probability Δ / (2 √π σ) at
    most. A sensor that reads nothing but the height of what it touches repeats itself always.
    """
    if sensor.touched_height is not None:
        return 0
    if sensor.resolution <= 0 or sensor.n_r != sensor.n_y:
        return 1
    return max(1, math.ceil(-math.log(FALSE_STUCK_S * rate_hz) / float(_log_chances(sensor).sum())))


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
    chance = sensor.resolution / (2 * math.sqrt(math.pi) * sensor.noise_std)
    return np.asarray(np.log(np.minimum(chance, 0.9)))
