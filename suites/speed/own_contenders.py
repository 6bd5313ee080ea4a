"""The project's own estimators as contenders, by their names in the registry.

A name that the registry does not have, or an estimator that refuses a model, is left out like a
peer that is not installed.

An estimator keeps the factors of its last pass in its workspace and takes those that the next
pass would make again, bit for bit. The runner repeats a step, and a step that was just taken
would find all of its own: so `prepare` leaves the workspace as it is when a step comes live.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from importlib.metadata import version
from types import MappingProxyType
from typing import Any

from estimation import native
from estimation.recording import Measurement
from mhe.trajectory import Trajectory
from mhe.window_memory import WindowState, packed_window, window_memory
from models.errors import InputError
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel
from pen_mhe.estimators import ESTIMATORS, create_estimator, settings_read
from suites.speed.clock import Counted
from suites.speed.contender import OVERHEAD, STEP, ContenderAbsentError, RaceOutcome
from suites.speed.held_rows import HeldRows
from suites.speed.samples import Sample, SampleStream
from suites.speed.windows import SpeedWindow

VERSION = f"pen-mhe {version('pen-mhe')}"
LIVE_HORIZON = 20
"""N of a moving-horizon estimator on a stream."""
LIVE: Mapping[str, Any] = MappingProxyType({"horizon": LIVE_HORIZON})
OTHER_PRIOR = 1.01
"""Factor on a prior's covariance that makes another window of a window, all of its factors new."""


def estimator(name: str, model: StateSpaceModel, settings: Mapping[str, Any]) -> Any:
    """Return an estimator of the registry with what it reads of the settings.

    Least squares, whatever the sensors say of their outliers: as all other solvers have it.

    Raises `ContenderAbsentError` where there is none.
    """
    if name not in ESTIMATORS:
        raise ContenderAbsentError("not among the estimators")
    try:
        return create_estimator(name, model, **settings_read(name, {"huber": {}, **settings}))
    except InputError as refusal:
        raise ContenderAbsentError(str(refusal)) from None


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
        self._estimator = estimator(name, model, {"horizon": len(example.dt)})
        self._call_only = call_only
        if call_only:
            _check_call_time()
        self.layout = window_memory(model, len(example.measurements))
        self._held = HeldRows(model)

    def prepare(self, item: SpeedWindow) -> None:
        """Write down the state after the window before; leave another window's factors behind."""
        prior = item.previous.prior
        other = GaussianState(prior.mean, OTHER_PRIOR * prior.covariance)
        self._newest = item.measurements[-1]
        self._estimator.step(self._after(item, other), self._newest)
        self.state = self._after(item, prior)

    def solve(self) -> Counted | None:
        """Take the step."""
        self._next, self.estimate = self._estimator.step(self.state, self._newest)
        return Counted(self.estimate.call_s) if self._call_only else None

    def outcome(self) -> RaceOutcome:
        """Read the window out of the state."""
        memory = self._next.memory
        trajectory = Trajectory(*(self.layout.view(memory, block).copy() for block in "xw"))
        return RaceOutcome(self.estimate.status.is_solved, self.estimate.state.mean, trajectory)

    def _after(self, item: SpeedWindow, prior: GaussianState) -> WindowState:
        """Return the state after the window before, its active rows marked."""
        before, n_stages = item.previous, len(item.measurements)
        trajectory, measurements = before.trajectory, before.measurements
        state = packed_window(item.model, n_stages, prior, measurements, trajectory)
        if self._held.n_c:
            active = self._held.active(measurements, trajectory.states, item.scale)
            self.layout.view(state.memory, "active")[...] = active
        return state


class LiveStep:
    """An estimator's ``step``, one sample at a time: all of it, or a part.

    Parameters
    ----------
    counted : `suites.speed.contender.STEP` for all of it, `OVERHEAD` for what Python adds,
        any other mode for the compiled call
    settings : of a moving-horizon estimator
    """

    version = VERSION

    def __init__(
        self,
        model: StateSpaceModel,
        example: Sample,
        name: str,
        counted: str = STEP,
        settings: Mapping[str, Any] = LIVE,
    ) -> None:
        self._estimator, self._counted = estimator(name, model, settings), counted
        if counted != STEP:
            _check_call_time()
        self._state = self._estimator.init()
        self._before: tuple[Any, Measurement] | None = None

    def prepare(self, item: Sample) -> None:
        """Take the step before once more, so that the workspace is as that leaves it."""
        self._measurement = item.measurement
        if self._before is not None:
            self._estimator.step(*self._before)

    def solve(self) -> Counted | None:
        """Take the step from the state before this sample."""
        start = time.perf_counter()
        self._next, self.estimate = self._estimator.step(self._state, self._measurement)
        if self._counted == STEP:
            return None
        call_s: float = self.estimate.call_s
        step_s = time.perf_counter() - start
        return Counted(step_s - call_s if self._counted == OVERHEAD else call_s)

    def outcome(self) -> RaceOutcome:
        """Go on to the next sample."""
        self._before = self._state, self._measurement
        self._state = self._next
        return RaceOutcome(self.estimate.status.is_solved, self.estimate.state.mean)


class Batch:
    """An estimator's ``batch`` over a whole stream."""

    version = VERSION

    def __init__(self, model: StateSpaceModel, example: SampleStream, name: str) -> None:
        self._estimator = estimator(name, model, LIVE)
        if not hasattr(self._estimator, "batch"):
            raise ContenderAbsentError("the estimator has no batch call")
        self._start = self._estimator.init()

    def prepare(self, item: SampleStream) -> None:
        """Keep the stream."""
        self._stream = item

    def solve(self) -> None:
        """Run over the stream."""
        _, self._history = self._estimator.batch(self._start, self._stream.time_s, self._stream.y)

    def outcome(self) -> RaceOutcome:
        """Return the last estimate."""
        return RaceOutcome(self._history.solved_fraction, self._history.mean[-1])
