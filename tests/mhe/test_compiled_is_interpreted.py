"""The window's loop in C is the loop in Python: states, covariances, innovations, statuses.

One pass agrees to the last bit: machine code and CasADi's virtual machine round alike.
`mhe` differs where Python's loop sums an inner product in another order; how much of that
is left at the end is what the tolerance of its iterations leaves.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from estimation.recording import Measurement
from estimation.status import Status
from mhe.arrival_cost import ARRIVAL_COSTS
from mhe.config import MheConfig
from mhe.realtime import Mhe, MheRti
from mhe.trajectory import Trajectory
from models.state_space import StateSpaceModel
from tests.closeness import covariance_error, estimate_error, mean_error
from tests.configs import config_for
from tests.disturbed import (
    ABSURD_AT,
    EMPTY_AT,
    INFINITE_AT,
    LATE_AT,
    SATURATED_AT,
    disturbed,
)
from tests.engines import compiled_and_interpreted, needs_compiler, steps
from tests.estimation import pens
from tests.linear_models import coupled_system, irregular_times
from tests.mhe import pendulum

pytestmark = [needs_compiler, pytest.mark.usefixtures("optimised")]

ONE_PASS, CONVERGED = 1e-12, 1e-9
LOSSES: dict[str, dict[str, Any]] = {
    "least squares": {},
    "huber": {"huber": {"first": 1.5}},
    "sparse noise": {"sparse_noise": 1.0},
    "both": {"huber": {"first": 1.5}, "sparse_noise": 1.0},
}


def pen_case() -> tuple[StateSpaceModel, list[Measurement]]:
    """A pen whose accelerometer has a range that one reading reaches."""
    run = pens.draw_pen_run(26, seed=11)
    accel, *others = run.model.sensors
    model = run.model.replace(sensors=(replace(accel, reading_limit=40.0), *others))
    return model, disturbed(run.measurements, limit=39.99, outlier=3.0)


def coupled_case() -> tuple[StateSpaceModel, list[Measurement]]:
    system, rng = coupled_system(3), np.random.default_rng(17)
    measurements = system.simulate(irregular_times(26, rng), rng, missing=0.2)
    return system.model, disturbed(measurements, outlier=4.0)


SETTINGS = [
    *((arrival_cost, "least squares") for arrival_cost in ARRIVAL_COSTS),
    *(("filtered", losses) for losses in LOSSES if losses != "least squares"),
    ("smoothed", "both"),
]
QUICK, SLOW = {SETTINGS[0], ("smoothed", "both")}, pytest.mark.slow
"""The settings that quick tests try on every case; on the pendulum they try all."""

CASES = {
    "pen": pen_case(),
    "pendulum": (pendulum.model(), disturbed(pendulum.simulate(26, 3), outlier=0.5)),
    "coupled": coupled_case(),
}


def with_sensor(settings: dict[str, Any], model: StateSpaceModel) -> dict[str, Any]:
    """Settings with Huber's loss on the model's first sensor."""
    if "huber" not in settings:
        return settings
    return settings | {"huber": {model.sensors[0].name: settings["huber"]["first"]}}


@pytest.mark.cover
@pytest.mark.parametrize("kind", [MheRti, Mhe])
@pytest.mark.parametrize(
    ("arrival_cost", "losses", "name"),
    [
        pytest.param(*setting, name, marks=() if setting in QUICK or name == "pendulum" else SLOW)
        for setting in SETTINGS
        for name in CASES
    ],
)
def test_every_step(
    name: str, arrival_cost: str, losses: str, kind: type[Mhe] | type[MheRti]
) -> None:
    model, measurements = CASES[name]
    settings = with_sensor(LOSSES[losses], model)
    config = config_for(kind, horizon=4, arrival_cost=arrival_cost, **settings)
    machine, plain = compiled_and_interpreted(lambda: kind(model, config))
    tolerance = CONVERGED if kind is Mhe else ONE_PASS
    for a, b in zip(steps(machine, measurements), steps(plain, measurements), strict=True):
        assert estimate_error(model, a, b) < tolerance
        assert a.status is b.status
        assert a.time_s == b.time_s


@pytest.mark.parametrize("kind", [MheRti, Mhe])
def test_the_run_has_all_that_may_go_wrong(kind: type[Mhe] | type[MheRti]) -> None:
    model, measurements = CASES["pen"]
    estimates = steps(kind(model, config_for(kind, horizon=4)), measurements)
    status = [estimate.status for estimate in estimates]
    assert status[LATE_AT] is Status.SOLVED
    assert estimates[LATE_AT].time_s == estimates[LATE_AT - 1].time_s
    assert status[EMPTY_AT] is Status.NO_READING
    assert status[INFINITE_AT] is Status.INFINITE_READING
    assert Status.NOT_FINITE in status[ABSURD_AT]
    assert status[SATURATED_AT] is Status.SATURATED
    assert all(np.isfinite(estimate.state.covariance).all() for estimate in estimates)


@pytest.mark.cover
@pytest.mark.parametrize("n", [1, 2, 7])
@pytest.mark.parametrize("losses", LOSSES)
def test_a_window_from_a_bad_start(losses: str, n: int) -> None:
    run, rng = pens.draw_pen_run(8, seed=2), np.random.default_rng(5)
    config = MheConfig(horizon=7, **with_sensor(LOSSES[losses], run.model))
    machine, plain = compiled_and_interpreted(lambda: Mhe(run.model, config))
    states = pens.PRIOR_MEAN + pens.PRIOR_STD * rng.standard_normal((n, 15))
    guess = Trajectory(states, rng.standard_normal((n - 1, 15)))
    window = run.model.prior, tuple(run.measurements[:n]), guess
    a, b = machine.solve(*window), plain.solve(*window)
    assert a.status is b.status is Status.SOLVED
    assert abs(a.cost - b.cost) < 1e-12 * b.cost
    assert mean_error(run.model, a.newest.mean, b.newest) < CONVERGED
    assert covariance_error(a.newest.covariance, b.newest.covariance) < CONVERGED
    assert np.abs(a.trajectory.noises - b.trajectory.noises).max(initial=0.0) < CONVERGED


def test_a_start_that_is_not_finite_is_told_by_both() -> None:
    run = pens.draw_pen_run(8, seed=2)
    machine, plain = compiled_and_interpreted(lambda: Mhe(run.model, MheConfig(horizon=7)))
    good, bad = (
        (run.model.prior, tuple(run.measurements), Trajectory(states, np.zeros((7, 15))))
        for states in (run.truth, np.full((8, 15), np.nan))
    )
    for mhe in (machine, plain):
        assert mhe.solve(*good).status is Status.SOLVED
        found = mhe.solve(*bad)
        assert found.status is Status.NOT_FINITE
        assert np.isnan(found.cost)
        assert np.isnan(found.newest.covariance).any(), "a covariance of another window"
