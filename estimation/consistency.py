"""Whether an estimator's covariance is as large as its errors: NEES and NIS.

    NEES_k = e_kᵀ P_k⁻¹ e_k,  e = x ⊟ x̂      χ² with n_x degrees of freedom
    NIS_k  = v_kᵀ S_k⁻¹ v_k,  v = innovation   χ² with as many as rows were present

if the estimator is consistent. A mean above its region says that the estimator is
too sure of itself, below it that it is too careful. The same functions serve every
estimator: an MHE's covariance and innovation come from the pass of the Kalman
stage over its window. (On a nonlinear model that pass is linearised at a trajectory that
knows the newest reading, so an MHE's NIS is exact on linear models only.)

References
----------
Bar-Shalom, Li, Kirubarajan (2001), Estimation with Applications to Tracking and
Navigation, section 5.4.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimation.chi_square import quantile
from estimation.history import EstimateHistory
from estimation.mahalanobis import squared_distances
from estimation.tallies import Mean
from estimation.true_error import true_errors
from models.arrays import Array
from models.errors import InputError
from models.state_space import StateSpaceModel

PROBABILITY = 0.95
"""Of the regions; nearer to 1 is wider."""


@dataclass(frozen=True)
class Consistency:
    """A mean of squared Mahalanobis distances beside what χ² expects of it.

    Parameters
    ----------
    mean : of the statistic, over the instants that have it
    expected : its mean if the estimator is consistent
    lower, upper : region that holds the mean with `PROBABILITY`, if the instants were
        independent; those of a NEES are not, so its region is too narrow for one run
    inside_fraction : part of the instants inside their own two-sided region
    count : number of instants
    """

    mean: float
    expected: float
    lower: float
    upper: float
    inside_fraction: float
    count: int

    @property
    def is_inside(self) -> bool:
        """Whether the mean lies in its region."""
        return self.lower <= self.mean <= self.upper


def nees(model: StateSpaceModel, history: EstimateHistory, states: Array) -> Array:
    """Return the normalised estimation error squared (n,) of a run; see `estimation.true_error`.

    Parameters
    ----------
    states : (n, n_x) true states at the estimates' instants; NaN where not known

    Returns
    -------
    (n,), NaN where a true state is not known, inf where the covariance is not positive
    definite, as a diverged filter's may be.

    Raises
    ------
    InputError
        If there is not one true state per estimate, or the history kept no covariances.
    """
    if states.shape != history.mean.shape:
        raise InputError(
            f"true states have shape {states.shape}, expected {history.mean.shape}: "
            "one per estimate"
        )
    if history.covariances is None:
        raise InputError(
            f"the NEES of {history.estimator} needs full covariances, which its history did not "
            "keep: ask for them with run(…, covariances=True)"
        )
    error = true_errors(model, history.mean, states)
    known = np.asarray(~np.isnan(error).any(axis=1))
    used = np.broadcast_to(known[:, None], error.shape)
    return squared_distances(error, history.covariances.state, used)


def nis(history: EstimateHistory, rows: NDArray[np.bool_] | None = None) -> tuple[Array, Array]:
    """Return the normalised innovation squared (n,) and its degrees of freedom (n,).

    Instants without a reading have NaN and 0; inf as for `nees`.

    Parameters
    ----------
    rows : (n_r,) which rows of the residual count, all by default. A writing area's are
        no measurements: leave them out with the model's ``measured_rows``

    Raises
    ------
    InputError
        If the rows are neither of `EstimateHistory.row_sets` (all, those that measure, those
        of a sensor) and the history kept no covariances.
    """
    present = ~np.isnan(history.innovation)
    chosen = np.ones(present.shape[1], dtype=bool) if rows is None else rows
    if chosen.shape != present.shape[1:]:
        raise InputError(f"rows have shape {chosen.shape}, expected {present.shape[1:]}")
    present = present & chosen
    freedom = present.sum(axis=1)
    for column, kept in enumerate(history.row_sets.values()):
        if np.array_equal(kept, chosen):
            return history.squared_innovations[:, column], freedom
    if history.covariances is None:
        numbers = ", ".join(map(str, np.flatnonzero(chosen)))
        raise InputError(
            f"the NIS of rows {numbers} needs full covariances, "
            f"which the history did not keep, and has that of {', '.join(history.row_sets)}: ask "
            "for them with run(…, covariances=True)"
        )
    S = history.covariances.innovation
    return squared_distances(history.innovation, S, present), freedom


def consistency_of(squared: Array, freedom: Array | int) -> Consistency:
    """Compare squared distances with the χ² law.

    Parameters
    ----------
    squared : (n,), NaN where there is none
    freedom : degrees of freedom, one for all or (n,)

    Raises
    ------
    InputError
        If no instant has a value.
    """
    known = ~np.isnan(squared)
    if not known.any():
        raise InputError("no instant to judge consistency by, expected at least one")
    d, dof = squared[known], np.broadcast_to(freedom, squared.shape)[known]
    return judged(float(d.mean()), float(dof.sum()), inside(d, dof), len(d))


def inside(d: Array, dof: Array) -> int:
    """Return how many distances (n,) lie in the two-sided region of their freedom (n,)."""
    tail = (1 - PROBABILITY) / 2
    each, which = np.unique(dof, return_inverse=True)
    lower, upper = (np.asarray(quantile(part, each)) for part in (tail, 1 - tail))
    return int(((lower[which] <= d) & (d <= upper[which])).sum())


def judged(mean: float, total: float, inside: int, count: int) -> Consistency:
    """Return a mean of distances beside what χ² expects of it.

    Parameters
    ----------
    total : degrees of freedom of all instants together
    inside : number of instants in their own region, of `count`
    """
    tail = (1 - PROBABILITY) / 2
    return Consistency(
        mean=mean,
        expected=total / count,
        lower=float(quantile(tail, total)) / count,
        upper=float(quantile(1 - tail, total)) / count,
        inside_fraction=inside / count,
        count=count,
    )


class ConsistencyInParts:
    """`consistency_of` distances that come in parts."""

    def __init__(self) -> None:
        self._mean, self._total, self._inside = Mean(), 0.0, 0

    def add(self, squared: Array, freedom: Array | int) -> None:
        """Take more distances (n,), NaN where there is none."""
        known = ~np.isnan(squared)
        d, dof = squared[known], np.broadcast_to(freedom, squared.shape)[known]
        self._mean.add(d)
        self._total += float(dof.sum())
        self._inside += inside(d, dof)

    def result(self) -> Consistency | None:
        """Return what χ² says of all; None where no instant has a value."""
        count = self._mean.count
        return judged(self._mean.value, self._total, self._inside, count) if count else None
