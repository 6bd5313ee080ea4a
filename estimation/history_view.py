"""What text and drawings of a history read of it."""

from __future__ import annotations

from typing import Protocol

from estimation.status import Status
from estimation.watch.flags import Flags
from models.arrays import Array


class HistoryView(Protocol):
    """A history, as `estimation.history.EstimateHistory` describes it."""

    @property
    def estimator(self) -> str:
        """Name."""

    @property
    def time_s(self) -> Array:
        """(n,)"""

    @property
    def mean(self) -> Array:
        """(n, n_x)"""

    @property
    def names(self) -> tuple[str, ...]:
        """(n_o,)"""

    def column(self, name: str) -> Array:
        """(n,) estimates of one of `names`."""

    def std_of(self, name: str) -> Array:
        """(n,) their standard deviations."""

    def unit_of(self, name: str) -> str:
        """Unit of one of `names`, as people write it."""

    def is_circular(self, name: str) -> bool:
        """Whether it is an angle on the circle."""

    @property
    def status(self) -> tuple[Status, ...]:
        """Of n steps."""

    @property
    def step_time_s(self) -> Array:
        """(n,)"""

    @property
    def sensor_names(self) -> tuple[str, ...]:
        """(n_sensors,), none where nobody watched."""

    @property
    def flagged(self) -> Flags:
        """(n, n_sensors)"""
