"""A late reading becomes a stage of the window at its capture."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from estimation.kalman_stage import rows_present
from estimation.recording import Measurement
from estimation.status import Status
from mhe.config import MheConfig, MheRtiConfig
from mhe.interpreted.window_pass import WindowPass
from mhe.realtime import Mhe, MheRti
from mhe.trajectory import Trajectory
from mhe.window_memory import Scales, View, packed_window, window_memory
from models.gaussian import GaussianState
from tests.closeness import mean_error
from tests.configs import config_for
from tests.mhe.late_pen import MODEL, RUN, STREAM, between, either_engine, ready, stages_of
from tests.mhe.late_streams import is_late
from tests.mhe.runs import ESTIMATORS
from tests.mhe.windows import real_time, window_of


@pytest.mark.cover
@pytest.mark.parametrize("threshold", [0.0, 0.5])
@pytest.mark.parametrize("arrival_cost", ["smoothed", "filtered"])
def test_one_pass_is_that_of_the_window_built_anew(arrival_cost: str, threshold: float) -> None:
    """From its arrival prior, with its readings in order, linearised where it was."""
    config = MheRtiConfig(horizon=12, arrival_cost=arrival_cost, reuse_threshold=threshold)
    mhe, passes = MheRti(MODEL, config), WindowPass(MODEL, config)
    state, kept, late = mhe.init(), 0, 0
    for k, measurement in enumerate(STREAM):
        state, estimate = mhe.step(state, measurement)
        if not is_late(STREAM, k):
            continue
        window = window_of(mhe, state)
        stages, points = stages_of(window, STREAM[: k + 1]), Trajectory(window.x_lin, window.w_lin)
        anew = packed_window(MODEL, 13, window.prior, stages, points)
        built = View.of(window_memory(MODEL, 13), anew.memory)
        np.testing.assert_array_equal(built.times, window.times)
        np.testing.assert_array_equal(built.present, window.present)
        scales = Scales(built.present, np.ones(window.w.shape))
        found = passes.run(built, -window.prior_deviation, scales, built.x_lin, built.w_lin)
        for stage in range(len(stages) if threshold == 0 else 0, len(stages)):
            wanted = passes.stage.retract(built.x_lin[stage], found.d[stage])
            known = GaussianState(wanted, found.covariances[stage])
            assert mean_error(MODEL, window.x[stage], known) < 1e-9
        newest = replace(
            found.newest.state, mean=passes.stage.retract(built.x_lin[-1], found.d[-1])
        )
        assert mean_error(MODEL, estimate.state.mean, newest) < 1e-9
        off = (estimate.state.covariance - newest.covariance) / np.outer(newest.std, newest.std)
        assert np.abs(off).max() < 1e-9
        late, kept = late + 1, kept + estimate.reused_stages
    assert late > 8
    assert (kept > 2 * late) == (threshold > 0)


@pytest.mark.parametrize("arrival_cost", ["smoothed", "filtered"])
def test_converged_it_is_the_window_solved_anew(arrival_cost: str) -> None:
    """From a start of its own."""
    tight = MheConfig(horizon=8, arrival_cost=arrival_cost, tolerance=1e-10)
    mhe, other = Mhe(MODEL, tight), Mhe(MODEL, tight)
    state, late = mhe.init(), 0
    for k, measurement in enumerate(STREAM):
        state, estimate = mhe.step(state, measurement)
        if not is_late(STREAM, k):
            continue
        window = window_of(mhe, state)
        stages = stages_of(window, STREAM[: k + 1])
        guess = Trajectory(window.prior.mean[None], np.zeros(window.w.shape))
        solved = other.solve(
            window.prior, stages, replace(guess, states=np.repeat(guess.states, len(stages), 0))
        )
        if estimate.status is Status.SOLVED and solved.status is Status.SOLVED:
            assert mean_error(MODEL, estimate.state.mean, solved.newest) < 1e-9
            late += 1
    assert late > 8


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_what_it_says(estimator: str) -> None:
    """The newest instant's time and state; innovation and remarks of the late rows."""
    mhe, state, before = ready(estimator)
    y = np.where(np.arange(MODEL.n_y) < 3, RUN.measurements[7].y, np.nan)
    _, estimate = mhe.step(state, Measurement(between(6), y))
    assert estimate.time_s == before.time_s
    assert estimate.status is Status.SOLVED
    np.testing.assert_array_equal(np.isfinite(estimate.innovation), rows_present(MODEL, y))
    assert estimate.window.time_s[-4] == between(6)
    assert len(estimate.window.time_s) == 7
    _, nothing = mhe.step(state, Measurement(between(6), np.full(MODEL.n_y, np.nan)))
    assert nothing.status is Status.NO_READING
    assert np.isnan(nothing.innovation).all()
    _, infinite = mhe.step(state, Measurement(between(6), np.where(np.isnan(y), np.inf, y)))
    assert infinite.status is Status.INFINITE_READING


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_readings_of_one_instant_are_one_stage(estimator: str) -> None:
    """Told are the innovations of those that came late, as if the others were missing."""
    mhe = ESTIMATORS[estimator](MODEL, config_for(estimator, horizon=6))
    first = np.arange(MODEL.n_y) < 3
    state, times = mhe.init(), []
    for k, m in enumerate(RUN.measurements[:10]):
        y = np.where(first, m.y, np.nan) if k == 7 else m.y
        state, estimate = mhe.step(state, replace(m, y=y))
        times.append(m.time_s)
    late = np.where(first, np.nan, RUN.measurements[7].y)
    after, estimate = mhe.step(state, Measurement(times[7], late))
    np.testing.assert_array_equal(estimate.window.time_s, times[-7:])
    own, S = rows_present(MODEL, late), estimate.innovation_covariance
    assert own.any()
    assert not own.all()
    np.testing.assert_array_equal(np.isfinite(estimate.innovation), own)
    assert (S[np.ix_(own, ~own)] == 0).all()
    np.testing.assert_array_equal(S[np.ix_(~own, ~own)], np.diag(MODEL.noise_std[~own] ** 2))
    assert np.linalg.eigvalsh(S).min() > 0
    # once more: now its readings are there, and it is a stage behind the other
    _, again = mhe.step(after, Measurement(times[7], late))
    np.testing.assert_array_equal(again.window.time_s, sorted([*times[-6:], times[7]]))


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_older_than_the_window_changes_nothing(estimator: str) -> None:
    mhe, state, before = ready(estimator)
    oldest_s = before.window.time_s[0]
    late = Measurement(float(np.nextafter(oldest_s, 0)), RUN.measurements[3].y)
    after, estimate = mhe.step(state, late)
    assert estimate.status is Status.LATE
    assert estimate.time_s == before.time_s
    assert np.isnan(estimate.innovation).all()
    np.testing.assert_array_equal(estimate.state.mean, before.state.mean)
    _, one = mhe.step(state, RUN.measurements[10])
    _, other = mhe.step(after, RUN.measurements[10])
    np.testing.assert_array_equal(one.state.mean, other.state.mean)
    _, reached = mhe.step(state, replace(late, time_s=float(oldest_s)))
    assert Status.LATE not in reached.status


