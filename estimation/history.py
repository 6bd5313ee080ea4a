"""The history of a run: every estimate as plain arrays, to slice, to tabulate and to draw."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from estimation.covariances import Covariances
from estimation.history_instants import AtInstants
from estimation.history_lag import AtLag
from estimation.history_rows import check_rows
from estimation.lagged import LaggedEstimates
from estimation.named_columns import NamedColumns
from estimation.output_file import whole_file
from estimation.recording import Truth
from estimation.status import Status, solved_fraction
from estimation.watch.flags import Flags, labels, not_watched
from models.arrays import Array
from models.errors import InputError
from models.frozen_mapping import FrozenMapping
from models.outputs import Outputs

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

PER_STEP = (
    "time_s",
    "mean",
    "std",
    "derived",
    "derived_std",
    "innovation",
    "innovation_std",
    "squared_innovations",
    "iterations",
    "step_time_s",
    "kkt_residual",
    "reused_stages",
    "arrival_s",
    "flagged",
)
"""Arrays of a history with one entry per step."""


@dataclass(frozen=True, eq=False, repr=False)
class EstimateHistory(NamedColumns, AtInstants, AtLag):
    """All estimates of a run as plain arrays.

    Parameters
    ----------
    estimator : its name
    state_names : (n_x,)
    time_s : (n,) of which each row speaks: in order of capture all different, else a late
        reading's row bears the newest instant again
    mean, std : (n, n_x) states, in their units, and the deviations of the tangent vector's
        components
    innovation, innovation_std : (n, n_r) and their standard deviations, NaN without a reading
    status : n statuses
    iterations : (n,)
    step_time_s : (n,) wall time of each step; of the compiled call where there is one
    kkt_residual, reused_stages : (n,), see `estimation.estimate.Estimate`
    squared_innovations : (n, k) normalised innovations squared of the sets in `row_sets`
    row_sets : name → (n_r,) rows of the innovation; see `estimation.innovations.row_sets`
    covariances : in full, where the run was asked to keep them
    difference : the model's, for errors of wrapped angles; None subtracts
    derived_names, derived, derived_std : (k,), (n, k) outputs that are not states
    outputs : the model's; None where people read its states, see `names` and `values`
    state_units : (n_x,) as people write them; without any, SI units that end the names
    lagged : lag in samples → what the steps said of the instant so long before, see `at_lag`
    arrival_s : (n,) when each row was told: nothing that it knows arrived later; `time_s` of the
        newest instant where readings are taken at their capture
    sensor_names, flagged : (n_sensors,) of the model, (n, n_sensors) bit masks of
        `estimation.watch.flags.Flag`; no sensor where nobody watched
    """

    estimator: str
    state_names: tuple[str, ...]
    time_s: Array
    mean: Array
    std: Array
    innovation: Array
    innovation_std: Array
    status: tuple[Status, ...]
    iterations: Array
    step_time_s: Array
    kkt_residual: Array
    reused_stages: Array
    squared_innovations: Array
    row_sets: Mapping[str, NDArray[np.bool_]] = field(default_factory=FrozenMapping)
    covariances: Covariances | None = None
    difference: ca.Function | None = None
    derived_names: tuple[str, ...] = ()
    derived: Array = field(default_factory=lambda: np.zeros((0, 0)))
    derived_std: Array = field(default_factory=lambda: np.zeros((0, 0)))
    outputs: Outputs | None = None
    state_units: tuple[str, ...] = ()
    lagged: Mapping[int, LaggedEstimates] = field(default_factory=FrozenMapping)
    arrival_s: Array = field(default_factory=lambda: np.zeros(0))
    sensor_names: tuple[str, ...] = ()
    flagged: Flags = field(default_factory=not_watched)

    def __post_init__(self) -> None:
        if len(self.arrival_s) != len(self.time_s):
            object.__setattr__(self, "arrival_s", self.time_s)
        if not self.derived_names:  # no column, and as many rows as steps
            for name in ("derived", "derived_std"):
                object.__setattr__(self, name, np.zeros((len(self.time_s), 0)))
        if not self.sensor_names:
            object.__setattr__(self, "flagged", np.zeros((len(self.time_s), 0), np.uint8))

    @classmethod
    def joined(
        cls, parts: Iterable[EstimateHistory], n_steps: int | None = None
    ) -> EstimateHistory:
        """Join the histories of successive parts of one run, at least one.

        Parameters
        ----------
        n_steps : of all parts together; known beforehand, parts are copied into the whole as
            they come, and no two of them need be there at once

        Without any part, or with another number of steps, it raises `InputError`.
        """
        if n_steps is None:
            parts = list(parts)
            n_steps = sum(map(len, parts))
        whole, status = None, list[Status]()
        for part in parts:
            whole = whole or part._with_arrays(lambda a: np.empty((n_steps, *a.shape[1:]), a.dtype))
            rows = slice(len(status), len(status) + len(part))
            for target, source in zip(whole._arrays(), part._arrays(), strict=True):
                target[rows] = source
            status += part.status
        if whole is None:
            raise InputError("no part of a history, expected at least one")
        if len(status) != n_steps:
            raise InputError(f"parts of {len(status)} steps in all, expected {n_steps}")
        return dataclasses.replace(whole, status=tuple(status))

    def _with_arrays(self, change: Callable[[Array], Array]) -> EstimateHistory:
        """Return a copy with each array that has an entry per step changed."""
        kept = self.covariances
        arrays: dict[str, Any] = {name: change(getattr(self, name)) for name in PER_STEP}
        return dataclasses.replace(
            self,
            **arrays,
            covariances=kept and Covariances(change(kept.state), change(kept.innovation)),
            lagged=FrozenMapping({lag: each.changed(change) for lag, each in self.lagged.items()}),
        )

    def _arrays(self) -> list[Array]:
        kept = self.covariances
        full = [] if kept is None else [kept.state, kept.innovation]
        lagged = [array for each in self.lagged.values() for array in each.arrays()]
        return [*(getattr(self, name) for name in PER_STEP), *full, *lagged]

    def __len__(self) -> int:
        return len(self.time_s)

    def __getitem__(self, rows: slice | NDArray[Any]) -> EstimateHistory:
        """Return some steps: a slice, an array of their numbers, or of bools (n,)."""
        check_rows(rows, len(self))
        status = tuple(self.status[k] for k in np.arange(len(self))[rows])
        return dataclasses.replace(self._with_arrays(lambda array: array[rows]), status=status)

    @property
    def covariance(self) -> Array:
        """(n, n_x, n_x), of a run that kept its covariances; raises `InputError` otherwise."""
        return self._kept().state

    @property
    def innovation_covariance(self) -> Array:
        """(n, n_r, n_r), likewise."""
        return self._kept().innovation

    def _kept(self) -> Covariances:
        if self.covariances is None:
            raise InputError(
                f"this history of {self.estimator} kept standard deviations only, expected full "
                "covariances: ask for them with run(…, covariances=True) or "
                "estimator.batch(…, covariances=True)"
            )
        return self.covariances

    @property
    def solved_fraction(self) -> float:
        """Fraction of the steps whose status is solved, with or without remarks."""
        return solved_fraction(self.status)

    def plot(
        self,
        states: Sequence[str] | None = None,
        *,
        truth: Truth | None = None,
        others: Sequence[EstimateHistory] | Mapping[str, EstimateHistory] = (),
    ) -> Figure:
        """Draw outputs over time with their ± 2 σ; returns the figure.

        Parameters
        ----------
        states : names, a panel each; None draws positions and angles, or the first states
        truth : drawn where it names the state
        others : histories to draw beside this one, by label or by their estimators' names
        """
        from estimation.history_plot import labelled, plot_histories

        return plot_histories(labelled(self, others), states, truth=truth)

    def to_pandas(self) -> pd.DataFrame:
        """Return a table: ``time_s``, `names`, ``<name>_std``, ``status``, ``step_time_s``.

        Behind ``time_s`` stands ``arrival_s`` where that differs, behind ``status`` stands
        ``flagged`` of a run that was watched: ``accel:stuck+camera:outlier``.
        """
        import pandas as pd  # 0.3 s to import, which a live estimator has no use for

        table = pd.DataFrame({"time_s": self.time_s})
        if not np.array_equal(self.arrival_s, self.time_s):
            table["arrival_s"] = self.arrival_s
        table[list(self.names)] = self.values
        table[[f"{name}_std" for name in self.names]] = self.values_std
        table["status"] = [status.label for status in self.status]
        if self.sensor_names:
            table["flagged"] = labels(self.flagged, self.sensor_names)
        table["iterations"] = self.iterations.astype(int)
        table["step_time_s"] = self.step_time_s
        return table

    def to_csv(self, path: str | Path) -> None:
        """Write the table of `to_pandas`, every digit of it."""
        with whole_file(path) as file:
            self.to_pandas().to_csv(file, index=False)

    def __repr__(self) -> str:
        from estimation.history_text import summary

        return f"<EstimateHistory {summary(self)}>"

    def _repr_html_(self) -> str:
        from estimation.history_text import html

        return html(self)
