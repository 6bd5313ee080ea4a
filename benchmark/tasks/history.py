"""From an estimate's history to what a task found."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from benchmark.tasks.task import OK, Outcome, Quantity, Series
from estimation.estimate import EstimateHistory
from estimation.recording import Truth
from models.arrays import Array


def outcome(
    model: str,
    history: EstimateHistory,
    quantities: Sequence[Quantity],
    status: str = OK,
    reason: str = "",
    series: Sequence[Series] = (),
) -> Outcome:
    """Return what a run of an estimator found, its steps timed."""
    return Outcome(
        model,
        tuple(quantities),
        len(history),
        history.solved_fraction,
        float(np.median(history.step_time_s)),
        float(np.quantile(history.step_time_s, 0.99)),
        status,
        reason,
        tuple(series),
    )


def state_series(
    history: EstimateHistory,
    truth: Truth | None,
    state: str,
    quantity: str,
    unit: str,
    factor: float,
) -> Series:
    """Return one state or output over time, in a unit of its own.

    Parameters
    ----------
    state : its name in the history
    quantity, unit : name and unit to show it with
    factor : from the model's unit to that one
    """
    true: Array | None = None
    if truth is not None:
        true = factor * truth.states([state], history.time_s)[:, 0]
    return Series(
        quantity,
        unit,
        history.time_s,
        factor * history.column(state),
        factor * history.std_of(state),
        true,
    )
