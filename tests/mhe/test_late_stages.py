"""Stages of one instant, lags and passes of a window that a late reading comes into."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from estimation.estimator import run_measurements
from estimation.recording import Measurement
from estimation.status import Status
from mhe import constraint_rows
from mhe.config import MheConfig, MheRtiConfig
from mhe.realtime import Mhe, MheRti
from models.state_space import StateSpaceModel
from tests.closeness import mean_error
from tests.configs import config_for
from tests.mhe.late_pen import MODEL, RUN, between, either_engine, ready
from tests.mhe.late_streams import in_order
from tests.mhe.test_deadline import Ticking
from tests.mhe.windows import window_of


@either_engine
@pytest.mark.parametrize("kind", [MheRti, Mhe])
def test_without_time_it_is_in_the_window(kind: type[Mhe] | type[MheRti]) -> None:
    """And used by the next step that has time; meanwhile the last estimate stays."""
    clock = Ticking(1e-9)
    config = config_for(kind, horizon=6, deadline_s=1.0, reuse_threshold=0.0)
    mhe = kind(MODEL, config, clock=clock)
    state, late = mhe.init(), Measurement(between(6), RUN.measurements[7].y)
    for m in RUN.measurements[:10]:
        state, before = mhe.step(state, m)
    clock.tick = 2.0
    hurried, estimate = mhe.step(state, late)
    assert estimate.status is Status.PREDICTED
    assert estimate.iterations == 0
    assert estimate.time_s == before.time_s
    assert np.isnan(estimate.innovation).all()
    np.testing.assert_array_equal(estimate.state.mean, before.state.mean)
    np.testing.assert_array_equal(estimate.state.covariance, before.state.covariance)
    assert estimate.window is not None
    assert between(6) in estimate.window.time_s
    clock.tick = 1e-9
    calm, _ = mhe.step(state, late)
    _, one = mhe.step(hurried, RUN.measurements[10])
    _, other = mhe.step(calm, RUN.measurements[10])
    assert one.status is other.status
    assert mean_error(MODEL, one.state.mean, other.state) < (1e-2 if kind is Mhe else 0.5)


def test_stages_in_front_keep_their_factors() -> None:
    config = MheRtiConfig(horizon=10, reuse_threshold=np.inf)
    mhe, measurements = MheRti(MODEL, config), RUN.measurements
    state = mhe.init()
    for m in measurements[:14]:
        state, _ = mhe.step(state, m)
    at = 10
    state, estimate = mhe.step(state, Measurement(between(at), measurements[at].y))
    assert estimate.window is not None
    assert estimate.reused_stages == int(np.searchsorted(estimate.window.time_s, between(at)))
    state, estimate = mhe.step(state, measurements[14])
    assert estimate.reused_stages == 10


@either_engine
@pytest.mark.parametrize("kind", [MheRti, Mhe])
def test_a_step_without_time_leaves_its_points_to_the_next(kind: type[Mhe] | type[MheRti]) -> None:
    """Less time than half a pass takes: the newest stage has no factors, whatever stood there."""
    clock = Ticking(0.9)
    config = config_for(kind, horizon=5, deadline_s=1.0, reuse_threshold=0.05)
    mhe, seen = kind(MODEL, config, clock=clock), 0
    state = mhe.init()
    for m in RUN.measurements[:12]:
        state, estimate = mhe.step(state, m)
        window = window_of(mhe, state)
        assert window.stayed < len(window.times)
        if Status.PREDICTED in estimate.status:
            assert window.moved[-1] == np.inf
            np.testing.assert_array_equal(window.x_lin[-1], window.x[-1])
            seen += 1
    assert seen > 8


def test_lags_count_stages() -> None:
    mhe, state, before = ready("mhe-rti", lag_samples=(2, 3))
    assert [e.time_s for e in before.lagged] == [RUN.measurements[k].time_s for k in (7, 6)]
    _, estimate = mhe.step(state, Measurement(between(7), RUN.measurements[7].y))
    assert [e.time_s for e in estimate.lagged] == [between(7), RUN.measurements[7].time_s]
    _, late = mhe.step(state, Measurement(RUN.measurements[2].time_s, RUN.measurements[7].y))
    assert late.lagged == ()


def test_a_lag_speaks_of_an_instant_again_where_an_older_reading_comes() -> None:
    """Both rows stay: the second knows more. Counted once it is the first."""
    mhe = MheRti(MODEL, MheRtiConfig(horizon=6, lag_samples=2))
    late = Measurement(between(6), RUN.measurements[7].y)
    history = run_measurements(mhe, [*RUN.measurements[:10], late, *RUN.measurements[10:12]])
    told = history.at_lag(2)
    times = [m.time_s for m in RUN.measurements[:10]]
    np.testing.assert_array_equal(told.time_s, [*times[:8], times[7], *times[8:10]])
    assert (told.std[8] < told.std[7]).any()
    once = told.first_told()
    np.testing.assert_array_equal(once.time_s, times)
    np.testing.assert_array_equal(once.mean[7], told.mean[7])


@either_engine
def test_first_readings_that_are_late_get_passes_until_they_settle() -> None:
    """One from the prior is not near the optimum; the next late ones get one, as any sample."""
    config, first = MheRtiConfig(horizon=6), np.arange(MODEL.n_y) < 3
    clock = Ticking(1e-9)
    mhe = MheRti(MODEL, replace(config, deadline_s=1.0), clock=clock)
    state = mhe.init()
    for m in RUN.measurements[:4]:
        state, estimate = mhe.step(state, replace(m, y=np.where(first, np.nan, m.y)))
        assert estimate.iterations == 1
    late = Measurement(between(0), np.where(first, RUN.measurements[0].y, np.nan))
    after, estimate = mhe.step(state, late)
    assert estimate.status is Status.SOLVED
    assert estimate.iterations > 2
    assert estimate.kkt_residual < 1e-3
    solved, _ = Mhe(MODEL, MheConfig(horizon=6)).step(state, late)
    assert mean_error(MODEL, estimate.state.mean, window_of(mhe, solved).newest) < 1e-3
    _, next_late = mhe.step(after, replace(late, time_s=between(1)))
    assert next_late.iterations == 1
    clock.tick = 0.2
    _, hurried = mhe.step(state, late)
    assert hurried.iterations < estimate.iterations
    assert Status.TIME_LIMIT in hurried.status


def demanding() -> StateSpaceModel:
    """A row of which the first reading decides whether it is demanded."""
    return MODEL.constrained(lambda x: x[2] - 10.0, MODEL.reading_names[:1])


@pytest.mark.cover
@either_engine
@pytest.mark.parametrize("late_first", [True, False])
def test_rows_are_demanded_where_their_readings_are(late_first: bool) -> None:
    model, first = demanding(), np.arange(MODEL.n_y) < 3
    mhe = MheRti(model, MheRtiConfig(horizon=6))
    state = mhe.init()
    for k, m in enumerate(RUN.measurements[:10]):
        y = np.where(first != late_first, m.y, np.nan) if k == 7 else m.y
        state, _ = mhe.step(state, replace(m, y=y))
    at_first = window_of(mhe, state)
    late = Measurement(
        RUN.measurements[7].time_s, np.where(first == late_first, RUN.measurements[7].y, np.nan)
    )
    state, _ = mhe.step(state, late)
    without = Measurement(between(7), np.where(first, np.nan, RUN.measurements[7].y))
    last, _ = mhe.step(state, without)
    joined, between_two = window_of(mhe, state), window_of(mhe, last)
    rows = in_order([*RUN.measurements[:10], without], model.n_y)[-7:]
    wanted = [float(constraint_rows.demanded(model, m.y)[0]) for m in rows]
    assert between_two.demanded[:, 0].tolist() == wanted
    assert joined.demanded[4, 0] == 1
    assert at_first.demanded[4, 0] == (0 if late_first else 1)
