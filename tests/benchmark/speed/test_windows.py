"""The windows of a problem: what they promise to the contenders."""

from __future__ import annotations

import numpy as np
import pytest

from benchmark.registry import create_estimator
from benchmark.speed.cost import WindowCost
from benchmark.speed.problems import BODIES, PROBLEMS, Problem, find_problem
from benchmark.speed.suite import WARM_UP
from benchmark.speed.windows import SETTLED, STRIDE, SolvedWindow, recorded, solved_windows
from estimation.recording import Measurement
from models.errors import InputError
from models.units import split_unit

CASES = (Problem("turntable", 20, 2), Problem("pen15", 8, 2), Problem("pen24", 8, 2))


@pytest.fixture(scope="module", params=CASES, ids=lambda problem: problem.key)
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
    expected = ["turntable_20", "pen15_20", "pen15_100", "pen15_500", "pen24_60"]
    assert [problem.key for problem in PROBLEMS] == expected
    with pytest.raises(InputError, match="problem pen15_7 is unknown, expected one of turntable"):
        find_problem("pen15_7")


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
        np.testing.assert_allclose(factor @ factor.T, window.prior.covariance, rtol=1e-12)
        inverse = window.prior_factor_inverse
        np.testing.assert_allclose(inverse @ factor, np.eye(model.n_x), rtol=0, atol=1e-9)


def test_a_longer_table_begins_with_the_shorter(interpreted: None) -> None:
    problem = CASES[0]
    one, two = solved_windows(problem, 1), solved_windows(problem, 2)
    np.testing.assert_array_equal(one[0].window.guess.states, two[0].window.guess.states)
    assert one[0].optimum.cost == two[0].optimum.cost


def test_a_recording_is_long_enough_for_the_suite() -> None:
    for problem in PROBLEMS:
        model = problem.body.model()
        last = SETTLED + STRIDE * (WARM_UP + problem.windows - 1)
        assert (
            len(recorded(problem, model, last + problem.horizon + 1)) == last + problem.horizon + 1
        )
    with pytest.raises(InputError, match="problem turntable_20 asks for 9999 stages"):
        recorded(CASES[0], CASES[0].body.model(), 9999)


def test_the_prior_is_what_an_ekf_carries(case: Case, interpreted: None) -> None:
    problem, solved = case
    model = solved[0].window.model
    ekf = create_estimator("ekf", model)
    state = ekf.init()
    measurements = recorded(problem, model, SETTLED + STRIDE + 1)
    for measurement in measurements[:-1]:
        state, _ = ekf.step(state, measurement)
    nothing = Measurement(measurements[-1].time_s, np.full(model.n_y, np.nan))
    carried, prior = ekf.step(state, nothing)[1].state, solved[1].window.prior
    assert np.abs((prior.mean - carried.mean) / carried.std).max() < 1e-9
    np.testing.assert_allclose(prior.std, carried.std, rtol=1e-9)


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
        path = np.vstack([each.window.prior.mean, each.window.guess.states])[:, angles]
        assert np.abs(np.diff(path, axis=0)).max() < np.pi / 2


def test_the_cost_is_the_references(case: Case) -> None:
    """Two formulations of the same number: rolled out, and by the window's own NLP."""
    problem, solved = case
    cost = WindowCost(solved[0].window.model, problem.horizon)
    for each in solved:
        found = each.optimum.trajectory
        here = cost(each.window, found.states[0], found.noises)
        assert abs(here - each.optimum.cost) <= 1e-9 * max(1.0, each.optimum.cost)


def test_no_direction_leads_below_the_optimum(case: Case) -> None:
    """First order: a step up and the same down change the cost alike."""
    problem, solved = case
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
