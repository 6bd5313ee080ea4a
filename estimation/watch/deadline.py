"""An alarm that keeps to a deadline: what it has not found out by then, later steps go on with.

Whatever an alarm asks is computed by an estimator from rows that are there. `Timed` remembers how
far that has come, and ends it by `OutOfTimeError` when the time is up; asked the same again it goes
on from there. So the step in which an alarm came is made again in later ones, until it is through;
see `estimation.watch.in_time`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from estimation.estimate import EstimateHistory
from estimation.estimator import BatchEstimator
from estimation.recording import Measurement
from models.arrays import Array
from models.gaussian import GaussianState

Clock = Callable[[], float]


class OutOfTimeError(Exception):
    """The time of a step is up; nothing is lost of what it has found out."""


@dataclass(eq=False)
class Spending:
    """The time that a step may spend.

    Parameters
    ----------
    deadline_s : longest
    clock : s
    """

    deadline_s: float
    clock: Clock
    _until_s: float = np.inf
    _is_new: bool = True

    def begin(self) -> None:
        """Begin a step."""
        self._until_s, self._is_new = self.clock() + self.deadline_s, True

    def check(self) -> None:
        """Raise `OutOfTimeError` if the time is up, but for the first rows of a step."""
        if not self._is_new and self.clock() >= self._until_s:
            raise OutOfTimeError

    def rows(self, row_s: float, call_s: float = 0.0) -> int:
        """Return how many rows there is time for; one at least in a step.

        Parameters
        ----------
        row_s, call_s : what each takes, and all of them on top

        Raises
        ------
        OutOfTimeError
            If there is none.
        """
        left_s = self._until_s - self.clock() - call_s
        if left_s < row_s and not self._is_new:
            raise OutOfTimeError
        self._is_new = False
        return max(1, int(min(left_s / row_s, 1e6))) if row_s > 0 else 1


@dataclass(eq=False)
class _Run:
    """How far a batch has come: state, rows and what the estimator said of them."""

    inner: Any
    state: Any
    time_s: Array
    y: Array
    parts: list[EstimateHistory] = field(default_factory=list)

    def begins(self, inner: Any, time_s: Array, y: Array) -> bool:
        """Whether a batch begins with its rows."""
        n = len(self.time_s)
        return (
            self.inner is inner
            and n <= len(time_s)
            and np.array_equal(self.time_s, time_s[:n])
            and np.array_equal(self.y, y[:n], equal_nan=True)
        )


class Timed:
    """Steps of an estimator, remembered; it stops when the time is up."""

    def __init__(self, estimator: Any, spending: Spending) -> None:
        self.estimator, self.model, self._spending = estimator, estimator.model, spending
        self.row_s = 0.0
        self._known: dict[Any, Any] = {}
        self._steps: dict[Any, Any] = {}

    def forget(self) -> None:
        """Forget all that is remembered, for another alarm."""
        self._known.clear()
        self._steps.clear()

    def init(self, prior: GaussianState) -> Any:
        """Return the state before the first measurement, the same for the same prior."""
        key = prior.mean.tobytes(), prior.covariance.tobytes()
        if key not in self._known:
            self._known[key] = self.estimator.init(prior)
        return self._known[key]

    def step(self, state: Any, measurement: Measurement) -> Any:
        """Take one measurement."""
        key = id(state), measurement.time_s, measurement.y.tobytes()
        if key not in self._steps:
            self._spending.rows(self.row_s)
            began = self._spending.clock()
            taken = self.estimator.step(state, measurement)
            self.row_s = max(self.row_s, self._spending.clock() - began)
            self._steps[key] = state, taken  # the state is kept: another may get its address
        return self._steps[key][1]


class TimedBatches(Timed):
    """Batches too."""

    def __init__(self, estimator: Any, spending: Spending) -> None:
        super().__init__(estimator, spending)
        self._runs = list[_Run]()
        self._call_s = self._part_row_s = 0.0

    def forget(self) -> None:
        """Forget all that is remembered, for another alarm."""
        super().forget()
        self._runs.clear()

    def batch(
        self, state: Any, time_s: Array, y: Array, *, covariances: bool = False
    ) -> tuple[Any, EstimateHistory]:
        """Take measurements, as many in a call as there is time for; covariances are kept."""
        begun = [run for run in self._runs if run.begins(state, time_s, y)]
        run = max(begun, key=lambda each: len(each.time_s), default=None)
        if run is None:
            run = _Run(state, state, time_s[:0], y[:0])
            self._runs.append(run)
        while (done := len(run.time_s)) < len(time_s):
            count = self._spending.rows(self._part_row_s, self._call_s)
            rows, began = slice(done, done + count), self._spending.clock()
            run.state, part = self.estimator.batch(
                run.state, time_s[rows], y[rows], covariances=True
            )
            spent_s = self._spending.clock() - began
            self._part_row_s = max(self._part_row_s / 2, spent_s / len(time_s[rows]))
            self._call_s = self._call_s or spent_s  # of a single row, the first time
            run.time_s, run.y = time_s[: rows.stop], y[: rows.stop]
            run.parts.append(part)
        if len(run.parts) > 1:
            run.parts[:] = [EstimateHistory.joined(run.parts)]
        return run.state, run.parts[0]


class TimedLevels:
    """`MotionLevels` whose estimators are `Timed`."""

    def __init__(self, levels: Any, spending: Spending) -> None:
        made = (levels[level] for level in range(levels.count))  # none is made in a step
        self._timed: list[Timed] = [
            (TimedBatches if isinstance(each, BatchEstimator) else Timed)(each, spending)
            for each in made
        ]

    def __getitem__(self, level: int) -> Timed:
        return self._timed[level]

    def forget(self) -> None:
        """Forget what any of them remembers."""
        for each in self._timed:
            each.forget()
