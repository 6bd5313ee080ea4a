"""Where a sensor repeats one reading for longer than its noise lets it.

A run is told from rest by what its sensor can do: a reading between two codes of a coarse sensor
repeats while it rests, one whose noise is at least a third of its finest step does not. Where a
sensor is coarser, another one that moves meanwhile gives it away.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from models.arrays import Array

SHORTEST_S, FEWEST = 0.5, 15
"""A run is at least so long and of so many readings."""
NOISY = 0.35
"""Noise over the finest step from which on readings do not repeat for that long."""
MOVES = 6.0
"""Times its quiet spread that another sensor spreads while it moves."""


@dataclass(frozen=True)
class RepeatedReading:
    """Readings first to end (excluded) that are the same."""

    first: int
    end: int
    start_s: float
    stop_s: float


def runs_of(time_s: Array, values: Array) -> list[RepeatedReading]:
    """Return the long runs of equal readings.

    Parameters
    ----------
    time_s, values : (n,), (n, k) of complete readings
    """
    same = (np.diff(values, axis=0) == 0).all(axis=1)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], same.astype(int), [0]]))).reshape(-1, 2)
    return [
        RepeatedReading(int(a), int(b) + 1, float(time_s[a]), float(time_s[b]))
        for a, b in edges
        if b - a + 1 >= FEWEST and time_s[b] - time_s[a] >= SHORTEST_S
    ]


def noise_of_steps(values: Array) -> tuple[Array, Array]:
    """Return per axis (k,) the finest step between readings, and the noise of the quiet half.

    Noise is that of third differences, which a hand's motion hardly enters.
    """
    steps = np.abs(np.diff(values, axis=0))
    finest = np.array([column[column > 0].min(initial=np.inf) for column in steps.T])
    third = np.abs(np.diff(values, n=3, axis=0)) / np.sqrt(20.0)
    noise = np.quantile(third, 0.3, axis=0) / 0.385 if len(third) else np.zeros(values.shape[1])
    return finest, np.asarray(noise)


def stuck_runs(
    time_s: Array,
    values: Array,
    others: list[tuple[Array, Array]],
    *,
    limit: float | None = None,
) -> list[RepeatedReading]:
    """Return the runs that are no rest.

    Parameters
    ----------
    others : times and readings of other sensors that would see the pen move
    limit : end of the sensor's range; a reading that is there on every axis is no stuck one
    """
    found = [
        run
        for run in runs_of(time_s, values)
        if limit is None or (np.abs(values[run.first]) < limit).any()
    ]
    if not found:
        return []
    free = np.ones(len(values), dtype=bool)
    for run in found:
        free[run.first : run.end] = False
    if free.sum() < FEWEST:
        return found  # it never said anything else
    finest, noise = noise_of_steps(values[free])
    if (noise > NOISY * finest).any():
        return found
    return [run for run in found if any(_moves(run, *other) for other in others)]


def _moves(run: RepeatedReading, time_s: Array, values: Array) -> bool:
    inside = (time_s >= run.start_s) & (time_s <= run.stop_s)
    if inside.sum() < FEWEST:
        return False
    blocks = np.array_split(values, max(1, len(values) // FEWEST))
    quiet = np.quantile([block.std(axis=0) for block in blocks], 0.1, axis=0)
    here = np.median(np.abs(values[inside] - np.median(values[inside], axis=0)), axis=0)
    return bool((here > MOVES * quiet + np.finfo(float).tiny).any())
