"""Noise levels by the likelihood of the EKF's innovations: -Σ log N(v; 0, S)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from estimation.estimate import EstimateHistory
from models.pen_config import PenConfig
from pen_mhe.tuning.parts import ScoredPart
from pen_mhe.tuning.score import NATS, Filter, Judge, Score


def log_likelihood(history: EstimateHistory, rows: NDArray[np.bool_]) -> float:
    """Return Σ log N(v; 0, S) over the innovations of a history that kept its covariances.

    Parameters
    ----------
    rows : (n_r,) those that count
    """
    v, S = history.innovation[:, rows], history.innovation_covariance[:, rows][:, :, rows]
    present = ~np.isnan(v)
    some = present.any(axis=1)
    v, S, present = v[some], S[some], present[some]
    both = present[:, :, None] & present[:, None, :]
    S = np.where(both, S, np.eye(S.shape[1]))
    v = np.where(present, v, 0.0)
    try:
        L = np.linalg.cholesky(S)
    except np.linalg.LinAlgError:
        return -math.inf
    e = np.linalg.solve(L, v[:, :, None])
    log_det = 2 * np.log(np.diagonal(L, axis1=1, axis2=2)).sum()
    return -0.5 * float((e**2).sum() + log_det + present.sum() * math.log(2 * math.pi))


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
