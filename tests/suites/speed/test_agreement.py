"""All contenders are given the same windows and end where they should.

In standard deviations of the newest state: what iterates ends in the reference's optimum,
what makes one Gauss-Newton pass ends where every other such pass does. With bounds as without.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
import pytest

from models.state_space import StateSpaceModel
from pen_mhe.estimators import create_estimator
from suites.speed.contender import CONVERGED, ONE_PASS, Entry, RaceOutcome
from suites.speed.contenders import WINDOW_CONTENDERS
from suites.speed.osqp_contender import TUNED_BOUNDED, Osqp
from suites.speed.own_contenders import WindowStep
from suites.speed.problems import Problem
from suites.speed.races import RacedProblem, race_windows
from suites.speed.runner import Racer, built, race
from suites.speed.tangent import is_plain
from suites.speed.windows import SpeedWindow, solved_windows

OPTIMUM_STD = 1e-5
"""Default tolerances of IPOPT and fatrop, 1e-8 scaled, leave some 1e-8 to 1e-7."""
PASS_STD = 1e-6
DEFAULT_OSQP_STD = 1e-2
"""OSQP's default tolerance is 1e-3."""

QP_PEERS = ("clarabel", "piqp", "qpalm")
"""Where they are installed: extra `peers`."""
INTERIOR_STD = 1e-4
"""Their tolerances of 1e-7 and 1e-8 leave some 1e-6 to 1e-5."""

RELAXED_STD = 1e-4
"""IPOPT relaxes a bound by 1e-8 of its unit, which is 4e-5 standard deviations of a tip that a
camera sees; and a barrier of 1e-9 keeps what hardly touches a bound off it by its root."""
BARRIER_COST = 1e-7
"""What the barrier of an interior point is worth, relative: 1e-8 per bound and stage."""
PULL_STD = 10.0
"""Multiplier of a bound, at most: what a standard deviation more room for it is worth."""

FREE = (Problem("turntable", 20, 3), Problem("pen15", 10, 2), Problem("pen24", 6, 2))
BOUNDED = (
    Problem("turntable", 20, 3, bounded=True),
    Problem("pen15", 10, 2, bounded=True),
    Problem("pen24", 6, 2, seed=2, bounded=True),
)
QUICK = {"turntable_20", "pen15_10_bounded"}
"""A plain one, and a pen with bounds; a free pen takes long to build for all."""


def marked(problems: Sequence[Problem]) -> list[Any]:
    return [
        pytest.param(
            problem, marks=() if problem.key in QUICK else pytest.mark.slow, id=problem.key
        )
        for problem in problems
    ]


@pytest.fixture(scope="module", params=marked((*FREE, *BOUNDED)))
def raced(request: pytest.FixtureRequest) -> tuple[RacedProblem, dict[Entry[Any], str]]:
    absent: dict[Entry[Any], str] = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("estimation.native.compiler", lambda: None)
        return race_windows(request.param, absent.setdefault), absent


Raced = tuple[RacedProblem, dict[Entry[Any], str]]


def test_every_contender_runs_or_is_left_out_by_name(raced: Raced) -> None:
    result, absent = raced
    ran = {f"{row.contender} ({row.mode})" for row in result.rows}
    left_out = {entry.label for entry in absent}
    assert ran | left_out == {entry.label for entry in WINDOW_CONTENDERS}
    assert not ran & left_out
    # These come with the package.
    assert {"mhe-rti (one pass)", "mhe (converged)", "ipopt (converged)"} <= ran
    assert {"osqp (one pass)", "osqp-tuned (one pass)"} <= ran


def test_what_converges_ends_in_one_optimum(raced: Raced) -> None:
    result, _ = raced
    optimum = np.mean([each.optimum.cost for each in result.windows])
    rows = [row for row in result.rows if row.mode == CONVERGED]
    assert len(rows) >= 3
    for row in rows:
        assert row.solved == 1
        assert row.newest_error_max_std is not None
        own = row.contender == "mhe"  # meets bounds exactly
        relaxed = row.bounds and not own
        assert row.newest_error_max_std < (RELAXED_STD if relaxed else OPTIMUM_STD), row.contender
        allowed = (BARRIER_COST if relaxed else 1e-9) * max(1.0, optimum)
        if relaxed:
            assert row.active_rows is not None
            assert row.violation_std is not None
            allowed += PULL_STD * row.active_rows * row.violation_std
        assert row.cost is not None
        assert abs(row.cost - optimum) < allowed, row.contender


def test_bounds_hold_and_are_active(raced: Raced) -> None:
    result, _ = raced
    for row in result.rows:
        assert row.bounds == result.problem.bounded
        if not row.bounds:
            assert (row.active_rows, row.violation_std) == (None, None)
            continue
        assert row.active_rows is not None
        assert row.active_rows >= 1
        assert row.violation_std is not None
        assert row.violation_std < (RELAXED_STD if row.mode == CONVERGED else DEFAULT_OSQP_STD)
        if row.contender.startswith("mhe"):
            assert row.violation_std < 1e-8


