"""A step of a compiled estimator and its statistics in one call of C, while nothing stands out.

What Python would have to make at each step, it makes when somebody asks: see `CleanState`.
"""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from estimation.engine import NATIVE, CompiledEngine
from estimation.estimate import Estimate
from estimation.frozen import changed
from estimation.layout import KernelAddress, Layout
from estimation.machine import Machine, address
from estimation.recording import Measurement
from estimation.status import Status
from estimation.watch.asked import Calmer
from estimation.watch.compiled import CONSTANTS, SOURCES, statistics_structure, watch_library
from estimation.watch.past import BETWEEN_ANCHORS, Chained, CleanPart
from estimation.watch.state import WatchState
from estimation.watch.statistics import Statistics
from models.arrays import Array

CALL = "one_call.c"
STEPPING: Mapping[str, float] = MappingProxyType(
    {**CONSTANTS, "STATUS_SOLVER_FAILED": Status.SOLVER_FAILED.value}
)
"""Macros of it, and of what stands in front."""
GAP_S = 0.05
"""A step that is longer may lose what was known."""


class CleanState(NamedTuple):
    """A watch after measurements in which nothing stood out: what has changed since an earlier one.

    Parameters
    ----------
    since : the state that had to be looked at last, with the past up to where a state was kept
    inner : the state of the estimator that is watched
    told : what the last step said, and what the watch keeps behind it, see `OneCall`
    inner_at, told_at : addresses of the inner state's memory, and of what was told
    rows : since then, chained as of `CleanPart`
    n_rows, first_s : how many they are, and when the first was
    time_s : of the newest instant
    """

    since: WatchState
    inner: Any
    told: Array
    inner_at: int
    told_at: int
    rows: Chained
    n_rows: int
    first_s: float
    time_s: float

    def __reduce__(self) -> Any:
        """A copy has addresses of its own."""
        return _copied, (self.since, self.inner, self.told, *self[5:])


def _copied(since: WatchState, inner: Any, told: Array, *rest: Any) -> CleanState:
    return CleanState(since, inner, told, address(inner.memory), address(told), *rest)


class OneCall:
    """Steps of an estimator of one level of motion.

    Parameters
    ----------
    estimator : with an ``engine`` that is compiled, and ``told``, which makes state and estimate of
        what that says
    limit : (n_x,) deviations up to which states are known, NaN for one that none asks of
    level : see `estimation.watch.livelier`
    replay_s : see `estimation.watch.config.WatchConfig`
    """

    def __init__(
        self,
        estimator: Any,
        statistics: Statistics,
        *,
        limit: Array,
        level: int,
        replay_s: float,
        flagged: Any,
    ) -> None:
        engine, n_x = estimator.engine, statistics.model.n_x
        self._estimator, self._replay_s, self._flagged = estimator, replay_s, flagged
        self._told, self._shape = estimator.told, (statistics.model.n_row,)
        self._layout = kept = Layout(
            "Kept",
            {
                "memory": (statistics.layout.size,),
                "std": (n_x,),
                "known": (n_x,),
                "calmer": (len(Calmer._fields),),
            },
        )
        self._memory_size, self._result_size = engine.memory.size, engine.result.size
        self._told_size = engine.result.size + kept.size
        parts = engine.result.slices
        self._machine = machine = Machine()
        own, step = engine.addresses
        stepping = machine.structure(
            "Stepping",
            {
                "statistics": statistics_structure(machine, statistics),
                "kept": kept.offsets(),
                "result_size": engine.result.size,
                "step": KernelAddress(step),
                "self": own,
                **{
                    name: parts[name].start
                    for name in ("covariance", "innovation", "innovation_covariance", "status")
                },
                "remark": Status.LIVELIER.value if level else 0,
                "n_x": n_x,
                "limit": limit,
            },
        )
        library: Any = watch_library(
            [stepping.statistics, stepping], *SOURCES, CALL, constants=STEPPING
        )
        pointer, real = ctypes.c_void_p, ctypes.c_double
        self._call = library.watch_step
        self._call.argtypes = [*[pointer] * 3, real, *[pointer] * 3]
        self._call.restype = ctypes.c_longlong
        self._self = ctypes.addressof(stepping)

    def begun(self, state: WatchState, calmer: Calmer) -> CleanState:
        """Return a state from which steps are one call."""
        assert state.time_s is not None
        told = np.empty(self._told_size)
        for block, values in (
            ("memory", state.memory),
            ("std", state.std),
            ("known", state.known),
            ("calmer", calmer),
        ):
            self._view(told, block)[:] = values
        places = address(state.inner.memory), address(told)
        return CleanState(state, state.inner, told, *places, (), 0, np.inf, state.time_s)

    def step(
        self, state: CleanState, measurement: Measurement
    ) -> tuple[CleanState, Estimate] | None:
        """Take one measurement; None where Python has to look at it."""
        time_s, y = measurement.time_s, measurement.y
        since, _, _, inner_at, told_at, rows, n_rows, first_s, newest_s = state
        if not (0 <= time_s - newest_s <= GAP_S and y.dtype is NATIVE and y.shape == self._shape):
            return None
        memory, told = np.empty(self._memory_size), np.empty(self._told_size)
        memory_at, after_at = address(memory), address(told)
        row = y.tobytes()  # small arrays that are kept would scatter the large ones in memory
        if not self._call(self._self, inner_at, memory_at, time_s, row, told_at, after_at):
            return None
        inner, estimate = self._told(memory, told)
        vars(estimate)["flagged"] = self._flagged  # nobody else has it yet
        rows, n_rows, first_s = (time_s, row, rows), n_rows + 1, first_s if n_rows else time_s
        if n_rows == BETWEEN_ANCHORS:
            past = since.past.after_part(CleanPart(n_rows, rows, first_s))
            since = changed(since, past=past.anchored(inner, time_s, self._replay_s))
            rows, n_rows = (), 0
        after = since, inner, told, memory_at, after_at, rows, n_rows, first_s, time_s
        return tuple.__new__(CleanState, after), estimate  # twice as fast as its constructor

    def whole(self, state: CleanState) -> WatchState:
        """Return the same state in full."""
        past, n_rows = state.since.past, state.n_rows
        return changed(
            state.since,
            inner=state.inner,
            memory=self._view(state.told, "memory"),
            std=self._view(state.told, "std"),
            past=past.after_part(CleanPart(n_rows, state.rows, state.first_s)) if n_rows else past,
            time_s=state.time_s,
        )

    def _view(self, told: Array, block: str) -> Array:
        return self._layout.view(told[self._result_size :], block)


def can_be_one_call(estimator: Any) -> bool:
    """Whether a step of an estimator is a call of C, of nothing but time and readings."""
    model = estimator.model
    return (
        isinstance(getattr(estimator, "engine", None), CompiledEngine)
        and not model.n_u
        and model.interval_s is None
    )
