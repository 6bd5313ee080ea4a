"""What OSQP keeps from window to window: its factorisation, and where it starts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from estimation.kalman_stage import KalmanStage
from estimation.recording import Measurement
from mhe.sparse_qp.osqp_window import OsqpWindow
from models.state_space import StateSpaceModel
from tests.estimation import pens
from tests.linear_models import coupled_system
from tests.mhe.linearised_windows import Linearised, bounded_stream, linearised, run
from tests.mhe.runs import linear_batch

pytestmark = pytest.mark.usefixtures("interpreted")

TOLERANCE = 1e-9
N_STAGES = 9


def test_the_factorisation_stays_where_only_vectors_change() -> None:
    model, measurements = bounded_stream(N_STAGES + 3)
    osqp, kept = OsqpWindow(model, N_STAGES), []
    for k in range(3):
        window = linearised(model, measurements[k : k + N_STAGES], seed=k)
        found, fresh = run(window, osqp), run(window, OsqpWindow(model, N_STAGES))
        kept.append(found.kept_factors)
        std = np.sqrt(np.diag(found.newest))
        assert np.abs((found.d - fresh.d) / std).max() < TOLERANCE
        assert not fresh.kept_factors
    assert kept == [False, True, True]
    missing = [replace(m, y=np.where(k == 4, np.nan, m.y)) for k, m in enumerate(measurements)]
    window = linearised(model, missing[:N_STAGES], seed=0)
    found, fresh = run(window, osqp), run(window, OsqpWindow(model, N_STAGES))
    assert not found.kept_factors
    assert found.d == pytest.approx(fresh.d, abs=1e-9)


def sliding(model: StateSpaceModel, measurements: list[Measurement]) -> list[Linearised]:
    """The windows of a horizon that slides, with an EKF's priors, linearised at predictions."""
    stage, prior, windows = KalmanStage(model), model.prior, []
    for k in range(len(measurements) - N_STAGES + 1):
        stages = measurements[k : k + N_STAGES]
        at_prior = model.replace(prior=prior)
        window = linearised(at_prior, stages, seed=k, off=0.0)
        for i, dt in enumerate(np.diff(window.view.times)):
            window.view.x[i + 1] = model.f(window.view.x[i], window.view.w[i], dt).full().ravel()
        windows.append(window)
        dt = stages[1].time_s - stages[0].time_s
        prior = stage.predict(stage.update(prior, stages[0].y).state, dt).state
    return windows


def test_the_next_window_starts_from_the_last_optimum() -> None:
    """Fewer iterations than from the trajectory, over a stream, and the same optimum."""
    pen = pens.draw_pen_run(N_STAGES + 10, 3)
    free = pens.pen_batch(pen.measurements).solve().states
    model = pen.model.bounded(tip_z_m=(float(np.quantile(free[:, 2], 0.6)), np.inf))
    warm, cold = OsqpWindow(model, N_STAGES), OsqpWindow(model, N_STAGES)
    iterations = {"warm": 0, "cold": 0}
    for k, window in enumerate(sliding(model, pen.measurements)):
        cold.forget()
        found, other = run(window, warm), run(window, cold)
        std = np.sqrt(np.diag(found.newest))
        assert np.abs((found.d - other.d) / std).max() < TOLERANCE
        assert (found.multipliers > 0).any()
        if k:
            iterations["warm"] += found.iterations
            iterations["cold"] += other.iterations
    assert iterations["warm"] < 0.8 * iterations["cold"], iterations


def test_an_instant_that_says_nothing_is_predicted() -> None:
    """Then the last optimum, shifted, is the next one already: OSQP's first look will do."""
    system, rng = coupled_system(3), np.random.default_rng(8)
    times = 0.125 * np.arange(N_STAGES + 1)
    measurements = system.simulate(times, rng, missing=0.0)
    measurements[-1] = replace(measurements[-1], y=np.full(3, np.nan))
    limit = float(np.quantile(linear_batch(system, measurements).solve().states[:-2, 0], 0.8))
    model = system.model.constrained(lambda x: x[0] - limit, needs=["first_0"])
    first, second = sliding(model, measurements)
    osqp = OsqpWindow(model, N_STAGES)
    before = run(first, osqp)
    after = run(second, osqp)
    assert (after.multipliers > 0).any()
    assert after.multipliers[:-1] == pytest.approx(before.multipliers[1:], abs=1e-6)
    assert after.iterations <= 5 < before.iterations
