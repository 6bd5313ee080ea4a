"""The race: contenders in turn on every item, by one clock.

Item by item, each contender has a turn; who begins moves on by one per item, so that no
one always finds the caches as another left them. A turn repeats prepare and solve until
`TURN_S` seconds or `MOST_REPEATS` are spent: one interrupt more or less does not decide what
takes microseconds. No garbage is collected while it lasts. Between the calls of a contender that
starts cold a large array is written, which leaves nothing else in the processor's caches.
"""

from __future__ import annotations

import gc
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Generic

import numpy as np

from models.state_space import StateSpaceModel
from suites.shared_core import CoreClock
from suites.speed.clock import Reading, TurnTimes, clock_floor_ns, read
from suites.speed.contender import Contender, ContenderAbsentError, Entry, ItemT, RaceOutcome

TURN_S = 2e-3
MOST_REPEATS = 11
CACHES_BYTES = 64_000_000
"""More than the caches of a processor hold."""


@dataclass(frozen=True, eq=False)
class Racer(Generic[ItemT]):
    """A contender that was built, and what it did.

    Parameters
    ----------
    entry : its row
    contender : itself
    build_s : time to build it
    turns, outcomes : per item, warm-up left out
    """

    entry: Entry[ItemT]
    contender: Contender[ItemT]
    build_s: float
    turns: list[TurnTimes] = field(default_factory=list)
    outcomes: list[RaceOutcome] = field(default_factory=list)

    @property
    def times_s(self) -> list[float]:
        """Median wall time per item, s."""
        return [float(np.median(turn.wall_s)) for turn in self.turns]


def built(
    entries: Sequence[Entry[ItemT]],
    model: StateSpaceModel,
    example: ItemT,
    absent: Callable[[Entry[ItemT], str], object],
) -> list[Racer[ItemT]]:
    """Build contenders one after the other.

    Parameters
    ----------
    example : any item of the race
    absent : called with one that cannot be built, and why
    """
    racers = []
    for entry in entries:
        start = time.perf_counter()
        try:
            contender = entry.build(model, example)
            racers.append(Racer(entry, contender, time.perf_counter() - start))
        except ContenderAbsentError as reason:
            absent(entry, str(reason))
    return racers


def race(racers: Sequence[Racer[ItemT]], items: Sequence[ItemT], warm_up: int) -> float:
    """Let all contenders solve all items; results go into the racers.

    Returns the part of the time in which the processor was this process's: what is missing
    to 1 went to other work, and makes times too long.

    Parameters
    ----------
    warm_up : how many of the items come first and do not count
    """
    floor_ns = clock_floor_ns()
    with _garbage_kept():
        clock = CoreClock()
        for i, item in enumerate(items):
            first = i % max(len(racers), 1)
            for racer in [*racers[first:], *racers[:first]]:
                turn, outcome = _turn(racer, item, floor_ns)
                if i >= warm_up:
                    racer.turns.append(turn.per(racer.entry.samples))
                    racer.outcomes.append(outcome)
        return clock.share()


def _turn(racer: Racer[ItemT], item: ItemT, floor_ns: int) -> tuple[TurnTimes, RaceOutcome]:
    """Return the times of one contender on one item, and what it found."""
    contender = racer.contender
    readings: list[Reading] = []
    spent_s = 0.0
    while not readings or (spent_s < TURN_S and len(readings) < MOST_REPEATS):
        contender.prepare(item)
        if racer.entry.is_cold:
            forget_caches()
        reading = read(contender.solve, floor_ns)
        readings.append(reading)
        spent_s += reading.wall_s
    return TurnTimes(tuple(readings)), contender.outcome()


def forget_caches() -> None:
    """Leave nothing in the processor's caches but a large array."""
    np.zeros(CACHES_BYTES // 8).fill(1.0)


@contextmanager
def _garbage_kept() -> Iterator[None]:
    """Collect garbage now, and none within."""
    was_on = gc.isenabled()
    gc.collect()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()
