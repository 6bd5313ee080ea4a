"""Settings of the moving-horizon estimators, for each what it reads."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from estimation.losses import checked_thresholds, of_sensors
from mhe.arrival_cost import ARRIVAL_COSTS
from mhe.ipopt_options import Option, checked_options
from mhe.lags import checked_lags
from mhe.loss import LEAST_SQUARES
from mhe.scheme import MAX_ITERATIONS, TOLERANCE, Scheme
from models.arrays import Array, is_real, is_whole
from models.errors import InputError
from models.frozen_mapping import FrozenMapping
from models.names import unknown

HESSIANS = ("gauss-newton", "exact")

Clock = Callable[[], float]
"""Seconds that only grow; any origin."""


def check_count(name: str, value: object, least: int) -> None:
    """Raise `InputError` unless a setting is a whole number that is large enough."""
    if not (is_whole(value) and value >= least):
        raise InputError(f"{name} is {value!r}, expected a whole number of at least {least}")


def check_stages(count: int, horizon: int) -> None:
    """Raise `InputError` unless a window of so many measurements is one of a horizon."""
    if not 1 <= count <= horizon + 1:
        raise InputError(f"a window of {count} measurements, expected 1 to {horizon + 1}")


@dataclass(frozen=True, kw_only=True)
class WindowConfig:
    """Settings that every moving-horizon estimator reads: its window, and how that is weighed.

    Parameters
    ----------
    horizon : N, intervals between stages; more looks further back and costs more
    arrival_cost : one of `mhe.arrival_cost.ARRIVAL_COSTS`
    huber : sensor → threshold of Huber's loss, in standard deviations of the sensor's
        whole residual; smaller trusts a reading far off less, a sensor that is not
        named is weighed by least squares. See `mhe.loss`
    sparse_noise : threshold of Huber's loss on every unit process noise; smaller lets
        few large jumps through and damps the rest less, None is least squares
    deadline_s : from the beginning of a step, s; before a pass that would end later the best
        so far is returned, a prediction where there was no time for any; None has none.
        ``mhe-ipopt`` hands it to IPOPT as its longest wall time
    lag_samples : a number, or several, at most the horizon: each step also tells of the instant
        that many samples before its newest, given all readings up to the newest, for
        `estimation.history.EstimateHistory.at_lag`; each costs time, more the larger it is

    Raises
    ------
    InputError
        If a setting is outside its range; the message names it.
    """

    horizon: int = 20
    arrival_cost: str = "smoothed"
    huber: Mapping[str, float] = field(default_factory=dict)
    sparse_noise: float | None = None
    deadline_s: float | None = None
    lag_samples: int | tuple[int, ...] = ()

    def __post_init__(self) -> None:
        check_count("horizon", self.horizon, 1)
        object.__setattr__(self, "lag_samples", checked_lags(self.lag_samples, self.horizon))
        object.__setattr__(self, "huber", checked_thresholds(self.huber))
        if self.arrival_cost not in ARRIVAL_COSTS:
            raise unknown("arrival cost", self.arrival_cost, ARRIVAL_COSTS)
        if self.sparse_noise is not None:
            checked_thresholds({"sparse_noise": self.sparse_noise})
        if self.deadline_s is not None and not (is_real(self.deadline_s) and self.deadline_s > 0):
            raise InputError(f"deadline_s is {self.deadline_s!r}, expected a positive time")

    @property
    def lags(self) -> tuple[int, ...]:
        """The lags that each step tells of, in samples, ascending."""
        assert isinstance(self.lag_samples, tuple)
        return self.lag_samples

    def thresholds(self, sensors: Sequence[str]) -> Array:
        """Return the thresholds of Huber's loss per sensor, `mhe.loss.LEAST_SQUARES` for none.

        Raises
        ------
        InputError
            If a sensor with a threshold is not among `sensors`.
        """
        known = of_sensors(self.huber, sensors, "Huber's loss")
        return np.array([known.get(name, LEAST_SQUARES) for name in sensors], dtype=float)

    @property
    def noise_threshold(self) -> float:
        """Threshold of Huber's loss on the noises."""
        return LEAST_SQUARES if self.sparse_noise is None else self.sparse_noise

    @property
    def has_losses(self) -> bool:
        """Whether anything is weighed otherwise than by least squares."""
        return bool(self.huber) or self.sparse_noise is not None


