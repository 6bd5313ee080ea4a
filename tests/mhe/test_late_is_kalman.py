"""Late readings on a linear model: the Kalman filter that had them in order of capture."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from estimation.recording import Measurement
from estimation.status import Status
from mhe.config import MheConfig
from mhe.realtime import Mhe
from tests.configs import config_for
from tests.engines import steps
from tests.linear_models import constant_acceleration_system, coupled_system, irregular_times
from tests.mhe.late_streams import Delays, in_order, is_late, late_stream
from tests.mhe.runs import ESTIMATORS
from tests.mhe.windows import window_of

SYSTEMS = {"coupled": coupled_system(3), "two axes": constant_acceleration_system(2, density=20.0)}
TOLERANCE_STD = {"mhe-ipopt": 1e-8, "mhe-rti": 1e-9, "mhe": 1e-9}
HORIZON = 12
CASES = [
    *(
        ("mhe-rti", {"arrival_cost": a, "reuse_threshold": t})
        for a in ("filtered", "smoothed")
        for t in (0.0, 0.5)
    ),
    ("mhe", {}),
    ("mhe", {"arrival_cost": "filtered"}),
    ("mhe-ipopt", {}),
]


def stream_of(name: str, n: int, seed: int, delays: Delays | None = None) -> list[Measurement]:
    system, rng = SYSTEMS[name], np.random.default_rng(seed)
    measurements = system.simulate(irregular_times(n, rng), rng, missing=0.2)
    return late_stream(system.model, measurements, rng, delays)


def check_in_order(name: str, stream: list[Measurement], estimator: Any, tolerance: float) -> int:
    """Every estimate is that of the filter on what had arrived; returns how many were late."""
    system, late, merged = SYSTEMS[name], 0, 0
    for k, (measurement, estimate) in enumerate(zip(stream, steps(estimator, stream), strict=True)):
        rows = in_order(stream[: k + 1], system.model.n_y)
        posteriors = system.textbook(rows)
        wanted = posteriors[-1]
        std = np.sqrt(np.diag(wanted.covariance))
        assert estimate.time_s == rows[-1].time_s
        assert np.abs((estimate.state.mean - wanted.mean) / std).max() < tolerance
        errors = (estimate.state.covariance - wanted.covariance) / np.outer(std, std)
        assert np.abs(errors).max() < tolerance
        assert estimate.status & ~Status.NO_READING is Status.SOLVED
        at = max(i for i, row in enumerate(rows) if row.time_s == measurement.time_s)
        own = np.isfinite(measurement.y)
        np.testing.assert_array_equal(np.isfinite(estimate.innovation), own)
        if own.any():
            told = posteriors[at]
            picked = np.isin(told.rows, np.flatnonzero(own))
            S = told.innovation_covariance[np.ix_(picked, picked)]
            off = (estimate.innovation[own] - told.innovation[picked]) / np.sqrt(np.diag(S))
            assert np.abs(off).max() < 1e-8
            ours = estimate.innovation_covariance[np.ix_(own, own)]
            np.testing.assert_allclose(ours, S, rtol=1e-8, atol=1e-12)
        late += is_late(stream, k)
        merged += is_late(stream, k) and len(rows) == len(in_order(stream[:k], len(own)))
    assert 0 < merged < late
    return late


@pytest.mark.cover
@pytest.mark.parametrize(("estimator", "settings"), CASES)
@pytest.mark.parametrize("name", SYSTEMS)
def test_every_estimate_is_the_filters_that_had_them_in_order(
    name: str, estimator: str, settings: dict[str, Any]
) -> None:
    n = 18 if estimator == "mhe-ipopt" else 45
    config = config_for(estimator, horizon=HORIZON, **settings)
    mhe = ESTIMATORS[estimator](SYSTEMS[name].model, config)
    late = check_in_order(name, stream_of(name, n, seed=5), mhe, TOLERANCE_STD[estimator])
    assert late >= n // 3


@pytest.mark.slow
@pytest.mark.parametrize("estimator", ["mhe-rti", "mhe"])
@pytest.mark.parametrize("horizon", [4, 20, 200])
@pytest.mark.parametrize("seed", range(6))
def test_whatever_comes_late(seed: int, horizon: int, estimator: str) -> None:
    """Far or near, in windows that are short for it, or never full."""
    delays = Delays(most=1 if horizon == 4 else 7, off=(seed % 3) / 2)
    if delays.off in (0.0, 1.0):
        delays = Delays(most=delays.most, off=0.2 + 0.6 * delays.off)
    mhe = ESTIMATORS[estimator](SYSTEMS["coupled"].model, config_for(estimator, horizon=horizon))
    check_in_order("coupled", stream_of("coupled", 60, 40 + seed, delays), mhe, 1e-9)


@pytest.mark.parametrize("estimator", ["mhe-rti", "mhe", "mhe-ipopt"])
def test_a_reading_from_before_the_first(estimator: str) -> None:
    """As long as the window has room: the prior is that of the oldest instant."""
    system, rng = SYSTEMS["coupled"], np.random.default_rng(8)
    measurements = system.simulate(irregular_times(9, rng), rng, missing=0.0)
    order = [3, 4, 1, 5, 2, 0, 6, 7, 8]
    stream = [measurements[i] for i in order]
    mhe = ESTIMATORS[estimator](system.model, config_for(estimator, horizon=9))
    for k, estimate in enumerate(steps(mhe, stream)):
        wanted = system.textbook(in_order(stream[: k + 1], system.model.n_y))[-1]
        std = np.sqrt(np.diag(wanted.covariance))
        error = np.abs((estimate.state.mean - wanted.mean) / std).max()
        assert error < TOLERANCE_STD[estimator]
        assert estimate.status is Status.SOLVED


@pytest.mark.parametrize("estimator", ["mhe-rti", "mhe", "mhe-ipopt"])
def test_it_becomes_the_oldest_stage(estimator: str) -> None:
    """Captured between the two oldest: the prior is predicted to its capture, not beyond."""
    system, rng = SYSTEMS["coupled"], np.random.default_rng(9)
    measurements = system.simulate(irregular_times(14, rng), rng, missing=0.0)
    mhe = ESTIMATORS[estimator](system.model, config_for(estimator, horizon=4))
    state = mhe.init()
    for m in measurements[:10]:
        state, _ = mhe.step(state, m)
    time_s = measurements[5].time_s + 0.3 * (measurements[6].time_s - measurements[5].time_s)
    late = Measurement(time_s, measurements[6].y + 0.1)
    state, estimate = mhe.step(state, late)
    assert estimate.window is not None
    assert estimate.window.time_s[0] == time_s
    arrived = [*measurements[:10], late]
    for m in (None, *measurements[10:]):
        if m is not None:
            state, estimate = mhe.step(state, m)
            arrived.append(m)
        wanted = system.textbook(in_order(arrived, system.model.n_y))[-1]
        std = np.sqrt(np.diag(wanted.covariance))
        error = np.abs((estimate.state.mean - wanted.mean) / std).max()
        assert error < TOLERANCE_STD[estimator]


@pytest.mark.parametrize("share", [0.2, 0.5, 0.8])
def test_a_reading_that_its_first_guess_meets_is_no_trap(share: float) -> None:
    """The window costs more with it than what is guessed first, which no trajectory costs."""
    system, rng = SYSTEMS["two axes"], np.random.default_rng(10)
    measurements = system.simulate(np.arange(12) * 0.2, rng, missing=0.0)
    mhe = Mhe(system.model, MheConfig(horizon=20))
    state = mhe.init()
    for m in measurements:
        state, _ = mhe.step(state, m)
    window, dt = window_of(mhe, state), 0.2 * share
    guessed = system.model.f(window.x[7], np.sqrt(share) * window.w[7], dt)
    late = Measurement(measurements[7].time_s + dt, system.H @ np.asarray(guessed).ravel())
    _, estimate = mhe.step(state, late)
    assert estimate.status is Status.SOLVED
    wanted = system.textbook(in_order([*measurements, late], system.model.n_y))[-1]
    std = np.sqrt(np.diag(wanted.covariance))
    assert np.abs((estimate.state.mean - wanted.mean) / std).max() < 1e-9
