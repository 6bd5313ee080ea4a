"""The judge of the comparison with IPOPT, and the step that it judges by."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from benchmark.configurations import contract_models
from estimation.status import Status
from mhe.config import MheIpoptConfig
from mhe.reference.ipopt import MheIpopt
from models.errors import InputError
from suites.optimum.cases import WindowCase, WindowKey, rolled_out, window_case
from suites.optimum.newton_step import AT_BOUND, NewtonCheck
from suites.optimum.reference import LONGEST_LEFT, IpoptReference
from suites.optimum.run import (
    ABOVE,
    BELOW,
    IPOPT_FAILED,
    NEWEST_LIMIT,
    SAME,
    WindowRow,
    compared,
    judged,
)
from tests.mhe import pendulum
from tests.references.gauss_newton import DenseWindow, gauss_newton_step, line_search

HORIZON = 5
MODELS = ("turntable accel+gyro", "pen6 accel+gyro+camera")


def case_of(model: str) -> WindowCase:
    key = WindowKey(3, model, "bad start", HORIZON)
    return window_case(key) if model in MODELS else pendulum_case(key)


def pendulum_case(key: WindowKey) -> WindowCase:
    """A window whose transition is nonlinear too."""
    model, measurements = pendulum.model(), tuple(pendulum.simulate(HORIZON + 1, key.seed))
    guess = rolled_out(model, model.prior.mean, measurements)
    return WindowCase(key, model, model.prior, measurements, guess)


@pytest.mark.parametrize("model", [*MODELS, "pendulum"])
def test_a_newton_step_leads_back_to_the_optimum(model: str) -> None:
    """A little way off, it is as long as the way, and the newest state moves as it must."""
    case, way = case_of(model), 1e-4
    window = DenseWindow(case.model, case.prior, case.measurements)
    optimum = line_search(window, window.start(case.guess))
    assert optimum.converged
    off = np.random.default_rng(1).standard_normal(window.n_z)
    _, J, X = window.linearised(optimum.z)
    off *= way / np.linalg.norm(J @ off)
    std = np.linalg.norm(np.linalg.solve(np.linalg.cholesky(J.T @ J), X.T), axis=0)
    check = NewtonCheck(case.model, MheIpoptConfig(horizon=HORIZON))
    here = window.trajectory(optimum.z + off)
    step = check.step(case.prior, case.measurements, here, std)
    assert step.length == pytest.approx(way, rel=1e-2)
    np.testing.assert_allclose(step.newest / std, -X @ off / std, rtol=1e-2, atol=1e-2 * way)
    r, J, _ = window.linearised(optimum.z + off)
    expected = float(np.linalg.norm(J @ gauss_newton_step(r, J)))
    assert step.gauss_newton_length == pytest.approx(expected, rel=1e-6)


def test_bounds_on_states_that_do_not_add_are_refused() -> None:
    model = contract_models()["pen6 accel+gyro"]
    bounded = model.bounded(mrp_x=(-0.5, 0.5))
    with pytest.raises(InputError, match="bounds on states that do not add, expected one without"):
        NewtonCheck(bounded, MheIpoptConfig(horizon=HORIZON))


def test_a_newton_step_knows_a_minimum_on_a_bound() -> None:
    """None is left there; from a little inside it is as long as the way back."""
    case, way = window_case(WindowKey(16, "classic tank", "bad start", HORIZON)), 1e-4
    settings = MheIpoptConfig(horizon=HORIZON, tolerance=1e-12)
    found = MheIpopt(case.model, settings).solve(case.prior, case.measurements, case.guess)
    std = found.newest.std
    at_bound = found.trajectory.states[:, 0] <= case.model.lower[0] + AT_BOUND * std[0]
    assert at_bound.any()
    check = NewtonCheck(case.model, settings)
    assert check.step(case.prior, case.measurements, found.trajectory, std).length < 1e-9
    window = DenseWindow(case.model, case.prior, case.measurements)
    z = window.start(found.trajectory)
    _, J, _ = window.linearised(z)
    inside = np.zeros(window.n_z)
    inside[0] = way / np.linalg.norm(J[:, 0])  # the first level rises, and all behind it
    here = window.trajectory(z + inside)
    assert (here.states[at_bound, 0] > case.model.lower[0] + AT_BOUND * std[0]).all()
    step = check.step(case.prior, case.measurements, here, std)
    assert step.length == pytest.approx(way, rel=1e-2)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({}, ""),
        ({"newest_distance": 1e-5, "cost": 5e4, "newton_length": 2e-6}, "a cost of 5e+04 hides"),
        ({"newest_distance": 1e-5, "newton_length": 2e-6}, "2e-06 left: solved"),
        ({"verdict": ABOVE}, "two minima"),
        ({"verdict": BELOW}, "two minima"),
        ({"verdict": ABOVE, "at_bounds": 2}, "two minima: 2 states at bounds, IPOPT 0 states"),
        ({"verdict": ABOVE, "newton_length": np.inf}, "mhe stopped short, inf left: solved"),
        ({"verdict": IPOPT_FAILED, "ipopt_newton_length": 3e-2}, "IPOPT stopped short, 3e-02 left"),
    ],
)
def test_whatever_does_not_hold_has_a_reason(change: dict[str, Any], reason: str) -> None:
    key = WindowKey(0, "a model", "plain", HORIZON)
    status = Status.SOLVED
    row = WindowRow(
        key, SAME, status, status, 5.0, 5.0, 0.0, 1e-9, 1e-9, 1e-9, 0, 0, 4, 9, 1
    )  # fmt: skip
    found = replace(row, **change).reason
    assert reason in found
    assert bool(found) == bool(reason)


@pytest.mark.parametrize(
    ("relative", "ipopt_newton_length", "verdict"),
    [
        (0.0, 1e-8, SAME),
        (9e-7, 1e-8, SAME),
        (-9e-7, 1e-8, SAME),
        (1.1e-6, 1e-8, ABOVE),
        (-1.1e-6, 1e-8, BELOW),
        (np.nan, 1e-8, ABOVE),
        (np.inf, 1e-8, ABOVE),
        (0.0, 1.1e-7, IPOPT_FAILED),
        (0.0, np.inf, IPOPT_FAILED),
        (0.0, np.nan, IPOPT_FAILED),
    ],
)
def test_verdicts(relative: float, ipopt_newton_length: float, verdict: str) -> None:
    assert judged(relative, ipopt_newton_length) == verdict


def test_an_unfinished_solution_is_found_out() -> None:
    """IPOPT against itself, stopped early on one side and on the other."""
    case = case_of(MODELS[0])
    settings = MheIpoptConfig(horizon=HORIZON, tolerance=1e-12)
    early_settings = replace(settings, max_iterations=1)
    whole, early = (MheIpopt(case.model, s) for s in (settings, early_settings))
    later = MheIpopt(case.model, replace(settings, tolerance=1e-2))
    reference = IpoptReference(case.model, settings)
    no_reference = IpoptReference(case.model, early_settings)
    itself = compared(case, whole, reference)
    assert (itself.verdict, itself.relative, itself.newest_distance) == (SAME, 0.0, 0.0)
    assert itself.holds
    assert itself.ipopt_runs == 1
    stopped = compared(case, early, reference)
    assert stopped.verdict == ABOVE
    assert not stopped.holds
    nearly = compared(case, later, reference)
    assert NEWEST_LIMIT < nearly.newest_distance < 1.1 * nearly.newton_length
    assert not nearly.holds
    reference_stopped = compared(case, whole, no_reference)
    assert reference_stopped.verdict == IPOPT_FAILED
    assert reference_stopped.ipopt_runs == 2
    assert reference_stopped.newton_length <= NEWEST_LIMIT


def test_a_reference_that_stalls_is_carried_on() -> None:
    """Full Gauss-Newton steps are too long at this minimum, and its cost is flat."""
    case = window_case(WindowKey(576, "pen5 two accelerometers", "plain", HORIZON))
    settings = MheIpoptConfig(horizon=HORIZON, tolerance=1e-12)
    first = MheIpopt(case.model, settings).solve(case.prior, case.measurements, case.guess)
    reference = IpoptReference(case.model, settings)
    found = reference.solve(case)
    before = reference.newton_length(case, first.trajectory, first.newest.std)
    assert found.runs == 2
    assert found.newton_length < LONGEST_LEFT < before
    assert found.solution.iterations > first.iterations
    assert found.solution.cost == pytest.approx(first.cost, rel=1e-6)