@dataclass(frozen=True, kw_only=True)
class ConvergedConfig(WindowConfig):
    """Settings of whoever iterates until a window is solved.

    Parameters
    ----------
    tolerance : where iterating ends, in standard deviations; smaller iterates longer
    max_iterations : per step; the best point is returned when it is reached

    Raises
    ------
    InputError
        If a setting is outside its range; the message names it.
    """

    tolerance: float = TOLERANCE
    max_iterations: int = MAX_ITERATIONS

    def __post_init__(self) -> None:
        super().__post_init__()
        if not (is_real(self.tolerance) and self.tolerance > 0):
            raise InputError(f"tolerance is {self.tolerance!r}, expected a positive number")
        check_count("max_iterations", self.max_iterations, 0)


@dataclass(frozen=True, kw_only=True)
class MheConfig(ConvergedConfig):
    """Settings of ``mhe``.

    Parameters
    ----------
    horizon, arrival_cost, huber, sparse_noise, deadline_s, lag_samples : see `WindowConfig`
    tolerance, max_iterations : see `ConvergedConfig`
    """

    @property
    def scheme(self) -> Scheme:
        """Passes to convergence, each a full one."""
        return Scheme(converges=True, tolerance=self.tolerance, max_iterations=self.max_iterations)


@dataclass(frozen=True, kw_only=True)
class MheRtiConfig(WindowConfig):
    """Settings of ``mhe-rti``.

    Parameters
    ----------
    horizon, arrival_cost, huber, sparse_noise, deadline_s, lag_samples : see `WindowConfig`
    reuse_threshold : in standard deviations: a stage whose estimate is so near
        to where it was linearised keeps its factors when the window slides, as long as all
        older ones do, and is not smoothed again until later readings move it by half of
        that; larger is faster and further from full passes, 0 makes every pass a full one. None
        chooses by the model, see `mhe.reuse`

    Raises
    ------
    InputError
        If a setting is outside its range; the message names it.
    """

    reuse_threshold: float | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        reuse = self.reuse_threshold
        if reuse is not None and not (is_real(reuse) and reuse >= 0):
            raise InputError(f"reuse_threshold is {reuse!r}, expected 0 or standard deviations")

    @property
    def scheme(self) -> Scheme:
        """One pass a sample."""
        return Scheme(converges=False, reuse_threshold=self.reuse_threshold)


RealTimeConfig = MheConfig | MheRtiConfig
"""Settings of whatever makes passes of the Kalman stage; each has a ``scheme``."""


@dataclass(frozen=True, kw_only=True)
class MheIpoptConfig(ConvergedConfig):
    """Settings of ``mhe-ipopt``.

    Parameters
    ----------
    horizon, arrival_cost, huber, sparse_noise, deadline_s, lag_samples : see `WindowConfig`
    tolerance, max_iterations : see `ConvergedConfig`
    hessian : ``gauss-newton`` or ``exact``. The exact Hessian of a window
        is often indefinite far from the optimum, and IPOPT then may leave for another one
        (on the D-POINT recording it did, into an upright pen); Gauss-Newton always
        descends and ends in the same optimum where both converge
    ipopt : IPOPT's own options by name, ``{"max_iter": 500, "linear_solver": "mumps"}``; they
        come before what the other settings make of them

    Raises
    ------
    InputError
        If a setting is outside its range, or IPOPT does not take an option; the message names it.
    """

    hessian: str = "gauss-newton"
    ipopt: Mapping[str, Option] = field(default_factory=dict)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.hessian not in HESSIANS:
            raise unknown("hessian", self.hessian, HESSIANS)
        object.__setattr__(self, "ipopt", FrozenMapping(checked_options(self.ipopt)))
