"""A late reading becomes a stage of the window at its capture."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from estimation.estimator import run_measurements
from estimation.kalman_stage import rows_present
from estimation.recording import Measurement
from estimation.status import Status
from mhe import constraint_rows
from mhe.config import MheConfig, MheRtiConfig
from mhe.interpreted.window_pass import WindowPass
from mhe.realtime import Mhe, MheRti
from mhe.trajectory import Trajectory
from mhe.window_memory import Scales, View, packed_window, window_memory
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel
from tests.closeness import mean_error
from tests.configs import config_for
from tests.estimation import pens
from tests.mhe.late_streams import in_order, is_late, late_stream
from tests.mhe.runs import ESTIMATORS
from tests.mhe.test_deadline import Ticking
from tests.mhe.windows import real_time, window_of

RUN = pens.draw_pen_run(40, seed=8)
MODEL = RUN.model
STREAM = late_stream(MODEL, RUN.measurements, np.random.default_rng(3))
either_engine = pytest.mark.usefixtures("engine")


@pytest.fixture(params=["compiled", "interpreted"])
def engine(request: pytest.FixtureRequest) -> None:
    """One engine, then the other."""
    if request.param == "interpreted":
        request.getfixturevalue("interpreted")


def stages_of(window: View, arrived: list[Measurement]) -> tuple[Measurement, ...]:
    """The window's readings in order of capture."""
    return tuple(in_order(arrived, MODEL.n_y)[-len(window.times) :])


def ready(estimator: str, n: int = 10, **settings: Any) -> tuple[Any, Any, Any]:
    """An estimator after n samples that were all on time, its state and last estimate."""
    mhe = ESTIMATORS[estimator](MODEL, config_for(estimator, **{"horizon": 6, **settings}))
    state, estimate = mhe.init(), None
    for measurement in RUN.measurements[:n]:
        state, estimate = mhe.step(state, measurement)
    return mhe, state, estimate


def between(k: int, share: float = 0.4) -> float:
    """An instant between two samples."""
    before, behind = RUN.measurements[k].time_s, RUN.measurements[k + 1].time_s
    return before + share * (behind - before)


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
