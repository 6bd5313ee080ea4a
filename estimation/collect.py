"""From what steps say to the history of a run, a part at a time.

Each part is reduced at once to what a history keeps: a step's covariances of 24 states and 12
rows take 6 kB, their standard deviations and squared innovations 0.3 kB.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from estimation.estimate import Estimate, EstimateHistory
from estimation.layout import Layout
from estimation.report import tell_lagged
from estimation.result import ResultReader, checked_input
from models.arrays import Array
from models.state_space import StateSpaceModel

BATCH_STEPS = 500
"""Steps per compiled call: long enough to cost nothing, short enough to show progress, and for
what they say to stay in the processor's cache until it is reduced."""


def collected(
    estimator: str,
    model: StateSpaceModel,
    estimates: Sequence[Estimate],
    step_time_s: Sequence[float],
    *,
    covariances: bool = False,
    lags: Sequence[int] = (),
) -> EstimateHistory:
    """Return the history of estimates that were made one by one, and of how long each took.

    Parameters
    ----------
    lags : at which the estimator tells of earlier instants
    """
    reader, n = ResultReader(model, lags), len(estimates)
    results = np.full((n, reader.layout.size), np.nan)
    blocks = {
        "time_s": [e.time_s for e in estimates],
        "mean": [e.state.mean for e in estimates],
        "covariance": [e.state.covariance for e in estimates],
        "innovation": [e.innovation for e in estimates],
        "innovation_covariance": [e.innovation_covariance for e in estimates],
        "status": [e.status.value for e in estimates],
        "iterations": [e.iterations for e in estimates],
        "kkt": [e.kkt_residual for e in estimates],
        "reused": [e.reused_stages for e in estimates],
        "step_time_s": step_time_s,
    }
    for block, values in blocks.items():
        rows = np.asarray(values, dtype=float)
        results[:, reader.layout.slices[block]] = rows.reshape(n, -1) if n else 0.0
    for estimate, result in zip(estimates, results, strict=True):
        tell_lagged(reader.layout, reader.derived, result, lags, estimate.lagged)
    mean, P = (reader.layout.view(results, block) for block in ("mean", "covariance"))
    for block, rows in zip(("derived", "derived_std"), reader.derived.values(mean, P), strict=True):
        reader.layout.view(results, block)[:] = rows
    history = reader.history(estimator, results, covariances=covariances)
    if not any(len(e.flagged) for e in estimates):
        return history
    sensor_names = tuple(sensor.name for sensor in model.sensors)
    flagged = np.array([e.flagged for e in estimates])
    return dataclasses.replace(history, sensor_names=sensor_names, flagged=flagged)


@dataclass(frozen=True, eq=False)
class Batches:
    """Many measurements of one estimator, in parts of `BATCH_STEPS`.

    Parameters
    ----------
    estimator : its name
    reader : of what its steps say
    memory : layout of its state
    part : (state, times, readings) → the state behind them, and what each step says
    """

    estimator: str
    reader: ResultReader
    memory: Layout
    part: Callable[[Array, Array, Array], tuple[Array, Array]]

    def take(
        self,
        given: Array,
        time_s: Array,
        y: Array,
        covariances: bool,
        on_progress: Callable[[int], None] | None,
    ) -> tuple[Array, EstimateHistory]:
        """Return the state behind n measurements, and the history.

        Parameters
        ----------
        given : the state before
        time_s, y : (n,), (n, n_row)
        covariances, on_progress : see `estimation.estimator.run`
        """
        time_s, y = checked_input(self.memory, self.reader.model, given, time_s, y)
        after = given

        def parts() -> Iterator[EstimateHistory]:
            nonlocal after
            for start in range(0, max(len(time_s), 1), BATCH_STEPS):
                rows = slice(start, start + BATCH_STEPS)
                after, results = self.part(after, time_s[rows], y[rows])
                yield self.reader.history(self.estimator, results, covariances=covariances)
                if on_progress:
                    on_progress(len(results))

        if covariances and len(time_s) <= BATCH_STEPS:  # whole as it is, and nearly all is kept
            [history] = parts()
            return after, history
        history = EstimateHistory.joined(parts(), len(time_s))
        return after, history