@pytest.mark.cover
@either_engine
@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_an_absurd_one_leaves_the_window_as_it_was(estimator: str) -> None:
    mhe, state, before = ready(estimator)
    after, estimate = mhe.step(state, Measurement(between(6), np.full(MODEL.n_y, 1e200)))
    assert estimate.status is Status.NOT_FINITE
    assert estimate.time_s == before.time_s
    np.testing.assert_array_equal(estimate.state.mean, before.state.mean)
    _, one = mhe.step(state, RUN.measurements[10])
    _, other = mhe.step(after, RUN.measurements[10])
    np.testing.assert_array_equal(one.state.mean, other.state.mean)


@pytest.mark.parametrize(
    ("estimator", "threshold"), [("mhe-rti", 0.0), ("mhe-rti", 0.5), ("mhe", 0.0)]
)
def test_states_fork(threshold: float, estimator: str) -> None:
    """Whatever the engine did in between, a step says the same, to the last bit."""
    settings: dict[str, Any] = {"horizon": 6}
    settings |= {"reuse_threshold": threshold} if estimator == "mhe-rti" else {}
    mhe = real_time(estimator, MODEL, config_for(estimator, **settings))
    other = real_time(estimator, MODEL, config_for(estimator, **settings))
    state = mhe.init()
    for k, measurement in enumerate(STREAM[:30]):
        kept = state.memory.copy()
        other.step(other.init(), Measurement(-1.0, STREAM[3].y))  # its factors are none of these
        _, fresh = other.step(state, measurement)
        mhe.step(state, Measurement(between(0), STREAM[k].y + 1.0))
        following, estimate = mhe.step(state, measurement)
        _, again = mhe.step(state, measurement)
        np.testing.assert_array_equal(state.memory, kept)
        for one in (fresh, again):
            np.testing.assert_array_equal(one.state.mean, estimate.state.mean)
            np.testing.assert_array_equal(one.state.covariance, estimate.state.covariance)
            np.testing.assert_array_equal(one.innovation, estimate.innovation)
            np.testing.assert_array_equal(one.innovation_covariance, estimate.innovation_covariance)
        state = following
