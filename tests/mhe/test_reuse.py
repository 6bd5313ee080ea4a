"""Factors that stay when the window slides change nothing but the time it takes."""

from __future__ import annotations

import math

import numpy as np
import pytest

from estimation.recording import Measurement
from mhe.config import MheConfig, MheRtiConfig
from mhe.realtime import Mhe, MheRti
from mhe.reuse import SETTLED, reuse_threshold
from models.pen import pen_model
from models.pen_file import load_pen
from models.turntable import paper_turntable, turntable_model
from tests.closeness import covariance_error, estimate_error, mean_error
from tests.engines import compiled_and_interpreted, needs_compiler, steps
from tests.estimation import pens
from tests.linear_models import coupled_system, irregular_times, random_walk_system
from tests.mhe import pendulum
from tests.mhe.windows import window_of
from tests.plain_filter import plain_filter

RUN = pens.draw_pen_run(40, seed=8)
NEVER_AGAIN = math.inf
THRESHOLDS = (0.1, 0.5, 2.0, NEVER_AGAIN)


def rti(threshold: float, horizon: int = 6, arrival_cost: str = "filtered") -> MheRti:
    config = MheRtiConfig(horizon=horizon, arrival_cost=arrival_cost, reuse_threshold=threshold)
    return MheRti(RUN.model, config)


def settled_pen(n: int, step_s: float = 0.01) -> list[Measurement]:
    """A pen that is known well and moves as the model has it: estimates move little."""
    run = pens.draw_pen_run(n, seed=3)
    return [Measurement(k * step_s, m.y) for k, m in enumerate(run.measurements)]


@pytest.mark.parametrize("horizon", [1, 3, 20])
def test_stages_that_never_move_are_the_ekf(horizon: int) -> None:
    """With a linear transition: every update linearised once, at its prediction."""
    mhe = steps(rti(NEVER_AGAIN, horizon), RUN.measurements)
    plain = plain_filter(RUN.model, RUN.measurements)
    for k, (a, b) in enumerate(zip(mhe, plain, strict=True)):
        assert mean_error(RUN.model, a.state.mean, b) < 1e-8
        assert covariance_error(a.state.covariance, b.covariance) < 1e-8
        assert a.reused_stages == min(k, horizon)


def test_full_passes_are_not_the_ekf() -> None:
    """So the test above can fail."""
    mhe, plain = steps(rti(0.0), RUN.measurements), plain_filter(RUN.model, RUN.measurements)
    errors = [mean_error(RUN.model, a.state.mean, b) for a, b in zip(mhe, plain, strict=True)]
    assert max(errors) > 1e-2
    assert all(estimate.reused_stages == 0 for estimate in mhe)


@pytest.mark.parametrize("threshold", THRESHOLDS)
def test_factors_are_those_that_would_be_made(threshold: float) -> None:
    """An engine without memory of the step before says the same, to the last bit."""
    one, memory = rti(threshold), rti(threshold)
    state = one.init()
    for measurement in RUN.measurements:
        _, fresh = rti_step_from(memory, state, measurement)
        state, kept = one.step(state, measurement)
        assert fresh.reused_stages == 0
        np.testing.assert_array_equal(kept.state.mean, fresh.state.mean)
        np.testing.assert_array_equal(kept.state.covariance, fresh.state.covariance)
        assert kept.window is not None
        assert fresh.window is not None
        np.testing.assert_array_equal(kept.window.states, fresh.window.states)


