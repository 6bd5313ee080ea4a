"""The windows of a problem: what they promise to the contenders."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from benchmark.bodies import BODIES
from estimation.kalman_stage import KalmanStage
from mhe.config import MheIpoptConfig
from mhe.reference.ipopt import MheIpopt
from mhe.reference.state import MheState
from models.errors import InputError
from models.gaussian import GaussianState
from models.units import split_unit
from pen_mhe.estimators import create_estimator
from suites.speed.cost import WindowCost
from suites.speed.held_rows import HeldRows
from suites.speed.problems import DURATION_S, PROBLEMS, Problem, find_problem
from suites.speed.races import WARM_UP
from suites.speed.windows import SETTLED, STRIDE, TOLERANCE, SolvedWindow, recorded, solved_windows

FREE = (Problem("turntable", 20, 2), Problem("pen15", 8, 2), Problem("pen24", 8, 2))
BOUNDED = tuple(replace(problem, bounded=True) for problem in FREE)
CASES = (*FREE, *BOUNDED)


def marked(problems: Sequence[Problem]) -> list[Any]:
    """Cases of a test; pen24 with bounds is slow, as it is in the race."""
    return [
        pytest.param(
            problem,
            marks=pytest.mark.slow if problem.key == "pen24_8_bounded" else (),
            id=problem.key,
        )
        for problem in problems
    ]


@pytest.fixture(scope="module", params=marked(CASES))
def case(request: pytest.FixtureRequest) -> tuple[Problem, list[SolvedWindow]]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("estimation.native.compiler", lambda: None)
        return request.param, solved_windows(request.param, 2)


Case = tuple[Problem, list[SolvedWindow]]


def test_the_problems_are_those_of_the_suite() -> None:
    sizes = {name: body().model().n_x for name, body in BODIES.items()}
    assert sizes == {"turntable": 4, "pen15": 15, "pen24": 24}
    rows = {name: body().model().n_r for name, body in BODIES.items()}
    assert rows == {"turntable": 5, "pen15": 5, "pen24": 12}
    free = ["turntable_20", "pen15_20", "pen15_100", "pen15_500", "pen24_20", "pen24_60"]
    expected = [*free, *(f"{key}_bounded" for key in free)]
    assert [problem.key for problem in PROBLEMS] == expected
    assert [find_problem(key).bounded for key in expected] == [False] * 6 + [True] * 6
    with pytest.raises(InputError, match="problem pen15_7 is unknown, expected one of turntable"):
        find_problem("pen15_7")


def test_bounds_are_those_of_the_body_and_nothing_else_changes() -> None:
    for name in BODIES:
        free = Problem(name, 20, 1)
        bounded = replace(free, bounded=True)
        for limit, infinite in (("lower", -np.inf), ("upper", np.inf)):
            limits = getattr(bounded.model, limit)
            assert (getattr(free.model, limit) == infinite).all()
            names = np.array(bounded.model.state_names)[np.isfinite(limits)]
            assert set(names) <= set(free.body.bounds)
        assert (np.isfinite(bounded.model.lower) | np.isfinite(bounded.model.upper)).any()
        readings = [[m.y for m in recorded(p, p.model, 80)] for p in (free, bounded)]
        np.testing.assert_array_equal(*readings)


def last_stage(problem: Problem) -> int:
    return SETTLED + STRIDE * (WARM_UP + problem.windows - 1) + problem.horizon


@pytest.mark.parametrize("name", ["turntable", "pen15"])
def test_the_true_motion_of_all_windows_obeys_the_bounds(name: str) -> None:
    """What is simulated moves as the bounds say; only the raised paper of `pen24` does not."""
    suite = [problem for problem in PROBLEMS if problem.name == name and problem.bounded]
    problem = max(suite, key=last_stage)
    model, truth = problem.model, problem.body.record(DURATION_S, problem.seed).truth
    assert truth is not None
    states = truth.states(model.state_names, truth.time_s)[: last_stage(problem) + 1]
    rounding = 1e-12
    assert (states >= model.lower - rounding).all()
    assert (states <= model.upper + rounding).all()


def share_of_windows_with_several_active_stages(problem: Problem) -> float:
    solved = solved_windows(problem, WARM_UP + problem.windows)[WARM_UP:]
    held, stages = HeldRows(problem.model), []
    for each in solved:
        states, window = each.optimum.trajectory.states, each.window
        active = held.active(window.measurements, states, window.scale)
        stages.append(active.any(axis=1).sum())
        assert held.violation(window, states) < 1e-6
    return float(np.mean(np.array(stages) >= 2))


@pytest.mark.parametrize(
    ("key", "windows"), [("turntable_20", 20), pytest.param("pen15_20", 10, marks=pytest.mark.slow)]
)
def test_bounds_are_active_at_several_stages_of_most_windows(
    key: str, windows: int, interpreted: None
) -> None:
    problem = replace(find_problem(f"{key}_bounded"), windows=windows)
    assert share_of_windows_with_several_active_stages(problem) > 0.5


@pytest.mark.slow
@pytest.mark.parametrize(
    "problem",
    [problem for problem in PROBLEMS if problem.bounded],
    ids=lambda problem: problem.key,
)
def test_bounds_are_active_in_the_whole_suite(problem: Problem) -> None:
    assert share_of_windows_with_several_active_stages(problem) > 0.5


def test_shapes_and_missing_rows(case: Case) -> None:
    problem, solved = case
    N = problem.horizon
    for each in solved:
        window, model = each.window, each.window.model
        assert len(window.measurements) == len(window.previous.measurements) == N + 1
        assert window.guess.states.shape == (N + 1, model.n_x)
        assert window.guess.noises.shape == (N, model.n_w)
        assert np.isfinite(window.y).all()
        # A camera at 30 Hz beside 100 Hz: one in three instants, and instants of its own.
        assert window.present.all() == (problem.name != "pen24")
        assert window.previous.measurements[1:] == window.measurements[:-1]
        factor = window.prior_factor
        scale = np.outer(window.prior.std, window.prior.std)
        product = factor @ factor.T / scale
        np.testing.assert_allclose(product, window.prior.covariance / scale, rtol=0, atol=1e-12)
        inverse = window.prior_factor_inverse
        np.testing.assert_allclose(inverse @ factor, np.eye(model.n_x), rtol=0, atol=1e-9)


def test_a_longer_table_begins_with_the_shorter(interpreted: None) -> None:
    problem = CASES[0]
    one, two = solved_windows(problem, 1), solved_windows(problem, 2)
    np.testing.assert_array_equal(one[0].window.guess.states, two[0].window.guess.states)
    assert one[0].optimum.cost == two[0].optimum.cost


def test_a_recording_is_long_enough_for_the_suite() -> None:
    for problem in PROBLEMS:
        count = last_stage(problem) + 1
        assert len(recorded(problem, problem.model, count)) == count
    with pytest.raises(InputError, match="problem turntable_20 asks for 9999 stages"):
        recorded(CASES[0], CASES[0].model, 9999)


@pytest.mark.parametrize("problem", FREE, ids=lambda problem: problem.key)
def test_the_prior_before_is_what_an_ekf_carries(problem: Problem, interpreted: None) -> None:
    """One whose first update, too, is linearised at its prior."""
    solved = solved_windows(problem, 2)
    model = solved[0].window.model
    stage, carried = KalmanStage(model), model.prior
    measurements = recorded(problem, model, SETTLED + STRIDE)
    for measurement, behind in itertools.pairwise(measurements):
        updated = stage.update(carried, measurement.y).state
        carried = stage.predict(updated, behind.time_s - measurement.time_s).state
    prior = solved[1].window.previous.prior
    assert np.abs((prior.mean - carried.mean) / carried.std).max() < 1e-9
    np.testing.assert_allclose(prior.std, carried.std, rtol=1e-9)


def test_the_prior_is_what_a_moving_horizon_carries(case: Case, interpreted: None) -> None:
    """Also with bounds, whose optimum may lie far from what the EKF, without them, says."""
    problem, solved = case
    mhe = create_estimator(
        "mhe-ipopt",
        solved[0].window.model,
        horizon=problem.horizon,
    )
    for each in solved:
        before = each.window.previous
        states = before.trajectory.states
        newest = GaussianState(states[-1], before.prior.covariance)
        state = MheState(
            before.prior, before.measurements, tuple(states), before.trajectory, newest
        )
        after, _ = mhe.step(state, each.window.measurements[-1])
        carried, prior = after.prior, each.window.prior
        assert np.abs((prior.mean - carried.mean) / carried.std).max() < 1e-9
        np.testing.assert_allclose(prior.covariance, carried.covariance, rtol=1e-9)


def test_the_warm_start_is_the_window_before_shifted(case: Case) -> None:
    _, solved = case
    for each in solved:
        window, before = each.window, each.window.previous.trajectory
        model, guess = window.model, window.guess
        away = model.difference(guess.states[:-1].T, before.states[1:].T).full()
        np.testing.assert_allclose(away, 0, rtol=0, atol=1e-12)
        np.testing.assert_array_equal(guess.noises[:-1], before.noises[1:])
        np.testing.assert_array_equal(guess.noises[-1], 0)
        newest = model.f(guess.states[-2], 0, window.dt[-1]).full().ravel()
        np.testing.assert_allclose(guess.states[-1], newest, rtol=0, atol=1e-12)


def test_angles_run_on_without_a_wrap(case: Case) -> None:
    _, solved = case
    for each in solved:
        angles = [split_unit(name)[1] == "rad" for name in each.window.model.state_names]
        assert any(angles) == (each.window.model.tangent is None)
        path = np.vstack([each.window.prior.mean, each.window.guess.states])[:, angles]
        assert np.abs(np.diff(path, axis=0)).max(initial=0) < np.pi / 2


def test_the_cost_is_the_references(case: Case) -> None:
    """Two formulations of the same number: rolled out, and by the window's own NLP."""
    problem, solved = case
    cost = WindowCost(solved[0].window.model, problem.horizon)
    for each in solved:
        found = each.optimum.trajectory
        here = cost(each.window, found.states[0], found.noises)
        assert abs(here - each.optimum.cost) <= 1e-9 * max(1.0, each.optimum.cost)


