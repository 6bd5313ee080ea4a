"""A step that must be answered in time: an anytime ladder.

The rungs of a step, each an answer:

1. the prediction (`Status.PREDICTED`), where not even one pass would end in time;
2. one pass (`Status.TIME_LIMIT` for ``mhe``, solved for ``mhe-rti``, which makes no more);
3. more passes, until converged (solved) or until another would be late (`Status.TIME_LIMIT`);
   ``iterations`` counts them.

Before every pass the clock is asked whether one more would end in time, going by how long passes
took of late: their running mean per stage, and half as much again for safety. A single longer one
(the processor was elsewhere) counts as twice the mean, the next in a row as four times, and so
on. mhe/deadline.c is the same in C.
"""

from __future__ import annotations

from collections.abc import Callable

Clock = Callable[[], float]
"""Seconds that only grow; any origin."""

NEWEST_SHARE = 0.1
LARGEST = 2.0
SAFETY = 1.5
HOPE = 0.95


class Deadline:
    """The time that a step has, and what passes take.

    Parameters
    ----------
    limit_s : per step; None has no limit
    now : the clock
    """

    def __init__(self, limit_s: float | None, now: Clock) -> None:
        self.now = now
        self._limit_s = limit_s
        self._start, self._mean, self._allowed = 0.0, 0.0, 1.0

    def begin(self) -> None:
        """Begin a step."""
        self._start = self.now()

    @property
    def passed_s(self) -> float:
        """Seconds since the step began."""
        return self.now() - self._start

    def is_late(self, n_stages: int) -> bool:
        """Return whether a pass over so many stages would end behind the deadline."""
        if self._limit_s is None:
            return False
        return self.passed_s + SAFETY * self._mean * n_stages > self._limit_s

    def note_pass(self, n_stages: int, began: float) -> None:
        """Remember how long a pass took."""
        if self._limit_s is None:
            return
        took = (self.now() - began) / n_stages
        allowed = LARGEST * self._allowed
        counted = min(took, allowed * self._mean)
        self._allowed = allowed if took > allowed * self._mean else 1.0
        self._mean = self._mean + NEWEST_SHARE * (counted - self._mean) if self._mean > 0 else took

    def note_none(self) -> None:
        """Remember a step without a pass: the next may find the processor faster."""
        self._mean *= HOPE