def test_factors_of_other_times_are_not_taken() -> None:
    """A random walk is predicted where it is: windows of the same readings differ in time."""
    model = random_walk_system(1, q=1.0, r=1.0, p0=1.0).model
    mhe, fresh = (
        MheRti(model, MheRtiConfig(horizon=4, reuse_threshold=NEVER_AGAIN)) for _ in range(2)
    )
    readings = np.array([[1.0], [2.0], [3.0]])
    before, after = (
        [Measurement(float(t), y) for t, y in zip(times, readings, strict=True)]
        for times in ((0, 1, 2), (0, 5, 6))
    )
    state = mhe.init()
    for measurement in after[:2]:
        state, _ = mhe.step(state, measurement)
    steps(mhe, before)
    _, estimate = mhe.step(state, after[2])
    assert estimate.reused_stages == 1
    wanted = steps(fresh, after)[-1]
    np.testing.assert_array_equal(estimate.state.mean, wanted.state.mean)
    np.testing.assert_array_equal(estimate.state.covariance, wanted.state.covariance)


def rti_step_from(mhe: MheRti, state, measurement):  # type: ignore[no-untyped-def]
    """Step after another run, whose factors are none of this window's."""
    mhe.step(mhe.init(), Measurement(-1.0, RUN.measurements[3].y))
    return mhe.step(state, measurement)


@pytest.mark.cover
@needs_compiler
@pytest.mark.parametrize("arrival_cost", ["filtered", "smoothed"])
@pytest.mark.parametrize("threshold", THRESHOLDS)
def test_both_engines_choose_the_same_stages(threshold: float, arrival_cost: str) -> None:
    machine, plain = compiled_and_interpreted(lambda: rti(threshold, 6, arrival_cost))
    reused = 0
    for a, b in zip(steps(machine, RUN.measurements), steps(plain, RUN.measurements), strict=True):
        assert estimate_error(RUN.model, a, b) < 1e-10
        assert a.window is not None
        assert b.window is not None
        np.testing.assert_allclose(a.window.states, b.window.states, rtol=1e-9, atol=1e-9)
        assert a.kkt_residual == pytest.approx(b.kkt_residual, rel=1e-6, abs=1e-9)
        reused += a.reused_stages
    assert reused > 0


def off(x_lin: np.ndarray, x: np.ndarray, y: np.ndarray) -> float:
    """By how many standard deviations a linearisation is off at x: slope by differences."""
    model, worst = RUN.model, 0.0
    delta, h = np.asarray(model.difference(x, x_lin)).ravel(), 1e-5
    for sensor, rows in zip(
        model.sensors, np.split(y, np.cumsum(sensor_widths())[:-1]), strict=True
    ):
        if np.isnan(rows).any():
            continue
        at = [
            np.asarray(sensor.residual(rows, model.retract(x_lin, s * delta))).ravel()
            for s in (-h, 0.0, h, 1.0)
        ]
        expected = at[1] + (at[2] - at[0]) / (2 * h)
        worst = max(worst, float(np.abs((at[3] - expected) / sensor.noise_std).max()))
    return worst


def sensor_widths() -> list[int]:
    return [sensor.n_y for sensor in RUN.model.sensors]


@pytest.mark.parametrize("engine", ["compiled", "interpreted"])
def test_readings_of_stages_that_stay_are_predicted_by_their_factors(
    engine: str, request: pytest.FixtureRequest
) -> None:
    if engine == "interpreted":
        request.getfixturevalue("interpreted")
    run, threshold = pens.draw_pen_run(40, seed=9), 2.0  # wide enough for the first measure
    mhe, measured = rti(threshold, 10), {m.time_s: m.y for m in run.measurements}
    state, before, renewed = mhe.init(), None, 0
    for measurement in run.measurements:
        state, _ = mhe.step(state, measurement)
        window = window_of(mhe, state)
        if before is not None:
            stayed = set(window.times[: int(window.stayed)])
            for time_s, *points in zip(before.times, before.x_lin, before.x, strict=True):
                is_off = off(*points, measured[time_s]) > 1.01 * threshold
                assert not (is_off and time_s in stayed)
                renewed += is_off
        before = window
    assert renewed > 0


