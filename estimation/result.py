"""What a step of an estimator's loop says, as one flat array."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from estimation.covariances import Covariances
from estimation.estimate import Estimate, EstimateHistory, Window
from estimation.frozen import made
from estimation.innovations import innovation_std, row_sets, squared_innovations
from estimation.inputs import with_inputs
from estimation.lagged import LaggedEstimates, LaggedState
from estimation.layout import Layout
from estimation.outputs import derived_outputs
from estimation.status import Status
from estimation.watch.flags import not_watched
from models.arrays import Array
from models.errors import InputError
from models.frozen_mapping import FrozenMapping
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel

LAGGED = ("time", "mean", "covariance", "derived", "derived_std")
"""Blocks of what is told of earlier instants, behind ``lagged_``."""


class Engine(Protocol):
    """Steps on flat arrays; see `memory` and `result` for what is in them."""

    memory: Layout
    result: Layout

    def step(self, given: Array, time_s: float, y: Array) -> tuple[Array, Array]:
        """Return the state after a measurement and what the step says; `given` stays."""

    def batch(self, given: Array, time_s: Array, y: Array) -> tuple[Array, Array]:
        """Return the state after n measurements and what each step says, (n, result.size)."""


def checked_input(
    memory: Layout, model: StateSpaceModel, given: Array, time_s: Array, y: Array
) -> tuple[Array, Array]:
    """Return times, () or (n,), and rows, (n_row,) or (n, n_row), as C wants them.

    Raises
    ------
    InputError
        If the state `given` is another estimator's, a shape disagrees, a time is not
        finite, or an input is missing that the state does not know.
    """
    if given.shape != (memory.size,):
        raise InputError(
            f"the state has {given.size} numbers, expected {memory.size}: "
            "it is that of an estimator of another model or horizon"
        )
    check_rows(model, time_s, y)
    if model.n_u and len(rows := np.atleast_2d(y)):
        with_inputs(model, memory.view(given, "inputs"), rows[0])
    return np.require(time_s, np.float64, "C"), np.require(y, np.float64, "C")


def check_rows(model: StateSpaceModel, time_s: Array, y: Array) -> None:
    """Raise `InputError` unless times, () or (n,), are numbers and have a row (n_row,) each."""
    if time_s.ndim > 1:
        raise InputError(f"times have shape {time_s.shape}, expected (n,)")
    if y.shape != (*time_s.shape, model.n_row):
        what = "readings and inputs" if model.n_u else "readings"
        raise InputError(f"{what} have shape {y.shape}, expected {(*time_s.shape, model.n_row)}")
    wrong = ~np.isfinite(time_s)
    if wrong.any():
        raise InputError(f"the time of a measurement is {time_s[wrong][0]}, expected a number")


def result_layout(model: StateSpaceModel, lags: Sequence[int] = ()) -> Layout:
    """Return what every step says; ``cost`` and ``kkt`` are NaN where an estimator has none.

    ``derived`` are the outputs that are not states, `estimation.outputs`, with their deviations.

    ``kkt`` is how far the trajectory is from the optimality conditions, in standard
    deviations; ``reused`` counts the stages whose factors were not made again. ``lagged_…`` are
    of the instants that many samples before, NaN where there is none.
    """
    n_x, n_r, n_derived = model.n_x, model.n_r, len(derived_outputs(model).names)
    return Layout(
        "Result",
        {
            "time_s": (),
            "mean": (n_x,),
            "covariance": (n_x, n_x),
            "derived": (n_derived,),
            "derived_std": (n_derived,),
            "innovation": (n_r,),
            "innovation_covariance": (n_r, n_r),
            "status": (),
            "iterations": (),
            "cost": (),
            "kkt": (),
            "reused": (),
            "step_time_s": (),
            "lagged_time": (len(lags),),
            "lagged_mean": (len(lags), n_x),
            "lagged_covariance": (len(lags), n_x, n_x),
            "lagged_derived": (len(lags), n_derived),
            "lagged_derived_std": (len(lags), n_derived),
        },
    )


class ResultReader:
    """From a step's flat array to an `Estimate`, without copies."""

    def __init__(self, model: StateSpaceModel, lags: Sequence[int] = ()) -> None:
        self.layout, self.lags = result_layout(model, lags), tuple(lags)
        self.model, self.derived = model, derived_outputs(model)
        parts, n_x, n_r = self.layout.slices, model.n_x, model.n_r
        self._mean, self._covariance = parts["mean"], parts["covariance"]
        self._derived, self._derived_std = parts["derived"], parts["derived_std"]
        self._v, self._S = parts["innovation"], parts["innovation_covariance"]
        self._square_x, self._square_r = (n_x, n_x), (n_r, n_r)
        self._status, self._iterations = parts["status"].start, parts["iterations"].start
        self._time, self._step_time = parts["time_s"].start, parts["step_time_s"].start
        self._kkt, self._reused = parts["kkt"].start, parts["reused"].start
        self._statuses: dict[float, Status] = {}
        self._row_sets = row_sets(model)

    def estimate(self, result: Array, window: Window | None = None) -> Estimate:
        """Return one step's estimate; its arrays are views of `result`."""
        P = result[self._covariance].reshape(self._square_x)
        return made(
            Estimate,
            time_s=result.item(self._time),
            state=GaussianState(result[self._mean], P),
            status=self.status(result.item(self._status)),
            innovation=result[self._v],
            innovation_covariance=result[self._S].reshape(self._square_r),
            iterations=int(result.item(self._iterations)),
            window=window,
            call_s=result.item(self._step_time),
            kkt_residual=result.item(self._kkt),
            reused_stages=int(result.item(self._reused)),
            derived=result[self._derived],
            derived_std=result[self._derived_std],
            lagged=self._lagged(result) if self.lags else (),
            flagged=not_watched(),
        )

    def _lagged(self, result: Array) -> tuple[LaggedState, ...]:
        blocks = (self.layout.view(result, f"lagged_{name}") for name in LAGGED[:3])
        return tuple(
            LaggedState(lag, float(time_s), GaussianState(mean, P))
            for lag, time_s, mean, P in zip(self.lags, *blocks, strict=True)
            if not np.isnan(time_s)
        )

    def status_of(self, result: Array) -> Status:
        """Return the status of one step's array."""
        return self.status(result.item(self._status))

    def status(self, number: float) -> Status:
        """Return the status of its number: looked up, as building one takes long."""
        status = self._statuses.get(number)
        if status is None:
            status = self._statuses[number] = Status(int(number))
        return status

    def history(
        self, estimator: str, results: Array, *, covariances: bool = False
    ) -> EstimateHistory:
        """Return the history of n steps (n, result.size); `covariances` keeps them in full."""
        parts = {block: self.layout.view(results, block) for block in self.layout.shapes}
        P, v, S = (parts[name] for name in ("covariance", "innovation", "innovation_covariance"))
        return EstimateHistory(
            estimator=estimator,
            state_names=self.model.state_names,
            time_s=parts["time_s"],
            mean=parts["mean"],
            std=np.sqrt(np.diagonal(P, axis1=1, axis2=2)),
            innovation=v,
            innovation_std=innovation_std(v, S),
            status=tuple(self.status(number) for number in parts["status"].tolist()),
            iterations=parts["iterations"],
            step_time_s=parts["step_time_s"],
            kkt_residual=parts["kkt"],
            reused_stages=parts["reused"],
            squared_innovations=squared_innovations(v, S, self._row_sets),
            row_sets=self._row_sets,
            derived_names=self.derived.names,
            derived=parts["derived"],
            derived_std=parts["derived_std"],
            outputs=self.model.outputs,
            covariances=Covariances(P, S) if covariances else None,
            difference=self.model.difference,
            state_units=self.model.state_units,
            lagged=self._lagged_estimates(results, covariances),
        )

    def _lagged_estimates(
        self, results: Array, covariances: bool
    ) -> FrozenMapping[int, LaggedEstimates]:
        blocks = (self.layout.view(results, f"lagged_{name}") for name in LAGGED)
        time_s, mean, P, derived, derived_std = blocks
        return FrozenMapping(
            {
                lag: LaggedEstimates(
                    time_s[:, i],
                    mean[:, i],
                    np.sqrt(np.diagonal(P[:, i], axis1=1, axis2=2)),
                    derived[:, i],
                    derived_std[:, i],
                    P[:, i] if covariances else None,
                )
                for i, lag in enumerate(self.lags)
            }
        )


def stepped(
    engine: Engine, model: StateSpaceModel, given: Array, time_s: Array, y: Array
) -> tuple[Array, Array]:
    """Return the state after n steps of an interpreted engine and what each says."""
    time_s, y = checked_input(engine.memory, model, given, time_s, y)
    results, memory = np.empty((len(time_s), engine.result.size)), given.copy()
    for k, t in enumerate(time_s):
        memory, results[k] = engine.step(memory, float(t), y[k])
    return memory, results
