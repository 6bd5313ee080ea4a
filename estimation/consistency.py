"""Whether an estimator's covariance is as large as its errors: NEES and NIS.

    NEES_k = e_kᵀ P_k⁻¹ e_k,  e = x̂ ⊟ x      χ² with n_x degrees of freedom
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
from scipy.linalg import solve_triangular

from estimation.estimate import EstimateHistory
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
    """Return the normalised estimation error squared (n,) of a run.

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
        If there is not one true state per estimate.
    """
    if states.shape != history.mean.shape:
        raise InputError(
            f"true states have shape {states.shape}, expected {history.mean.shape}: "
            "one per estimate"
        )
    return np.array(
        [
            _squared_distance(np.asarray(model.difference(mean, x)).ravel(), P)
            for mean, x, P in zip(history.mean, states, history.covariance, strict=True)
        ]
    )


def nis(history: EstimateHistory, rows: NDArray[np.bool_] | None = None) -> tuple[Array, Array]:
    """Return the normalised innovation squared (n,) and its degrees of freedom (n,).

    Instants without a reading have NaN and 0; inf as for `nees`.

    Parameters
    ----------
    rows : (n_r,) which rows of the residual count, all by default. A writing area's are
        no measurements: leave them out with the model's ``measured_rows``
    """
    present = ~np.isnan(history.innovation)
    if rows is not None:
        present = present & rows
    squared = [
        _squared_distance(v[some], S[np.ix_(some, some)]) if some.any() else np.nan
        for v, S, some in zip(
            history.innovation, history.innovation_covariance, present, strict=True
        )
    ]
    return np.array(squared), present.sum(axis=1)


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
    from scipy.stats import chi2  # 0.5 s to import

    known = ~np.isnan(squared)
    if not known.any():
        raise InputError("no instant to judge consistency by, expected at least one")
    d, dof = squared[known], np.broadcast_to(freedom, squared.shape)[known]
    count, tail = len(d), (1 - PROBABILITY) / 2
    total = float(dof.sum())
    inside = (chi2.ppf(tail, dof) <= d) & (d <= chi2.ppf(1 - tail, dof))
    return Consistency(
        mean=float(d.mean()),
        expected=total / count,
        lower=float(chi2.ppf(tail, total)) / count,
        upper=float(chi2.ppf(1 - tail, total)) / count,
        inside_fraction=float(inside.mean()),
        count=count,
    )


def _squared_distance(error: Array, covariance: Array) -> float:
    """Return eᵀ P⁻¹ e, scaled first: variances of a pen differ by ten orders of magnitude.

    A covariance that is not positive definite claims more than certainty: inf.
    """
    if np.isnan(error).any():
        return float("nan")
    variance = np.diag(covariance)
    if not (variance > 0).all():
        return float("inf")
    std = np.sqrt(variance)
    try:
        L = np.linalg.cholesky(covariance / np.outer(std, std))
    except np.linalg.LinAlgError:
        return float("inf")
    return float((solve_triangular(L, error / std, lower=True) ** 2).sum())
