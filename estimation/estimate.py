"""What an estimator says: one estimate, and the history of a run."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from estimation.status import Status
from models.arrays import Array
from models.errors import InputError
from models.gaussian import GaussianState
from models.names import unknown
from models.state_space import StateSpaceModel

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, eq=False)
class Window:
    """The trajectory of a moving horizon: times (N+1,), states (N+1, n_x)."""

    time_s: Array
    states: Array


@dataclass(frozen=True, eq=False)
class Estimate:
    """x_k|k: the state at one instant given all measurements up to it.

    Parameters
    ----------
    time_s : s
    state : mean (n_x,) and covariance (n_x, n_x)
    status : outcome of the step
    innovation : (n_r,) measurement minus prediction, NaN in rows without a reading
    innovation_covariance : (n_r, n_r) S
    iterations : of the solver; 1 for a filter
    window : the moving horizon, for estimators that have one; where `mhe-rti` keeps factors its
        older stages may be off by half of `MheConfig.reuse_threshold`
    call_s : seconds within the loop's own call, without what Python adds; NaN where there is none
    kkt_residual : how far the window is from its optimality conditions, in standard deviations:
        length of the last pass' step, or what a row of bounds and inequalities is exceeded by,
        whichever is larger; NaN where there is none
    reused_stages : stages whose factors were kept from the step before
    """

    time_s: float
    state: GaussianState
    status: Status
    innovation: Array
    innovation_covariance: Array
    iterations: int = 1
    window: Window | None = None
    call_s: float = np.nan
    kkt_residual: float = np.nan
    reused_stages: int = 0


_PER_STEP = (
    "time_s",
    "mean",
    "covariance",
    "innovation",
    "innovation_covariance",
    "iterations",
    "step_time_s",
    "kkt_residual",
    "reused_stages",
)
"""Arrays of a history with one entry per step."""


@dataclass(frozen=True, eq=False)
class EstimateHistory:
    """All estimates of a run as plain arrays.

    Parameters
    ----------
    estimator : its name
    state_names : (n_x,)
    time_s : (n,)
    mean : (n, n_x), in the units that end the state names
    covariance : (n, n_x, n_x)
    innovation, innovation_covariance : (n, n_r), (n, n_r, n_r)
    status : n statuses
    iterations : (n,)
    step_time_s : (n,) wall time of each step; of the compiled call where there is one
    kkt_residual, reused_stages : (n,), see `Estimate`
    """

    estimator: str
    state_names: tuple[str, ...]
    time_s: Array
    mean: Array
    covariance: Array
    innovation: Array
    innovation_covariance: Array
    status: tuple[Status, ...]
    iterations: Array
    step_time_s: Array
    kkt_residual: Array
    reused_stages: Array

    @classmethod
    def collect(
        cls,
        estimator: str,
        model: StateSpaceModel,
        estimates: Sequence[Estimate],
        step_time_s: Sequence[float],
    ) -> EstimateHistory:
        """Stack estimates into arrays."""
        n, n_x, n_r = len(estimates), model.n_x, model.n_r
        return cls(
            estimator=estimator,
            state_names=model.state_names,
            time_s=np.array([estimate.time_s for estimate in estimates]),
            mean=np.array([e.state.mean for e in estimates]).reshape(n, n_x),
            covariance=np.array([e.state.covariance for e in estimates]).reshape(n, n_x, n_x),
            innovation=np.array([e.innovation for e in estimates]).reshape(n, n_r),
            innovation_covariance=np.array([e.innovation_covariance for e in estimates]).reshape(
                n, n_r, n_r
            ),
            status=tuple(e.status for e in estimates),
            iterations=np.array([e.iterations for e in estimates], dtype=float),
            step_time_s=np.array(step_time_s, dtype=float),
            kkt_residual=np.array([e.kkt_residual for e in estimates], dtype=float),
            reused_stages=np.array([e.reused_stages for e in estimates], dtype=float),
        )

    @classmethod
    def joined(cls, parts: Sequence[EstimateHistory]) -> EstimateHistory:
        """Join the histories of successive parts of one run, at least one."""
        arrays: dict[str, Any] = {
            name: np.concatenate([getattr(part, name) for part in parts]) for name in _PER_STEP
        }
        arrays["status"] = tuple(status for part in parts for status in part.status)
        return dataclasses.replace(parts[0], **arrays)

    def __len__(self) -> int:
        return len(self.time_s)

    @property
    def std(self) -> Array:
        """(n, n_x) standard deviations."""
        return np.sqrt(np.diagonal(self.covariance, axis1=1, axis2=2))

    @property
    def solved_fraction(self) -> float:
        """Fraction of the steps whose status is solved, with or without remarks."""
        return float(np.mean([status.is_solved for status in self.status]))

    def column(self, state: str) -> Array:
        """Return the estimates (n,) of one state by name."""
        if state not in self.state_names:
            raise unknown("state", state, self.state_names)
        return self.mean[:, self.state_names.index(state)]

    def at(self, time_s: Array) -> EstimateHistory:
        """Return the estimates at some of the instants, given exactly.

        Raises
        ------
        InputError
            If there is no estimate at one of them.
        """
        rows = np.minimum(np.searchsorted(self.time_s, time_s), len(self) - 1)
        if (self.time_s[rows] != time_s).any():
            missing = time_s[self.time_s[rows] != time_s][0]
            raise InputError(f"no estimate at {missing:g} s, expected one of the run's instants")
        return dataclasses.replace(
            self,
            **{name: getattr(self, name)[rows] for name in _PER_STEP},
            status=tuple(self.status[row] for row in rows),
        )

    def to_pandas(self) -> pd.DataFrame:
        """Return a table: ``time_s``, the states, ``<state>_std``, ``status``, ``step_time_s``."""
        import pandas as pd  # 0.3 s to import, which a live estimator has no use for

        table = pd.DataFrame({"time_s": self.time_s})
        table[list(self.state_names)] = self.mean
        table[[f"{name}_std" for name in self.state_names]] = self.std
        table["status"] = [status.label for status in self.status]
        table["iterations"] = self.iterations.astype(int)
        table["step_time_s"] = self.step_time_s
        return table
