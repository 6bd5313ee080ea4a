"""A deadline by a fake clock: every rung of the ladder is reached, and is what it says."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from estimation.estimate import Estimate
from estimation.kalman_stage import KalmanStage
from estimation.status import Status
from mhe.config import MheConfig
from mhe.realtime import Mhe, MheRti
from mhe.window_memory import WindowState
from models.gaussian import GaussianState
from tests.closeness import covariance_error, estimate_error, mean_error
from tests.configs import config_for
from tests.engines import compiled_and_interpreted, needs_compiler, steps
from tests.estimation import pens
from tests.mhe.windows import window_of
from tests.plain_filter import plain_filter

RUN = pens.draw_pen_run(12, seed=4)
MODEL = RUN.model
HORIZON = 5
either_engine = pytest.mark.usefixtures("engine")


class Ticking:
    """A clock that goes on by `tick` seconds whenever it is read."""

    def __init__(self, tick: float = 0.0) -> None:
        self.tick, self.time_s = tick, 100.0

    def __call__(self) -> float:
        self.time_s += self.tick
        return self.time_s


def timed(
    kind: type[Mhe] | type[MheRti],
    clock: Ticking,
    deadline_s: float = 1.0,
    reuse_threshold: float = 0.0,
) -> Mhe | MheRti:
    config = config_for(
        kind, horizon=HORIZON, deadline_s=deadline_s, reuse_threshold=reuse_threshold
    )
    return kind(MODEL, config, clock=clock)


def before_last(mhe: Mhe | MheRti, clock: Ticking) -> WindowState:
    """All steps but the last, with time to spare."""
    clock.tick = 1e-9
    state = mhe.init()
    for measurement in RUN.measurements[:-1]:
        state, _ = mhe.step(state, measurement)
    return state


def last_step(
    kind: type[Mhe] | type[MheRti], tick: float
) -> tuple[WindowState, Estimate, Mhe | MheRti]:
    """The last step, by a clock that then ticks in large steps."""
    clock = Ticking()
    mhe = timed(kind, clock)
    state = before_last(mhe, clock)
    clock.tick = tick
    state, estimate = mhe.step(state, RUN.measurements[-1])
    return state, estimate, mhe


def free(kind: type[Mhe] | type[MheRti], **settings: int) -> list[Estimate]:
    config = config_for(kind, horizon=HORIZON, reuse_threshold=0.0, **settings)
    return steps(kind(MODEL, config), RUN.measurements)


@pytest.mark.cover
@either_engine
@pytest.mark.parametrize("kind", [MheRti, Mhe])
def test_no_time_at_all_is_a_prediction(kind: type[Mhe] | type[MheRti]) -> None:
    _, estimate, mhe = last_step(kind, tick=2.0)
    *_, before = free(kind)[:-1]
    stage, dt = KalmanStage(MODEL), RUN.measurements[-1].time_s - before.time_s
    wanted = stage.predict(before.state, dt).state
    assert Status.PREDICTED in estimate.status
    assert not estimate.status.is_solved
    assert estimate.iterations == 0
    assert np.isnan(estimate.innovation).all()
    assert np.isnan(estimate.innovation_covariance).all()
    assert mean_error(mhe.model, estimate.state.mean, wanted) < 1e-8
    assert covariance_error(estimate.state.covariance, wanted.covariance) < 1e-8


@either_engine
def test_time_for_one_pass_is_one_pass() -> None:
    """What a limit of one pass returns, but for the status."""
    _, estimate, _ = last_step(Mhe, tick=0.3)
    clock = Ticking()
    config = MheConfig(horizon=HORIZON, deadline_s=1.0, max_iterations=300)
    limited = Mhe(MODEL, MheConfig(horizon=HORIZON, max_iterations=1))
    state = before_last(Mhe(MODEL, config, clock=clock), clock)
    _, wanted = limited.step(state, RUN.measurements[-1])
    assert estimate.status is Status.TIME_LIMIT
    assert estimate.iterations == wanted.iterations == 1
    assert estimate_error(MODEL, estimate, wanted) < 1e-9


@either_engine
def test_more_time_is_more_passes_until_converged() -> None:
    passes, statuses = [], []
    for tick in (0.3, 0.15, 0.08, 0.05, 0.03, 0.001):
        _, estimate, _ = last_step(Mhe, tick)
        passes.append(estimate.iterations)
        statuses.append(estimate.status)
    assert passes == sorted(passes)
    assert passes[0] == 1
    assert len(set(passes)) >= 3
    assert statuses[0] is Status.TIME_LIMIT
    assert statuses[-1] is Status.SOLVED
    *_, converged = free(Mhe)
    assert passes[-1] == converged.iterations


@either_engine
def test_one_pass_in_time_is_solved() -> None:
    _, estimate, _ = last_step(MheRti, tick=0.1)
    *_, wanted = free(MheRti)
    assert estimate.status is Status.SOLVED
    assert estimate_error(MODEL, estimate, wanted) < 1e-12


EVERYTHING_MOVES = 1e-9
TIME_FOR = {1: 2.75, 2: 3.0}
"""Stages whose factors there is time for → deadline in ticks, see mhe/interpreted/deadline.py."""


@either_engine
def test_time_for_the_newest_stage_only_is_the_ekf() -> None:
    """Older stages have all moved and keep their factors nevertheless."""
    estimates = steps(timed(MheRti, Ticking(1.0), TIME_FOR[1], EVERYTHING_MOVES), RUN.measurements)
    plain = plain_filter(MODEL, RUN.measurements)
    for k, (a, b) in enumerate(zip(estimates, plain, strict=True)):
        assert mean_error(MODEL, a.state.mean, b) < 1e-8
        assert covariance_error(a.state.covariance, b.covariance) < 1e-8
        assert a.status is (Status.TIME_LIMIT if k else Status.SOLVED)


@either_engine
def test_time_for_some_stages_makes_the_factors_of_some() -> None:
    mhe = timed(MheRti, Ticking(1.0), TIME_FOR[2], EVERYTHING_MOVES)
    state = mhe.init()
    for k, measurement in enumerate(RUN.measurements):
        state, estimate = mhe.step(state, measurement)
        window = window_of(mhe, state)
        assert len(window.times) - window.stayed == (1 if k == 0 else 2)
        assert estimate.status is (Status.TIME_LIMIT if k > 1 else Status.SOLVED)
    again = timed(MheRti, Ticking(1e-9), 1.0, EVERYTHING_MOVES)
    assert all(e.status is Status.SOLVED for e in steps(again, RUN.measurements))


@either_engine
@pytest.mark.parametrize("kind", [MheRti, Mhe])
def test_a_prediction_loses_no_reading(kind: type[Mhe] | type[MheRti]) -> None:
    """The next step that has time uses the readings that the last had no time for."""
    clock = Ticking()
    mhe, state, estimates = timed(kind, clock), None, []
    state = mhe.init()
    for k, measurement in enumerate(RUN.measurements):
        clock.tick = 2.0 if k in (3, 6, 7) else 1e-9
        state, estimate = mhe.step(state, measurement)
        estimates.append(estimate)
        # time is there again at once: what passes take was measured in time
        assert (Status.PREDICTED in estimate.status) == (k in (3, 6, 7))
    if kind is Mhe:  # converged, it does not matter where it began
        for k in (4, 8, 11):
            assert mean_error(MODEL, estimates[k].state.mean, free(kind)[k].state) < 1e-2


@either_engine
def test_the_first_step_may_be_a_prediction_too() -> None:
    clock = Ticking(2.0)
    _, estimate = timed(MheRti, clock).step(timed(MheRti, clock).init(), RUN.measurements[0])
    prior = MODEL.prior
    assert Status.PREDICTED in estimate.status
    assert mean_error(MODEL, estimate.state.mean, prior) == 0
    np.testing.assert_array_equal(estimate.state.covariance, prior.covariance)


@either_engine
def test_slow_passes_are_expected_and_forgotten_again() -> None:
    """Passes that take longer than there is time for are not begun; later they are tried."""
    clock = Ticking()
    mhe, state, rungs = timed(MheRti, clock, 1.0), None, []
    state, time_s = mhe.init(), 0.0
    for k in range(120):
        time_s += 0.01
        clock.tick = 0.6 if 20 <= k < 40 else 1e-9  # a pass then takes 0.6 s between two readings
        measurement = type(RUN.measurements[0])(time_s, RUN.measurements[k % 12].y)
        state, estimate = mhe.step(state, measurement)
        rungs.append(Status.PREDICTED in estimate.status)
    assert not any(rungs[:20])
    assert any(rungs[20:40])
    assert not any(rungs[100:])


@needs_compiler
def test_both_engines_stand_on_the_same_rung() -> None:
    """They read the clock equally often."""
    for kind, tick in itertools.product((Mhe, MheRti), (0.4, 0.35, 0.3, 0.1, 0.04, 0.01)):
        clocks = iter([Ticking(tick), Ticking(tick)])
        machine, plain = compiled_and_interpreted(
            lambda clocks=clocks, kind=kind: timed(kind, next(clocks), 1.0, 0.05)  # type: ignore[misc]
        )
        for a, b in zip(
            steps(machine, RUN.measurements), steps(plain, RUN.measurements), strict=True
        ):
            assert (a.status, a.iterations) == (b.status, b.iterations)
            assert estimate_error(MODEL, a, b) < 1e-9


@either_engine
def test_a_gaussian_is_what_a_prediction_returns() -> None:
    _, estimate, _ = last_step(MheRti, tick=2.0)
    assert isinstance(estimate.state, GaussianState)
    assert np.linalg.eigvalsh(estimate.state.covariance).min() > 0
