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


class PastRow(NamedTuple):
    """A row as it was given.

    Parameters
    ----------
    time_s : s
    y : (n_row,) with all its inputs
    dropped : sensors whose reading was stuck or an outlier
    """

    time_s: float
    y: Array
    dropped: frozenset[int]


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


class RowsOfChunk(Sequence[PastRow]):
    """Rows of which nothing was dropped, made when somebody asks for them: few ever do.

    Parameters
    ----------
    time_s : (n,)
    y : n rows, as of `PastRow`
    """

    def __init__(self, time_s: Array, y: Sequence[Array]) -> None:
        self.time_s, self._y = time_s, y

    @cached_property
    def _rows(self) -> list[PastRow]:
        dropped = itertools.repeat(NONE_DROPPED)
        return list(map(PastRow, self.time_s.tolist(), self._y, dropped))

    def __len__(self) -> int:
        return len(self.time_s)

    def __getitem__(self, at: Any) -> Any:
        if isinstance(at, slice):
            return RowsOfChunk(self.time_s[at], self._y[at])
        return PastRow(float(self.time_s[at]), self._y[at], NONE_DROPPED)

    def __iter__(self) -> Iterator[PastRow]:
        return iter(self._rows)

    def __reversed__(self) -> Iterator[PastRow]:
        return reversed(self._rows)


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

    def after_chunk(self, rows: Sequence[PastRow]) -> Past:
        """Return it with more rows that are not looked at, at least one."""
        older = (*self.older, self.newer) if self.newer else self.older
        return Past(self.anchors, (), (*older, rows))

    def is_due(self) -> bool:
        """Whether there is a state to keep."""
        return self.count - self.anchors[-1].number >= BETWEEN_ANCHORS

    def anchored(self, inner: Any, time_s: float, back_s: float) -> Past:
        """Return it with a state behind its rows, without what nobody goes back to."""
        anchors = (*self.anchors, Anchor(self.count, inner, time_s))
        first = self.first_since(time_s - back_s)
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

    def since(self, number: int) -> tuple[PastRow, ...]:
        """Return the rows from a number on."""
        return self.rows[number - self.anchors[0].number :]


def _since(rows: Sequence[PastRow], time_s: float) -> int:
    """Return how many rows, the last ones, are all not older than an instant."""
    if isinstance(rows, RowsOfChunk):
        older = np.flatnonzero(rows.time_s < time_s)
        return len(rows) - int(older[-1]) - 1 if len(older) else len(rows)
    for count, row in enumerate(reversed(rows)):
        if row.time_s < time_s:
            return count
    return len(rows)


def is_before(anchor: Anchor, number: int) -> bool:
    """Whether what was known in front of a row follows from an anchor."""
    return anchor.number < number or (anchor.number == number and anchor.gaussian is not None)