@pytest.mark.parametrize("problem", FREE, ids=lambda problem: problem.key)
def test_no_direction_leads_below_the_optimum(problem: Problem, interpreted: None) -> None:
    """First order: a step up and the same down change the cost alike."""
    solved = solved_windows(problem, 1)
    window, found = solved[0].window, solved[0].optimum.trajectory
    cost = WindowCost(window.model, problem.horizon)
    rng = np.random.default_rng(1)
    best = cost(window, found.states[0], found.noises)
    for _ in range(5):
        x = 1e-4 * window.prior_factor @ rng.standard_normal(window.model.n_x)
        w = 1e-4 * rng.standard_normal(found.noises.shape)
        up = cost(window, found.states[0] + x, found.noises + w) - best
        down = cost(window, found.states[0] - x, found.noises - w) - best
        assert up > 0
        assert down > 0
        assert abs(up - down) < 0.02 * (up + down)


@pytest.mark.parametrize("problem", marked(BOUNDED))
def test_a_step_below_a_bounded_optimum_leaves_the_bounds(
    problem: Problem, interpreted: None
) -> None:
    """The window's free optimum costs less; the way there leads through a bound at once."""
    (each,) = solved_windows(replace(problem, windows=1), 1)
    window, found, free = each.window, each.optimum.trajectory, replace(problem, bounded=False)
    config = MheIpoptConfig(horizon=problem.horizon, tolerance=TOLERANCE)
    lower = MheIpopt(free.model, config).solve(window.prior, window.measurements, window.guess)
    held, cost = HeldRows(window.model), WindowCost(window.model, problem.horizon)
    start = found.states[0] + 1e-3 * (lower.trajectory.states[0] - found.states[0])
    noises = found.noises + 1e-3 * (lower.trajectory.noises - found.noises)
    down = each.optimum.cost - cost(window, start, noises)
    assert down > 0
    assert lower.cost < each.optimum.cost
    left = held.violation(window, cost.states(window, start, noises))
    assert left > 10 * held.violation(window, found.states)
