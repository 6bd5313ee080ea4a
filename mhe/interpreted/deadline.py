"""A step that must be answered in time: an anytime ladder.

The rungs of a step, each an answer:

1. the prediction (`Status.PREDICTED`), where no pass would end in time;
2. for ``mhe-rti`` with kept factors, a pass that makes those of the newest stages only, as many
   as there is time for: older ones keep theirs, moved or not (`Status.TIME_LIMIT`);
3. one pass (`Status.TIME_LIMIT` for ``mhe``, solved for ``mhe-rti``, which makes no more);
4. more passes, until converged (solved) or until another would be late (`Status.TIME_LIMIT`);
   ``iterations`` counts them.

Before every pass the clock is asked whether one more would end in time, going by how long passes
took of late: their running mean per stage whose factors are made, and for safety half as much
again or four times their mean deviation, whichever is more. A single longer one (the processor was
elsewhere) counts as twice the mean, the next in a row as four times, and so on.
mhe/compiled/deadline.c is the same in C.

References
----------
Jacobson (1988), Congestion avoidance and control, SIGCOMM: mean and mean deviation of times.
"""

from __future__ import annotations

from mhe.config import Clock

NEWEST_SHARE = 0.1
LARGEST = 2.0
SAFETY = 1.5
DEVIATIONS = 4.0
HOPE = 0.95
BESIDE = 2
"""Stages: what a pass takes beside its factors."""


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
        self._start, self._mean, self._deviation, self._allowed = 0.0, 0.0, 0.0, 1.0

    def begin(self) -> None:
        """Begin a step."""
        self._start = self.now()

    @property
    def passed_s(self) -> float:
        """Seconds since the step began."""
        return self.now() - self._start

    def affordable(self, n_stages: int) -> int:
        """Return of how many of the stages a pass can make the factors in time.

        Below 1 it is none of them.
        """
        if self._limit_s is None:
            return n_stages
        left = self._limit_s - self.passed_s
        each = max(SAFETY * self._mean, self._mean + DEVIATIONS * self._deviation)
        if left < 0:
            return 0
        return n_stages if left >= each * (n_stages + BESIDE) else int(left / each) - BESIDE

    def note_pass(self, n_made: int, began: float) -> None:
        """Remember how long a pass took."""
        if self._limit_s is None:
            return
        took = (self.now() - began) / (n_made + BESIDE)
        if not self._mean > 0:
            self._mean = took
            return
        allowed = LARGEST * self._allowed
        away = min(took, allowed * self._mean) - self._mean
        self._allowed = allowed if took > allowed * self._mean else 1.0
        self._deviation += NEWEST_SHARE * (abs(away) - self._deviation)
        self._mean += NEWEST_SHARE * away

    def note_none(self) -> None:
        """Remember a step without a pass: the next may find the processor faster."""
        self._mean *= HOPE
        self._deviation *= HOPE
