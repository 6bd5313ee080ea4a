"""Noise levels by the likelihood of the EKF's innovations: -Σ log N(v; 0, S)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from estimation.estimate import EstimateHistory
from models.arrays import Array
from models.pen_config import PenConfig
from pen_mhe.tuning.parts import ScoredPart
from pen_mhe.tuning.score import NATS, Filter, Judge, Score


def log_densities(v: Array, S: Array) -> Array:
    """Return log N(v; 0, S) of each instant (n,), 0 without a reading; -inf where S is no variance.

    Parameters
    ----------
    v, S : (n, n_r), (n, n_r, n_r) innovations, NaN where there is no reading, and covariances
    """
    present = ~np.isnan(v)
    both = present[:, :, None] & present[:, None, :]
    S = np.where(both, S, np.eye(S.shape[1]))
    try:
        L = np.linalg.cholesky(S)
    except np.linalg.LinAlgError:
        return np.full(len(v), -np.inf)
    e = np.linalg.solve(L, np.where(present, v, 0.0)[:, :, None])[:, :, 0]
    log_det = 2 * np.log(np.diagonal(L, axis1=1, axis2=2)).sum(axis=1)
    n = present.sum(axis=1)
    return np.asarray(-0.5 * ((e**2).sum(axis=1) + log_det + n * math.log(2 * math.pi)))


def log_likelihood(history: EstimateHistory, rows: NDArray[np.bool_]) -> float:
    """Return Σ log N(v; 0, S) over the innovations of a history that kept its covariances.

    Parameters
    ----------
    rows : (n_r,) those that count
    """
    v, S = history.innovation[:, rows], history.innovation_covariance[:, rows][:, :, rows]
    some = ~np.isnan(v).all(axis=1)
    return float(log_densities(v[some], S[some]).sum())


def by_innovations(part: ScoredPart) -> Judge:
    """Return the judge of a part by what is measured: every sensor with readings."""
    time_s, y = part.stacked

    def judged(run: Filter, pen: PenConfig) -> Score:
        history = run(pen, time_s, y, covariances=True).between(part.counts_from_s)
        rows = part.model.measured_rows
        found = log_likelihood(history, rows)
        squared = history.squared_innovations[:, list(history.row_sets).index("measured")]
        count = (~np.isnan(history.innovation[:, rows])).sum()
        nis = float(np.nansum(squared) / count)
        return Score(
            -found if math.isfinite(found) else math.inf,
            {"log likelihood": found, "NIS per row": nis},
            NATS,
        )

    return judged
