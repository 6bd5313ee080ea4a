"""Limits of the real-time estimators: best point returned; constraints refused."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
import pytest

from estimation.status import Status
from mhe.config import MheConfig
from mhe.realtime import Mhe, MheRti
from models.errors import InputError
from models.state_space import StateSpaceModel
from tests.estimation import pens
from tests.linear_models import constant_acceleration_system
from tests.mhe.windows import moves
from tests.references.gauss_newton import DenseWindow

RUN = pens.draw_pen_run(14, seed=4)
MODEL = constant_acceleration_system(1).model


@pytest.mark.parametrize("horizon", [4, 13])
@pytest.mark.parametrize(
    ("settings", "flag"),
    [
        ({"max_iterations": 0}, Status.ITERATION_LIMIT),
        ({"max_iterations": 1}, Status.ITERATION_LIMIT),
        ({"max_iterations": 2}, Status.ITERATION_LIMIT),
        ({"max_time_s": 1e-9}, Status.TIME_LIMIT),
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


@pytest.mark.parametrize("kind", [MheRti, Mhe])
@pytest.mark.parametrize(
    "model",
    [
        MODEL.bounded(s0_m=(-1.0, np.inf)),
        MODEL.bounded(s2_m=(-np.inf, 5.0)),
        MODEL.constrained(lambda x: x[0] - 10.0),
        MODEL.constrained(lambda x: ca.sumsqr(x) - 100.0),
    ],
)
def test_constraints_are_refused(kind: type[MheRti], model: StateSpaceModel) -> None:
    with pytest.raises(InputError, match=r"^mhe\S* does not know bounds.*or mhe-ipopt$"):
        kind(model, MheConfig(horizon=3))
