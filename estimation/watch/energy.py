"""Whether what stands out looks like a body that moves more than its model says."""

from __future__ import annotations

from collections.abc import Container

from estimation.watch.statistics import Statistics
from estimation.watch.watchable import Numbers

BUSY = 0.5
"""Share of the samples with such an energy, in a motion that is livelier."""


def is_livelier(
    statistics: Statistics, memory: Numbers, left_out: Container[int], *, share: float = 1.0
) -> bool:
    """Whether it looks as if the body moves more than its model says.

    All inertial sensors have more energy than a share of the usual: one that lies leaves the
    others about as they were. Or the only thing that stands out is energy, of those that are busy
    with it.
    """
    inertial = [x for x in statistics.sensors if x.is_inertial and x.index not in left_out]
    values, windows = statistics.values(memory), statistics.windows
    shares = [
        max(values[x.index][w] / x.limits.usual[w] for w in range(windows, 2 * windows))
        for x in inertial
    ]
    if shares and min(shares) > share:
        return True
    if not is_only_energy(statistics, memory, left_out):
        return False
    busy = statistics.layout.slices["busy"].start
    energetic = _energetic(statistics, memory, left_out)
    return bool(energetic) and all(memory[busy + i] > BUSY for i in energetic)


def is_calm(
    statistics: Statistics, memory: Numbers, factor: float, *, left_out: Container[int] = ()
) -> bool:
    """Whether all inertial sensors would be usual, were their energy larger by a factor."""
    values = statistics.values(memory)
    return all(
        factor * values[x.index][-1] <= x.limits.usual[-1]
        for x in statistics.sensors
        if x.is_inertial and x.index not in left_out
    )


def is_only_energy(statistics: Statistics, memory: Numbers, left_out: Container[int]) -> bool:
    """Whether nothing else stands out but the energy of inertial sensors.

    A mean that stands out no more than its energy does is of the same size by chance.
    """
    values, windows = statistics.values(memory), statistics.windows
    outliers = statistics.layout.slices["outliers"].start
    for x in statistics.sensors:
        i = x.index
        if i in left_out:
            continue
        shares = [value / limit for value, limit in zip(values[i], x.limits.limit, strict=True)]
        means = any(shares[w] > max(1.0, shares[windows + w]) for w in range(windows))
        if means or memory[outliers + i] >= x.limits.outliers:
            return False
    energetic = _energetic(statistics, memory, left_out)
    return all(x.is_inertial for x in statistics.sensors if x.index in energetic)


def _energetic(statistics: Statistics, memory: Numbers, left_out: Container[int]) -> list[int]:
    """Return the sensors whose energy is above its limit."""
    values, windows = statistics.values(memory), statistics.windows
    return [
        x.index
        for x in statistics.sensors
        if x.index not in left_out
        and any(values[x.index][w] > x.limits.limit[w] for w in range(windows, 2 * windows))
    ]