@pytest.mark.parametrize("threshold", THRESHOLDS)
def test_a_linear_model_is_solved_exactly(threshold: float) -> None:
    system, rng = coupled_system(3), np.random.default_rng(4)
    measurements = system.simulate(irregular_times(40, rng), rng, missing=0.3)
    config = MheRtiConfig(horizon=5, reuse_threshold=threshold)
    estimates = steps(MheRti(system.model, config), measurements)
    for estimate, wanted in zip(estimates, system.textbook(measurements), strict=True):
        std = np.sqrt(np.diag(wanted.covariance))
        assert np.abs((estimate.state.mean - wanted.mean) / std).max() < 1e-10
    assert sum(estimate.reused_stages for estimate in estimates) > 20


@pytest.mark.parametrize("threshold", [0.1, 0.5, 2.0])
def test_stages_without_news_are_near_the_smoother(threshold: float) -> None:
    """The pass back ends early: what it leaves is off by less than a share of the threshold.

    Distances are those of the filter's covariance at each stage.
    """
    system, rng = coupled_system(5), np.random.default_rng(6)
    measurements = system.simulate(irregular_times(60, rng), rng, missing=0.3)
    filtered = system.textbook(measurements)
    kept = steps(
        MheRti(system.model, MheRtiConfig(horizon=15, reuse_threshold=threshold)), measurements
    )
    smoothed = steps(Mhe(system.model, MheConfig(horizon=15)), measurements)
    distances = []
    for n, (a, b) in enumerate(zip(kept, smoothed, strict=True), start=1):
        assert a.window is not None
        assert b.window is not None
        stages = filtered[n - len(a.window.states) : n]
        for away, stage in zip(a.window.states - b.window.states, stages, strict=True):
            distances.append(np.sqrt(away @ np.linalg.solve(stage.covariance, away)))
    assert 1e-3 * threshold < max(distances) < SETTLED * threshold


@pytest.mark.parametrize(
    "settings",
    [{"arrival_cost": "constant"}, {"arrival_cost": "none"}, {"sparse_noise": 1.0}],
)
def test_where_factors_cannot_stay_all_passes_are_full(settings: dict[str, object]) -> None:
    measurements = pendulum.simulate(20, seed=1)
    config = MheRtiConfig(horizon=4, reuse_threshold=NEVER_AGAIN, **settings)  # type: ignore[arg-type]
    full = MheRtiConfig(horizon=4, reuse_threshold=0.0, **settings)  # type: ignore[arg-type]
    both = (steps(MheRti(pendulum.model(), c), measurements) for c in (config, full))
    for a, b in zip(*both, strict=True):
        np.testing.assert_array_equal(a.state.mean, b.state.mean)
        assert a.reused_stages == 0


def test_a_bad_start_is_linearised_again() -> None:
    """Stages that move are not kept: the default ends where full passes end, an EKF does not."""
    far, model = pens.draw_pen_run(25, seed=5), RUN.model
    full, kept, never = (steps(rti(t, 24), far.measurements)[-1] for t in (0.0, 0.5, NEVER_AGAIN))
    error = {
        name: mean_error(model, estimate.state.mean, full.state)
        for name, estimate in (("kept", kept), ("never", never))
    }
    assert error["kept"] < 0.2 * error["never"]


def test_without_a_threshold_the_model_decides() -> None:
    """Factors stay where sensors hold all states, else an estimate follows its linearisation."""
    pen = load_pen("reference")
    choices = {
        ("accel", "gyro", "camera"): True,
        ("camera",): True,
        ("accel", "gyro"): False,
        ("accel", "gyro", "contact"): False,
    }
    for sensors, stays in choices.items():
        model = pen_model(pen, sensors)
        assert (reuse_threshold(model, MheRtiConfig()) > 0) == stays, sensors
        assert reuse_threshold(model, MheRtiConfig(reuse_threshold=0.3)) == 0.3
    bare = pen_model(pen, ("accel", "gyro"), writing_area=False)
    assert reuse_threshold(bare, MheRtiConfig()) == 0
    assert reuse_threshold(turntable_model(paper_turntable()), MheRtiConfig()) > 0
