"""Where passes do not settle, OSQP solves the step: the same optimum, and it is told."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from estimation.recording import Measurement
from estimation.status import Status
from mhe.config import MheConfig
from mhe.realtime import Mhe
from models.arrays import Array
from models.state_space import StateSpaceModel
from tests.linear_models import constant_acceleration_system

N = 5


def bounded() -> tuple[StateSpaceModel, list[Measurement]]:
    """A bound that readings press against; some are missing."""
    system, rng = constant_acceleration_system(1), np.random.default_rng(6)
    measurements = system.simulate(np.cumsum(rng.uniform(0.05, 0.2, 12)), rng, missing=0.2)
    level = float(np.nanmedian([m.y[0] for m in measurements]))
    return system.model.bounded(s0_m=(-np.inf, level)), measurements


class Failing:
    """An engine whose steps from some time on fail, with the window left as a poor guess."""

    def __init__(self, engine: Any, from_s: float) -> None:
        self._engine, self._from_s = engine, from_s
        self.memory, self.result = engine.memory, engine.result

    def step(self, given: Array, time_s: float, y: Array) -> tuple[Array, Array]:
        memory, result = self._engine.step(given, time_s, y)
        if time_s >= self._from_s:
            self.result.view(result, "status")[...] = Status.SOLVER_FAILED.value
            count = int(self.memory.view(memory, "count"))
            self.memory.view(memory, "x")[:count] += 0.3
        return memory, result

    def batch(self, given: Array, time_s: Array, y: Array) -> tuple[Array, Array]:
        results = []
        for t, readings in zip(time_s, y, strict=True):
            given, result = self.step(given, float(t), readings)
            results.append(result)
        return given, np.array(results)


def failing(model: StateSpaceModel, from_s: float, **settings: float) -> Mhe:
    mhe = Mhe(model, MheConfig(horizon=N, **settings))  # type: ignore[arg-type]
    mhe.engine = Failing(mhe.engine, from_s)  # type: ignore[assignment]
    return mhe


@pytest.fixture(scope="module")
def case() -> tuple[StateSpaceModel, list[Measurement]]:
    return bounded()


def test_steps_are_solved_all_the_same(case: tuple[StateSpaceModel, list[Measurement]]) -> None:
    model, measurements = case
    good, bad = Mhe(model, MheConfig(horizon=N)), failing(model, measurements[6].time_s)
    a, b, pressed = good.init(), bad.init(), 0
    for k, measurement in enumerate(measurements):
        a, wanted = good.step(a, measurement)
        b, estimate = bad.step(b, measurement)
        assert estimate.status.is_solved
        assert (Status.FELL_BACK in estimate.status) == (k >= 6)
        assert np.abs((estimate.state.mean - wanted.state.mean) / wanted.state.std).max() < 1e-6
        assert estimate.window is not None
        assert wanted.window is not None
        np.testing.assert_allclose(estimate.window.states, wanted.window.states, atol=1e-6)
        pressed += wanted.state.mean[0] > model.upper[0] - 1e-9
    assert pressed >= 2


def test_a_batch_is_the_steps(case: tuple[StateSpaceModel, list[Measurement]]) -> None:
    model, measurements = case
    mhe = failing(model, measurements[6].time_s)
    times, y = np.array([m.time_s for m in measurements]), np.array([m.y for m in measurements])
    _, history = mhe.batch(mhe.init(), times, y)
    state = mhe.init()
    for k, measurement in enumerate(measurements):
        state, estimate = mhe.step(state, measurement)
        np.testing.assert_allclose(history.mean[k], estimate.state.mean, atol=1e-7)
        assert history.status[k] is estimate.status
    assert any(Status.FELL_BACK in status for status in history.status)


def test_a_deadline_leaves_no_time_for_it(
    case: tuple[StateSpaceModel, list[Measurement]],
) -> None:
    model, measurements = case
    mhe = failing(model, 0.0, deadline_s=10.0)
    _, estimate = mhe.step(mhe.init(), measurements[0])
    assert Status.SOLVER_FAILED in estimate.status
    assert Status.FELL_BACK not in estimate.status


def test_without_constraints_a_failure_stays_one(
    case: tuple[StateSpaceModel, list[Measurement]],
) -> None:
    model, measurements = case
    free = model.replace(upper=np.full(model.n_x, np.inf))
    _, estimate = failing(free, 0.0).step(failing(free, 0.0).init(), measurements[0])
    assert Status.SOLVER_FAILED in estimate.status
