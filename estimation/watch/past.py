"""The rows that an alarm goes back over, and states to begin from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

from models.arrays import Array
from models.gaussian import GaussianState

BETWEEN_ANCHORS = 50
"""Rows from one state that is kept to the next: fewer make an alarm cheaper and keep more."""


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


@dataclass(frozen=True, eq=False)
class Past:
    """Rows since the oldest anchor, in the order in which they came.

    In two parts: a row more copies the newer of them only.
    """

    anchors: tuple[Anchor, ...]
    older: tuple[PastRow, ...] = ()
    newer: tuple[PastRow, ...] = ()

    @property
    def rows(self) -> tuple[PastRow, ...]:
        """All of them."""
        return self.older + self.newer

    @property
    def newest(self) -> Array | None:
        """(n_row,) the last row with all its inputs; None before the first."""
        rows = self.newer or self.older
        return rows[-1].y if rows else None

    @property
    def count(self) -> int:
        """Number of all rows since the start."""
        return self.anchors[0].number + len(self.older) + len(self.newer)

    def after(self, rows: tuple[PastRow, ...]) -> Past:
        """Return it with more rows."""
        return Past(self.anchors, self.older, self.newer + rows)

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
        return Past(anchors[oldest:], self.rows[forgotten:])

    def first_since(self, time_s: float) -> int:
        """Return the number of the first of the rows that are all not older than an instant."""
        number = self.count
        for row in reversed(self.rows):
            if row.time_s < time_s:
                break
            number -= 1
        return number

    def since(self, number: int) -> tuple[PastRow, ...]:
        """Return the rows from a number on."""
        return self.rows[number - self.anchors[0].number :]


def is_before(anchor: Anchor, number: int) -> bool:
    """Whether what was known in front of a row follows from an anchor."""
    return anchor.number < number or (anchor.number == number and anchor.gaussian is not None)
