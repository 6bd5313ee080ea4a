"""When a pen rests, and how noisy its sensors are then.

A pen that lies still reads white noise in every inertial sensor at once, of one mean, for longer
than a second; one that writes may read white noise in some, as paper scratches.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from models.arrays import Array

BLOCK_S = 0.5
FEWEST, BLOCKS = 8, 3
"""Readings in a block, and successive blocks of a rest."""
WHITE = 0.4
"""Mean square of successive differences over twice the variance: 1 for white noise, little for a
hand."""
HALVES = 5.0
"""Standard errors by which the means of a rest's blocks differ at most."""


def noise_at_rest(signals: Mapping[str, tuple[Array, Array]]) -> dict[str, Array]:
    """Return the standard deviations of readings (k,) at rest by sensor; none without a rest.

    Parameters
    ----------
    signals : times (n,) and complete readings (n, k) of all inertial sensors
    """
    known = {name: signal for name, signal in signals.items() if len(signal[0]) >= FEWEST}
    if not known:
        return {}
    numbers = np.unique(np.concatenate([np.floor(t / BLOCK_S) for t, _ in known.values()]))
    if len(numbers) < BLOCKS:
        return {}
    seen = {name: _Blocks(numbers, *signal) for name, signal in known.items()}
    white = np.all([each.white for each in seen.values()], axis=0)
    goes_on = np.all([each.alike for each in seen.values()], axis=0) & (np.diff(numbers) == 1)
    goes_on &= white[1:] & white[:-1]
    whole = np.convolve(goes_on, np.ones(BLOCKS - 1), "valid") == BLOCKS - 1
    at = np.unique(np.flatnonzero(whole)[:, None] + np.arange(BLOCKS))
    if not len(at):
        return {}
    return {name: np.sqrt(np.median(each.variance[at], axis=0)) for name, each in seen.items()}


class _Blocks:
    """Blocks of one sensor: variance (b, k), whether white (b,), whether of the mean before it."""

    def __init__(self, numbers: Array, time_s: Array, values: Array) -> None:
        blocks = len(numbers)
        self.variance = np.full((blocks, values.shape[1]), np.nan)
        mean = np.full((blocks, values.shape[1]), np.nan)
        n = np.zeros(blocks)
        self.white: NDArray[np.bool_] = np.zeros(blocks, dtype=bool)
        firsts, ends = (np.searchsorted(time_s, BLOCK_S * (numbers + k)) for k in (0, 1))
        for i, (a, b) in enumerate(zip(firsts, ends, strict=True)):
            here = values[a:b]
            if b - a < FEWEST:
                continue
            n[i], mean[i], self.variance[i] = b - a, here.mean(axis=0), here.var(axis=0, ddof=1)
            steps = np.mean(np.diff(here, axis=0) ** 2, axis=0) / 2
            self.white[i] = (steps >= WHITE * self.variance[i]).all() and self.variance[i].any()
        with np.errstate(divide="ignore", invalid="ignore"):
            chance = self.variance[1:] / n[1:, None] + self.variance[:-1] / n[:-1, None]
            self.alike = (np.diff(mean, axis=0) ** 2 <= HALVES**2 * chance).all(axis=1)
