"""An iteration limit of the real-time estimators: the best point is returned."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from estimation.status import Status
from mhe.config import MheConfig
from mhe.realtime import Mhe
from tests.estimation import pens
from tests.mhe.windows import moves
from tests.references.gauss_newton import DenseWindow

RUN = pens.draw_pen_run(14, seed=4)


@pytest.mark.parametrize("horizon", [4, 13])
@pytest.mark.parametrize(
    ("settings", "flag"),
    [
        ({"max_iterations": 0}, Status.ITERATION_LIMIT),
        ({"max_iterations": 1}, Status.ITERATION_LIMIT),
        ({"max_iterations": 2}, Status.ITERATION_LIMIT),
    ],
)
def test_a_limit_returns_the_best_point(
    horizon: int, settings: dict[str, Any], flag: Status
) -> None:
    """Never worse than the warm start."""
    mhe, flagged = Mhe(RUN.model, MheConfig(horizon=horizon, **settings)), 0
    for move in moves(mhe, RUN.measurements):
        estimate, window = move.estimate, DenseWindow(RUN.model, move.prior, move.measurements)
        costs = [window.cost(window.start(t)) for t in (move.found, move.guess)]
        assert costs[0] <= costs[1] * (1 + 1e-9)
        assert np.isfinite(estimate.state.covariance).all()
        assert estimate.status.is_solved == (flag not in estimate.status)
        flagged += flag in estimate.status
    assert flagged >= len(RUN.measurements) // 2
