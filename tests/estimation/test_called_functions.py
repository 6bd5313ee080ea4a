"""Models whose functions call others: lookup tables, and what cannot be written as C."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np
import pytest

from ekf_baseline.ekf import Ekf
from estimation import chosen
from estimation.recording import Measurement
from mhe.config import MheConfig, MheRtiConfig
from mhe.realtime import Mhe, MheRti
from models.state_space import StateSpaceModel
from tests.engines import compiled_and_interpreted, needs_compiler, steps
from tests.linear_models import constant_acceleration_system

pytestmark = needs_compiler

ESTIMATORS: dict[str, Callable[[StateSpaceModel], Any]] = {
    "ekf": Ekf,
    "mhe-rti": lambda model: MheRti(model, MheRtiConfig(horizon=4)),
    "mhe": lambda model: Mhe(model, MheConfig(horizon=4)),
}
READINGS = [Measurement(0.1 * k, np.array([0.2 * k, 0.1])) for k in range(8)]


def with_transition(make: Callable[[ca.SX, ca.SX, ca.SX], ca.SX]) -> StateSpaceModel:
    model = constant_acceleration_system(1).model
    x, w, dt = ca.SX.sym("x", 3), ca.SX.sym("w", 3), ca.SX.sym("dt")
    return model.replace(f=ca.Function("f", [x, w, dt], [make(x, w, dt)]))


def looked_up(x: ca.SX, w: ca.SX, dt: ca.SX) -> ca.SX:
    """A brake whose force is a table over the speed."""
    grid = np.linspace(-5.0, 5.0, 11)
    table = ca.interpolant("brake", "bspline", [grid], np.tanh(grid))
    return ca.vertcat(x[0] + dt * x[1], x[1] - dt * table(x[1]), x[2]) + dt * w


def written_out(x: ca.SX, w: ca.SX, dt: ca.SX) -> ca.SX:
    """The same, without a table."""
    return ca.vertcat(x[0] + dt * x[1], x[1] - dt * ca.tanh(x[1]), x[2]) + dt * w


@pytest.mark.parametrize("name", ESTIMATORS)
def test_a_lookup_table_has_room_to_work(name: str) -> None:
    model = with_transition(looked_up)
    machine, plain = compiled_and_interpreted(lambda: ESTIMATORS[name](model))
    free = steps(ESTIMATORS[name](with_transition(written_out)), READINGS)
    for a, b, c in zip(steps(machine, READINGS), steps(plain, READINGS), free, strict=True):
        np.testing.assert_allclose(a.state.mean, b.state.mean, rtol=0, atol=1e-9)
        np.testing.assert_allclose(a.state.mean, c.state.mean, rtol=0, atol=0.02)
        assert a.status is b.status


class Doubled(ca.Callback):
    """A function in Python, of which nobody can write C."""

    def __init__(self) -> None:
        ca.Callback.__init__(self)
        self.construct("doubled", {"enable_fd": True})

    def eval(self, arguments: Any) -> Any:
        return [2 * arguments[0]]


def test_what_cannot_be_compiled_is_interpreted_and_said_once() -> None:
    doubled = Doubled()
    model = with_transition(lambda x, w, dt: ca.vertcat(doubled(x[0]) / 2, x[1], x[2]) + dt * w)
    chosen._warn_once.cache_clear()
    with pytest.warns(RuntimeWarning, match="cannot be compiled and are interpreted"):
        ekf = Ekf(model)
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        Ekf(model)
    assert all(np.isfinite(e.state.mean).all() for e in steps(ekf, READINGS))
