"""An estimator that is driven over rows that come in parts: its state goes on."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from typing import Any

from estimation.estimate import Estimate, EstimateHistory
from estimation.estimator import BatchEstimator, Estimator, stepped_through
from estimation.orders import Stacked
from estimation.recording import Measurement


class Driven:
    """A run of an estimator over rows that come in parts; see `estimation.estimator.run`.

    Parameters
    ----------
    on_progress, covariances : as of `estimation.estimator.run`
    """

    def __init__(
        self,
        estimator: Estimator[Any],
        *,
        on_progress: Callable[[int], None] | None = None,
        covariances: bool = False,
    ) -> None:
        self._estimator, self._on_progress = estimator, on_progress
        self._covariances, self._state = covariances, estimator.init()

    def take(self, rows: Stacked) -> EstimateHistory:
        """Return what the estimator says of the next rows, at least one."""
        if isinstance(self._estimator, BatchEstimator):
            self._state, history = self._estimator.batch(
                self._state,
                rows.time_s,
                rows.y,
                covariances=self._covariances,
                on_progress=self._on_progress,
            )
        else:
            self._state, history = stepped_through(
                self._estimator,
                self._state,
                self._measurements(rows),
                on_step=self._on_step,
                covariances=self._covariances,
            )
        return dataclasses.replace(history, arrival_s=rows.arrival_s)

    def _measurements(self, rows: Stacked) -> Iterator[Measurement]:
        for time_s, y, arrival_s in zip(rows.time_s, rows.y, rows.arrival_s, strict=True):
            yield Measurement(float(time_s), y, float(arrival_s))

    def _on_step(self, _: Estimate) -> None:
        if self._on_progress:
            self._on_progress(1)
