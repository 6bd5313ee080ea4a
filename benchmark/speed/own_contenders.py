"""The project's own estimators as contenders, by their names in the registry.

A name that the registry does not have is left out like a peer that is not installed.
"""

from __future__ import annotations

import time
from importlib.metadata import version
from typing import Any

import numpy as np

from benchmark.registry import ESTIMATORS, EstimatorSettings, create_estimator
from benchmark.speed.contender import ContenderAbsentError, Outcome
from benchmark.speed.samples import Sample, Stream
from benchmark.speed.windows import SpeedWindow
from estimation import native
from estimation.kalman_stage import rows_present, without_gaps
from mhe.config import MheConfig
from mhe.realtime import WindowState, window_memory
from mhe.trajectory import Trajectory
from models.state_space import StateSpaceModel

VERSION = f"pen-mhe {version('pen-mhe')}"
LIVE_HORIZON = 20
"""N of a moving-horizon estimator on a stream."""


def estimator(name: str, model: StateSpaceModel, horizon: int) -> Any:
    """Return an estimator of the registry; raises `ContenderAbsentError` where there is none."""
    if name not in ESTIMATORS:
        raise ContenderAbsentError("not among the estimators")
    return create_estimator(name, model, EstimatorSettings(mhe=MheConfig(horizon=horizon)))


def _check_call_time() -> None:
    if native.compiler() is None:
        raise ContenderAbsentError("there is no compiled call without a compiler")


class WindowStep:
    """An estimator's ``step`` onto a window, from the one before, as it happens live.

    It carries the prior, shifts the solution, predicts the newest stage and solves: more
    than the others do within the clock. All that Python adds is in it too, unless only
    the compiled call counts.
    """

    version = VERSION

    def __init__(
        self, model: StateSpaceModel, example: SpeedWindow, name: str, call_only: bool = False
    ) -> None:
        self._estimator, self._call_only = estimator(name, model, len(example.dt)), call_only
        if call_only:
            _check_call_time()
        self._layout = window_memory(model, len(example.measurements))

    def prepare(self, item: SpeedWindow) -> None:
        """Write down the state after the window before."""
        self._window, before, layout = item, item.previous, self._layout
        memory = np.zeros(layout.size)
        states, noises = before.trajectory.states, before.trajectory.noises
        written: dict[str, Any] = {
            "count": len(before.measurements),
            "times": [m.time_s for m in before.measurements],
            "y": [without_gaps(m.y) for m in before.measurements],
            "present": [rows_present(item.model, m.y) for m in before.measurements],
            "x": states,
            "w": noises,
            "predicted": states,  # only read for another arrival cost
            "prior_mean": before.prior.mean,
            "prior_covariance": before.prior.covariance,
        }
        for block, value in written.items():
            layout.view(memory, block)[...] = value
        self._state, self._newest = WindowState(memory), item.measurements[-1]

    def solve(self) -> float | None:
        """Take the step."""
        self._next, self._estimate = self._estimator.step(self._state, self._newest)
        return self._estimate.call_s if self._call_only else None

    def outcome(self) -> Outcome:
        """Read the window out of the state."""
        memory = self._next.memory
        trajectory = Trajectory(*(self._layout.view(memory, block).copy() for block in "xw"))
        return Outcome(self._estimate.status.is_solved, self._estimate.state.mean, trajectory)


class LiveStep:
    """An estimator's ``step``, one sample at a time; all of it, or what Python adds."""

    version = VERSION

    def __init__(
        self, model: StateSpaceModel, example: Sample, name: str, overhead: bool = False
    ) -> None:
        self._estimator, self._overhead = estimator(name, model, LIVE_HORIZON), overhead
        if overhead:
            _check_call_time()
        self._state = self._estimator.init()

    def prepare(self, item: Sample) -> None:
        """Keep the sample."""
        self._measurement = item.measurement

    def solve(self) -> float | None:
        """Take the step from the state before this sample."""
        start = time.perf_counter()
        self._next, self._estimate = self._estimator.step(self._state, self._measurement)
        if not self._overhead:
            return None
        return time.perf_counter() - start - self._estimate.call_s

    def outcome(self) -> Outcome:
        """Go on to the next sample."""
        self._state = self._next
        return Outcome(self._estimate.status.is_solved, self._estimate.state.mean)


class Batch:
    """An estimator's ``batch`` over a whole stream."""

    version = VERSION

    def __init__(self, model: StateSpaceModel, example: Stream, name: str) -> None:
        self._estimator = estimator(name, model, LIVE_HORIZON)
        if not hasattr(self._estimator, "batch"):
            raise ContenderAbsentError("the estimator has no batch call")
        self._start = self._estimator.init()

    def prepare(self, item: Stream) -> None:
        """Keep the stream."""
        self._stream = item

    def solve(self) -> None:
        """Run over the stream."""
        _, self._history = self._estimator.batch(self._start, self._stream.time_s, self._stream.y)

    def outcome(self) -> Outcome:
        """Return the last estimate."""
        return Outcome(self._history.solved_fraction, self._history.mean[-1])
