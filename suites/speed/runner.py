"""The race: contenders in turn on every item, by one clock.

Item by item, each contender has a turn; who begins moves on by one per item, so that no
one always finds the caches as another left them. A turn repeats prepare and solve until
`TURN_S` seconds or `MOST_REPEATS` are spent and counts the median: one interrupt more or
less does not decide what takes microseconds. No garbage is collected while it lasts.
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
from suites.speed.contender import Contender, ContenderAbsentError, Entry, ItemT, RaceOutcome

TURN_S = 2e-3
MOST_REPEATS = 11


@dataclass(frozen=True, eq=False)
class Racer(Generic[ItemT]):
    """A contender that was built, and what it did.

    Parameters
    ----------
    entry : its row
    contender : itself
    build_s : time to build it
    times_s, outcomes : per item, warm-up left out
    """

    entry: Entry[ItemT]
    contender: Contender[ItemT]
    build_s: float
    times_s: list[float] = field(default_factory=list)
    outcomes: list[RaceOutcome] = field(default_factory=list)


def built(
    entries: Sequence[Entry[ItemT]],
    model: StateSpaceModel,
    example: ItemT,
    absent: Callable[[str, str], object],
) -> list[Racer[ItemT]]:
    """Build contenders one after the other.

    Parameters
    ----------
    example : any item of the race
    absent : called with the name of one that cannot be built, and why
    """
    racers = []
    for entry in entries:
        start = time.perf_counter()
        try:
            contender = entry.build(model, example)
            racers.append(Racer(entry, contender, time.perf_counter() - start))
        except ContenderAbsentError as reason:
            absent(entry.label, str(reason))
    return racers


def race(racers: Sequence[Racer[ItemT]], items: Sequence[ItemT], warm_up: int) -> float:
    """Let all contenders solve all items; results go into the racers.

    Returns the part of the time in which the processor was this process's: what is missing
    to 1 went to other work, and makes times too long.

    Parameters
    ----------
    warm_up : how many of the items come first and do not count
    """
    with _garbage_kept():
        began_s, used_s = time.perf_counter(), time.process_time()
        for i, item in enumerate(items):
            first = i % max(len(racers), 1)
            for racer in [*racers[first:], *racers[:first]]:
                time_s, outcome = _turn(racer.contender, item)
                if i >= warm_up:
                    racer.times_s.append(time_s / racer.entry.samples)
                    racer.outcomes.append(outcome)
    return (time.process_time() - used_s) / (time.perf_counter() - began_s)


def _turn(contender: Contender[ItemT], item: ItemT) -> tuple[float, RaceOutcome]:
    """Return the median time (s) of one contender on one item, and what it found."""
    times: list[float] = []
    while not times or (sum(times) < TURN_S and len(times) < MOST_REPEATS):
        contender.prepare(item)
        start = time.perf_counter_ns()
        counted = contender.solve()
        wall_s = 1e-9 * (time.perf_counter_ns() - start)
        times.append(wall_s if counted is None else counted)
    return float(np.median(times)), contender.outcome()


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
