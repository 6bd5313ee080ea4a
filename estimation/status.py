"""What can become of a step: one enumeration, each member with a sentence."""

from __future__ import annotations

import enum
from collections import Counter
from collections.abc import Sequence

REGULARITY_LIMIT = 0.035
"""|cos θ| of a pen two degrees from upright."""


class Status(enum.Flag):
    """Outcome of one step; several can hold at once, none means solved."""

    SOLVED = 0
    NO_READING = enum.auto()
    LATE = enum.auto()
    INFINITE_READING = enum.auto()
    SATURATED = enum.auto()
    GATED = enum.auto()
    NEAR_SINGULAR = enum.auto()
    OUT_OF_REACH = enum.auto()
    ITERATION_LIMIT = enum.auto()
    TIME_LIMIT = enum.auto()
    INFEASIBLE = enum.auto()
    SOLVER_FAILED = enum.auto()
    NOT_FINITE = enum.auto()
    PREDICTED = enum.auto()
    FELL_BACK = enum.auto()
    DIGITS_LOST = enum.auto()
    IMPROBABLE = enum.auto()
    LOST = enum.auto()
    INCONSISTENT = enum.auto()
    STUCK = enum.auto()
    OUTLIER = enum.auto()
    LIVELIER = enum.auto()

    @property
    def is_solved(self) -> bool:
        """Whether the estimate is what the estimator promises, with or without remarks."""
        return not self & UNSOLVED

    @property
    def label(self) -> str:
        """Return e.g. ``solved`` or ``near_singular+time_limit``, as written to files."""
        return "+".join((member.name or "").lower() for member in self) or "solved"

    @property
    def sentence(self) -> str:
        """Say it to a person."""
        return " ".join(SENTENCES[member] for member in self) or SENTENCES[Status.SOLVED]


def solved_fraction(statuses: Sequence[Status]) -> float:
    """Return the fraction that is solved, with or without remarks; NaN of none."""
    counts = Counter(statuses)  # a question to each of a million flags would take seconds
    solved = sum(count for status, count in counts.items() if status.is_solved)
    return solved / len(statuses) if statuses else float("nan")


UNSOLVED = (
    Status.ITERATION_LIMIT
    | Status.TIME_LIMIT
    | Status.INFEASIBLE
    | Status.SOLVER_FAILED
    | Status.NOT_FINITE
    | Status.PREDICTED
    | Status.LOST
    | Status.INCONSISTENT
)
"""The members that mean: the estimate is only the best that was found.

What a watch says (`estimation.watch`) is among them where the state is not known or the cause was
not found; not where a sensor that lies is left out, for without it the estimate holds.
"""

SENTENCES = {
    Status.SOLVED: "The step was solved.",
    Status.NO_READING: "No sensor had a reading; the estimate is a prediction.",
    Status.LATE: "A reading was older than the estimator can reach and was not used.",
    Status.INFINITE_READING: "A reading was infinite and was not used.",
    Status.SATURATED: "A reading was at its sensor's range limit and was not used.",
    Status.GATED: "A reading was too far from its prediction and was not used.",
    Status.NEAR_SINGULAR: "An angle can hardly be seen in this attitude: a pen is almost upright "
    "(azimuth and spin are one), or a turntable's cos phi is almost zero (gravity hides theta).",
    Status.OUT_OF_REACH: "A state is so uncertain that it says nothing: no sensor holds it (for a "
    "pen's position: a camera or its writing area).",
    Status.ITERATION_LIMIT: "The solver stopped at its iteration limit; best point returned.",
    Status.TIME_LIMIT: "The solver stopped for its deadline; best point returned.",
    Status.INFEASIBLE: "No state meets all bounds and inequalities; best point returned.",
    Status.SOLVER_FAILED: "The solver failed; best point returned.",
    Status.NOT_FINITE: "The step gave a number that is not finite; the prediction is returned.",
    Status.FELL_BACK: "Passes did not settle on the active bounds; OSQP solved the step, slower.",
    Status.DIGITS_LOST: "A reading is so much better than what was known that fewer than two digits"
    " of the standard deviations are left.",
    Status.IMPROBABLE: "The optimum of a window is further from its readings than chance explains "
    "once in a million: it is another minimum, or the readings are not what the model expects.",
    Status.PREDICTED: "The deadline left no time for a pass; the prediction is returned.",
    Status.LOST: "An attitude, or another state that wraps or has a reach, is not known any more; "
    "do not use it until this word is gone.",
    Status.INCONSISTENT: "Readings contradict the model, and leaving out no sensor explains it.",
    Status.STUCK: "A sensor repeats its reading and is left out; the estimate holds without it.",
    Status.OUTLIER: "A sensor's reading is not to be believed and is left out; the estimate holds "
    "without it.",
    Status.LIVELIER: "The motion is livelier than the model says: process noise has grown, and no "
    "sensor is blamed.",
}