def test_rows_say_what_was_timed(raced: Raced) -> None:
    result, _ = raced
    for row in result.rows:
        assert (row.problem, row.horizon) == (result.problem.name, result.problem.horizon)
        assert row.windows == len(result.windows) == result.problem.windows
        assert 0 < row.median_s <= row.p99_s <= row.max_s
        assert row.build_s > 0


EXACT: dict[str, object] = {**TUNED_BOUNDED, "eps_abs": 1e-9, "eps_rel": 1e-9, "rho": 30.0}
EXACT["max_iter"] = 400_000

UNCARRIED_STD = 1e-2
"""Of a free pen `mhe-rti` takes the prior as it is, where `mhe` carries it into the tangent space
at the point that a pass linearises at: a difference of second order."""

ROLLED_STD = 1e-3
"""And `mhe` rolls its step out through f, which there is not linear."""


class FirstPass(WindowStep):
    """The first pass of the MHE that iterates."""

    def __init__(self, model: StateSpaceModel, example: SpeedWindow) -> None:
        super().__init__(model, example, "mhe")
        horizon = len(example.dt)
        self._estimator = create_estimator("mhe", model, horizon=horizon, max_iterations=1)


def tolerance_of_one_pass(model: StateSpaceModel) -> float:
    return PASS_STD if is_plain(model) else UNCARRIED_STD


@pytest.mark.parametrize("problem", marked(FREE))
def test_one_pass_is_one_gauss_newton_step(problem: Problem, interpreted: None) -> None:
    """OSQP's QP and the Kalman stage's pass are the same step, written down twice."""
    solved = solved_windows(problem, 2)
    windows, model = [each.window for each in solved], solved[0].window.model
    entries = [entry for entry in WINDOW_CONTENDERS if entry.mode == ONE_PASS]
    exact = partial(Osqp, settings=EXACT, bounded_settings=EXACT)
    entries += [Entry("first", ONE_PASS, FirstPass), Entry("exact", ONE_PASS, exact)]
    racers = {
        racer.entry.name: racer for racer in built(entries, model, windows[0], lambda *_: None)
    }
    race(list(racers.values()), windows, warm_up=0)
    for i, each in enumerate(solved):
        std = each.optimum.newest.std
        step = _newest(racers["exact"], i)
        for name, tolerance in (
            ("first", PASS_STD if is_plain(model) else ROLLED_STD),
            ("mhe-rti", tolerance_of_one_pass(model)),
            ("osqp-tuned", PASS_STD),
            ("osqp", DEFAULT_OSQP_STD),
            *((name, INTERIOR_STD) for name in QP_PEERS if name in racers),
        ):
            away = model.difference(_newest(racers[name], i), step).full().ravel()
            assert np.abs(away / std).max() < tolerance, name
        # A step it is, and not yet the optimum.
        left = model.difference(step, each.optimum.newest.mean).full().ravel()
        assert PASS_STD < np.abs(left / std).max() < 1


@pytest.mark.parametrize("problem", marked(BOUNDED))
def test_one_bounded_pass_is_one_quadratic_program(problem: Problem, interpreted: None) -> None:
    """The active set on the pass' factors and OSQP on a sparse matrix end in one step."""
    solved = solved_windows(problem, 2)
    windows, model = [each.window for each in solved], solved[0].window.model
    entries = [entry for entry in WINDOW_CONTENDERS if entry.mode == ONE_PASS]
    exact = partial(Osqp, settings=EXACT, bounded_settings=EXACT)
    racers = {
        racer.entry.name: racer
        for racer in built(
            [*entries, Entry("exact", ONE_PASS, exact)], model, windows[0], lambda *_: None
        )
    }
    race(list(racers.values()), windows, warm_up=0)
    for i, each in enumerate(solved):
        std = each.optimum.newest.std
        step = _newest(racers["exact"], i)
        for name, tolerance in (
            ("mhe-rti", tolerance_of_one_pass(model)),
            ("osqp-tuned", DEFAULT_OSQP_STD),
            ("osqp", 10 * DEFAULT_OSQP_STD),
            *((name, INTERIOR_STD) for name in QP_PEERS if name in racers),
        ):
            away = model.difference(_newest(racers[name], i), step).full().ravel()
            assert np.abs(away / std).max() < tolerance, name
        left = model.difference(step, each.optimum.newest.mean).full().ravel()
        assert PASS_STD < np.abs(left / std).max() < 1


def _newest(racer: Racer[SpeedWindow], i: int) -> np.ndarray:
    outcome: RaceOutcome = racer.outcomes[i]
    return outcome.newest
