"""What a turn took: wall time and the CPU time of its thread.

On a machine that does other work wall time grows with it, and CPU time hardly. The
thread's clock takes longer to read than some steps last: what it finds around nothing is taken off.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from models.arrays import Array

THREAD_CLOCK = "thread CPU"
OWN_CPU_CLOCK = "its own, CPU"
OWN_WALL_CLOCK = "its own, wall"
"""Whose seconds stand for CPU time: a contender that only knows wall time tells too much."""

EMPTY_READINGS = 200
"""From which the least is what the clock itself takes."""


@dataclass(frozen=True)
class Counted:
    """Seconds that a contender counts itself, of a part of its work.

    Parameters
    ----------
    wall_s : of the part
    cpu_s : of the part; None where the contender does not know, and wall time stands for it
    """

    wall_s: float
    cpu_s: float | None = None


@dataclass(frozen=True)
class Reading:
    """One repeat: wall and CPU time (s), and whose clock told the CPU time."""

    wall_s: float
    cpu_s: float
    clock: str = THREAD_CLOCK


@dataclass(frozen=True)
class TurnTimes:
    """All repeats of one contender on one item."""

    readings: tuple[Reading, ...]

    @property
    def wall_s(self) -> Array:
        """(repeats,) wall times, s."""
        return np.array([reading.wall_s for reading in self.readings])

    @property
    def cpu_s(self) -> Array:
        """(repeats,) CPU times, s."""
        return np.array([reading.cpu_s for reading in self.readings])

    def per(self, samples: int) -> TurnTimes:
        """Return the turn divided by the samples that it took."""
        return TurnTimes(
            tuple(Reading(r.wall_s / samples, r.cpu_s / samples, r.clock) for r in self.readings)
        )


def read(solve: Callable[[], Counted | None], floor_ns: int) -> Reading:
    """Time a call; return what counts of it.

    Parameters
    ----------
    floor_ns : what the thread's clock takes itself
    """
    cpu_ns = time.thread_time_ns()
    wall_ns = time.perf_counter_ns()
    counted = solve()
    wall_s = 1e-9 * (time.perf_counter_ns() - wall_ns)
    cpu_s = 1e-9 * max(time.thread_time_ns() - cpu_ns - floor_ns, 0)
    if counted is None:
        return Reading(wall_s, cpu_s)
    if counted.cpu_s is None:
        return Reading(counted.wall_s, counted.wall_s, OWN_WALL_CLOCK)
    return Reading(counted.wall_s, counted.cpu_s, OWN_CPU_CLOCK)


def clock_floor_ns() -> int:
    """Return what the thread's clock finds around nothing, ns."""
    return min(_empty_ns() for _ in range(EMPTY_READINGS))


def _empty_ns() -> int:
    cpu_ns = time.thread_time_ns()
    wall_ns = time.perf_counter_ns()
    _ = time.perf_counter_ns() - wall_ns
    return time.thread_time_ns() - cpu_ns
