"""Bounds and inequalities in compiled C and around the interpreted stage: the same."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from estimation.recording import Measurement
from mhe.config import MheConfig, MheRtiConfig
from mhe.realtime import Mhe, MheRti
from models.arrays import Array
from models.state_space import StateSpaceModel
from tests.closeness import estimate_error
from tests.configs import config_for
from tests.disturbed import disturbed
from tests.engines import compiled_and_interpreted, needs_compiler, steps
from tests.estimation import pens
from tests.linear_models import constant_acceleration_system
from tests.mhe import pendulum

pytestmark = [needs_compiler, pytest.mark.usefixtures("optimised")]


def pen_case() -> tuple[StateSpaceModel, list[Measurement]]:
    """Above its desk, beside a wall."""
    run = pens.draw_pen_run(26, seed=11)
    tips = run.truth[:, :3]
    model = run.model.bounded(tip_z_m=(float(np.quantile(tips[:, 2], 0.4)), np.inf))
    wall = float(np.quantile(tips[:, 0] + tips[:, 1], 0.7))
    return model.constrained(lambda x: x[0] + x[1] - wall), run.measurements


def axis_case() -> tuple[StateSpaceModel, list[Measurement]]:
    """A bound that readings press against, and everything that may go wrong with them."""
    system, rng = constant_acceleration_system(1), np.random.default_rng(6)
    measurements = system.simulate(np.cumsum(rng.uniform(0.05, 0.2, 30)), rng, missing=0.0)
    level = float(np.median([m.y[0] for m in measurements]))
    return system.model.bounded(s0_m=(-np.inf, level)), disturbed(measurements)


def pendulum_case() -> tuple[StateSpaceModel, list[Measurement]]:
    """A curved row."""
    model = pendulum.model().constrained(lambda x: ca.sumsqr(x / ca.DM([0.8, 4.0])) - 1)
    return model, pendulum.simulate(26, 3)


CASES = {"pen": pen_case(), "axis": axis_case(), "pendulum": pendulum_case()}


@pytest.mark.cover
@pytest.mark.parametrize("kind", [MheRti, Mhe])
@pytest.mark.parametrize("name", CASES)
def test_every_step(name: str, kind: type[Mhe] | type[MheRti]) -> None:
    model, measurements = CASES[name]
    machine, plain = compiled_and_interpreted(lambda: kind(model, config_for(kind, horizon=6)))
    held = 0
    for a, b in zip(steps(machine, measurements), steps(plain, measurements), strict=True):
        assert estimate_error(model, a, b) < (1e-6 if kind is Mhe else 1e-9)
        assert a.status is b.status
        held += _holds(model, a.state.mean, 1e-6 if kind is Mhe else 0.1)
    assert held >= 3


def _holds(model: StateSpaceModel, x: Array, within: float) -> bool:
    """Whether some row is met with equality; a curved one nearly, after one pass."""
    g = np.asarray(model.inequality(x)).ravel()
    slack = np.concatenate([model.lower - x, x - model.upper, g])
    return bool((np.abs(slack[np.isfinite(slack)]) < within).any())


@pytest.mark.parametrize("kind", [MheRti, Mhe])
def test_bounds_hold_at_every_step(kind: type[Mhe] | type[MheRti]) -> None:
    for name in ("pen", "axis"):
        model, measurements = CASES[name]
        for estimate in steps(kind(model, config_for(kind, horizon=6)), measurements):
            assert estimate.window is not None
            for x in estimate.window.states:
                assert (x >= model.lower - 1e-9).all()
                assert (x <= model.upper + 1e-9).all()
                assert (np.asarray(model.inequality(x)) <= 1e-9).all()


def test_the_residual_of_the_conditions_is_told() -> None:
    model, measurements = CASES["pendulum"]
    converged = steps(Mhe(model, MheConfig(horizon=6)), measurements)
    one_pass = steps(MheRti(model, MheRtiConfig(horizon=6)), measurements)
    solved = [e for e in converged if e.status.is_solved]
    assert len(solved) > 20
    assert max(estimate.kkt_residual for estimate in solved) < 1e-6
    assert max(estimate.kkt_residual for estimate in one_pass) > 1e-2
    # what is exceeded after one pass is seen in it
    for estimate in one_pass:
        g = float(np.asarray(model.inequality(estimate.state.mean)).max())
        assert estimate.kkt_residual > 0 or g <= 0


@pytest.mark.parametrize("kind", [MheRti, Mhe])
def test_rows_that_no_state_meets_are_told(kind: type[Mhe] | type[MheRti]) -> None:
    """x outside and inside of a circle: curved, so that no linear program sees it before."""
    model = pendulum.model().constrained(
        lambda x: ca.vertcat(ca.sumsqr(x) - 0.01, 0.04 - ca.sumsqr(x))
    )
    estimates = steps(kind(model, config_for(kind, horizon=4)), pendulum.simulate(12, 3))
    assert not all(estimate.status.is_solved for estimate in estimates)
    for estimate in estimates:
        assert np.isfinite(estimate.state.mean).all()
        assert estimate.kkt_residual > 1e-3 or not estimate.status.is_solved
