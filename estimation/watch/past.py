"""The rows that an alarm goes back over, and states to begin from."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from models.arrays import Array
from models.gaussian import GaussianState

BETWEEN_ANCHORS = 50
"""Rows from one state that is kept to the next: fewer make an alarm cheaper and keep more."""
NONE_DROPPED = frozenset[int]()
Chunk = tuple[Array, Sequence[Array] | Array]
Chained = tuple[Any, ...]


class PastRow(NamedTuple):
    """A row as it was given.

    Parameters
    ----------
    time_s : s
    y : (n_row,) with all its inputs
    dropped : sensors whose reading was an outlier
    stuck : those whose reading was one that repeats itself
    out : those that were left out
    """

    time_s: float
    y: Array
    dropped: frozenset[int]
    stuck: frozenset[int] = frozenset()
    out: frozenset[int] = frozenset()

    @property
    def unused(self) -> frozenset[int]:
        """Sensors whose reading was not used."""
        return self.dropped | self.stuck | self.out


@dataclass(frozen=True, eq=False)
class Anchor:
    """A state of the estimator.

    Parameters
    ----------
    number : of rows before it
    inner : the estimator's state
    time_s : of its newest instant; None before the first row
    gaussian : what it knows, where it was begun with that
    """

    number: int
    inner: Any
    time_s: float | None
    gaussian: GaussianState | None = None


class CleanPart(Sequence[PastRow]):
    """Rows of which nothing was dropped, made when somebody asks for them: few ever do.

    Parameters
    ----------
    count : how many they are
    given : their times (count,) and readings; or the newest of them, chained: (time, bytes of its
        readings, the rows before it), () for none
    oldest_s : time of the oldest of them
    """

    def __init__(self, count: int, given: Chunk | Chained, oldest_s: float) -> None:
        self._count, self._given, self.oldest_s = count, given, oldest_s

    @cached_property
    def _chunk(self) -> Chunk:
        return self._given if len(self._given) == 2 else _unchained(self._given)

    @cached_property
    def _rows(self) -> tuple[PastRow, ...]:
        time_s, y = self._chunk
        return tuple(map(PastRow, time_s.tolist(), y, itertools.repeat(NONE_DROPPED)))

    def __len__(self) -> int:
        return self._count

    def __getitem__(self, at: Any) -> Any:
        return self._rows[at]

    def __iter__(self) -> Iterator[PastRow]:
        return iter(self._rows)

    def since(self, time_s: float) -> int:
        """Return how many rows, the last ones, are all not older than an instant."""
        if self.oldest_s >= time_s:
            return self._count
        older = np.flatnonzero(self._chunk[0] < time_s)
        return self._count - int(older[-1]) - 1 if len(older) else self._count


@dataclass(frozen=True, eq=False)
class Past:
    """Rows since the oldest anchor, in the order in which they came.

    In parts: a row more copies the newest of them only, and the rows of a chunk are made late.
    """

    anchors: tuple[Anchor, ...]
    newer: tuple[PastRow, ...] = ()
    older: tuple[Sequence[PastRow], ...] = ()

    @cached_property
    def rows(self) -> tuple[PastRow, ...]:
        """All of them."""
        return tuple(itertools.chain(*self.older, self.newer))

    @property
    def newest(self) -> Array | None:
        """(n_row,) the last row with all its inputs; None before the first."""
        if self.newer:
            return self.newer[-1].y
        return self.older[-1][-1].y if self.older else None

    @property
    def count(self) -> int:
        """Number of all rows since the start."""
        return self.anchors[0].number + sum(map(len, self.older)) + len(self.newer)

    def after(self, rows: tuple[PastRow, ...]) -> Past:
        """Return it with more rows."""
        return Past(self.anchors, self.newer + rows, self.older)

    def after_part(self, rows: Sequence[PastRow]) -> Past:
        """Return it with a part more, of at least one row."""
        older = (*self.older, self.newer) if self.newer else self.older
        return Past(self.anchors, (), (*older, rows))

    def is_due(self) -> bool:
        """Whether there is a state to keep."""
        return self.count - self.anchors[-1].number >= BETWEEN_ANCHORS

    def anchored(self, inner: Any, time_s: float, back_s: float) -> Past:
        """Return it with a state behind its rows, without what nobody goes back to."""
        anchors = (*self.anchors, Anchor(self.count, inner, time_s))
        first = self._part_since(time_s - back_s)
        usable = [i for i, each in enumerate(anchors) if is_before(each, first)]
        oldest = usable[-1] if usable else 0
        forgotten = anchors[oldest].number - anchors[0].number
        kept = list[Sequence[PastRow]]()
        for part in (*self.older, self.newer):
            if len(part) > forgotten:
                kept.append(part[forgotten:] if forgotten else part)
            forgotten = max(forgotten - len(part), 0)
        return Past(anchors[oldest:], (), tuple(kept))

    def first_since(self, time_s: float) -> int:
        """Return the number of the first of the rows that are all not older than an instant."""
        number = self.count
        for part in reversed((*self.older, self.newer)):
            since = _since(part, time_s)
            number -= since
            if since < len(part):
                break
        return number

    def _part_since(self, time_s: float) -> int:
        """Return a number not above that of `first_since`, without a look into parts."""
        number = self.count
        for part in reversed((*self.older, self.newer)):
            number -= len(part)
            if part and _oldest_s(part) < time_s:
                return number + 1
        return number

    def since(self, number: int) -> tuple[PastRow, ...]:
        """Return the rows from a number on."""
        return self.rows[number - self.anchors[0].number :]


def _unchained(rows: Chained) -> Chunk:
    times, readings = list[float](), list[bytes]()
    while rows:
        time_s, y, rows = rows
        times.append(time_s)
        readings.append(y)
    y = np.frombuffer(bytearray().join(reversed(readings)))
    return np.array(times[::-1]), y.reshape(len(times), -1)


def _oldest_s(rows: Sequence[PastRow]) -> float:
    return rows.oldest_s if isinstance(rows, CleanPart) else min(row.time_s for row in rows)


def _since(rows: Sequence[PastRow], time_s: float) -> int:
    """Return how many rows, the last ones, are all not older than an instant."""
    if isinstance(rows, CleanPart):
        return rows.since(time_s)
    for count, row in enumerate(reversed(rows)):
        if row.time_s < time_s:
            return count
    return len(rows)


def is_before(anchor: Anchor, number: int) -> bool:
    """Whether what was known in front of a row follows from an anchor."""
    return anchor.number < number or (anchor.number == number and anchor.gaussian is not None)
