"""What text and drawings of a history read of it."""

from __future__ import annotations

from typing import Protocol

import casadi as ca

from estimation.status import Status
from models.arrays import Array


class HistoryView(Protocol):
    """A history, as `estimation.history.EstimateHistory` describes it."""

    @property
    def estimator(self) -> str:
        """Name."""

    @property
    def state_names(self) -> tuple[str, ...]:
        """(n_x,)"""

    @property
    def time_s(self) -> Array:
        """(n,)"""

    @property
    def mean(self) -> Array:
        """(n, n_x)"""

    @property
    def std(self) -> Array:
        """(n, n_x)"""

    @property
    def status(self) -> tuple[Status, ...]:
        """Of n steps."""

    @property
    def step_time_s(self) -> Array:
        """(n,)"""

    @property
    def difference(self) -> ca.Function | None:
        """The model's."""
