"""An estimator's history whose content is known."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from estimation.estimate import EstimateHistory, Status


def history(
    names: Sequence[str],
    time_s: np.ndarray,
    mean: np.ndarray,
    std: float = 0.1,
    failed: int = 0,
) -> EstimateHistory:
    """Means (n, n_x) with one deviation for all; the first steps failed; step k took k + 1 s."""
    n, n_x = mean.shape
    return EstimateHistory(
        estimator="hand-made",
        state_names=tuple(names),
        time_s=time_s,
        mean=mean,
        std=np.full((n, n_x), std),
        innovation=np.zeros((n, 0)),
        innovation_std=np.zeros((n, 0)),
        squared_innovations=np.zeros((n, 0)),
        status=tuple(Status.SOLVER_FAILED if k < failed else Status.SOLVED for k in range(n)),
        iterations=np.ones(n),
        step_time_s=np.arange(1.0, n + 1),
        kkt_residual=np.full(len(time_s), np.nan),
        reused_stages=np.zeros(len(time_s)),
    )
