"""Recordings, histories, models, settings, states and estimators go to a process and back."""

from __future__ import annotations

import copy
import dataclasses
import multiprocessing
import pickle
import time
from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

import casadi as ca
import numpy as np
import pytest
from pydantic import BaseModel

from benchmark.bodies import BODIES
from ekf_baseline.ekf import Ekf, EkfConfig
from ekf_baseline.ukf import Ukf, UkfConfig
from estimation.estimate import EstimateHistory
from estimation.estimator import run, run_measurements
from estimation.recording import Measurement, Recording
from mhe.config import MheConfig, MheIpoptConfig, MheRtiConfig
from mhe.realtime import Mhe, MheRti
from mhe.reference.ipopt import MheIpopt
from models.state_space import StateSpaceModel
from pen_mhe.comparison import compare
from pen_mhe.watching import watched
from suites.bad_starts.cases import CASES, case_pen
from tests.linear_models import coupled_system

ESTIMATORS: dict[str, Callable[[StateSpaceModel], Any]] = {
    "ekf": Ekf,
    "mhe-rti": lambda model: MheRti(model, MheRtiConfig(horizon=3)),
}
CONFIG = MheConfig(horizon=3, huber={"accel": 2.0})


@cache
def model(body: str) -> StateSpaceModel:
    return coupled_system(0).model if body == "own" else BODIES[body]().model()


@cache
def recording(body: str) -> Recording:
    return BODIES[body]().record(0.2, 4)


@cache
def history(body: str, estimator: str = "ekf") -> EstimateHistory:
    return run(ESTIMATORS[estimator](model(body)), recording(body), covariances=True)


def estimate(told: tuple[str, StateSpaceModel, Recording]) -> EstimateHistory:
    """What a worker does."""
    name, of_model, of_recording = told
    return run(ESTIMATORS[name](of_model), of_recording, covariances=True)


VALUES: dict[str, Callable[[], Any]] = {
    "recording": lambda: recording("pen24"),
    "first of a recording": lambda: recording("pen24").first(0.1),
    "selected recording": lambda: recording("pen24").select(["gyro"]),
    "truth": lambda: recording("pen24").truth,
    "measurement": lambda: next(iter(recording("pen24").measurements(model("pen24")))),
    "history": lambda: history("pen24"),
    "model of a pen": lambda: model("pen24"),
    "model of a bounded pen": lambda: model("pen15").bounded(tip_z_m=(0.0, np.inf)),
    "model of a turntable": lambda: model("turntable"),
    "model of one's own": lambda: model("own"),
    "pen": lambda: BODIES["pen24"]().config,
    "pen of a bad start": lambda: case_pen(next(iter(CASES.values()))),
    "turntable": lambda: BODIES["turntable"]().config,
    "settings of the ekf": lambda: EkfConfig(gate_probability=0.99),
    "settings of the mhe": lambda: CONFIG,
    "state of the ekf": lambda: Ekf(model("pen15")).init(),
    "state of the mhe": lambda: MheRti(model("pen15"), MheRtiConfig(horizon=3)).init(),
    "comparison": lambda: compare({"a": history("pen24")}),
}


def assert_equal(one: Any, other: Any) -> None:
    """Of the same type, with the same content."""
    assert type(one) is type(other)
    if isinstance(one, np.ndarray):
        np.testing.assert_array_equal(one, other)
    elif isinstance(one, ca.Function):
        assert one.serialize() == other.serialize()
    elif isinstance(one, BaseModel):
        assert_equal(dict(one), dict(other))
    elif isinstance(one, Mapping):
        assert list(one) == list(other)
        assert_equal(list(one.values()), list(other.values()))
    elif isinstance(one, list | tuple):
        assert len(one) == len(other)
        for a, b in zip(one, other, strict=True):
            assert_equal(a, b)
    elif dataclasses.is_dataclass(one):
        for field in dataclasses.fields(one):
            assert_equal(getattr(one, field.name), getattr(other, field.name))
    else:
        assert one == other


AGAIN = [copy.deepcopy, lambda value: pickle.loads(pickle.dumps(value))]


@pytest.mark.cover
@pytest.mark.parametrize("again", AGAIN)
@pytest.mark.parametrize("name", VALUES)
def test_a_value_comes_back(name: str, again: Callable[[Any], Any]) -> None:
    value = VALUES[name]()
    found = again(value)
    assert found is not value
    assert_equal(found, value)


def test_readings_cannot_be_changed() -> None:
    data = Recording("r", np.arange(3.0), {"gyro": np.zeros((3, 2))})
    for some in (data, data.first(1.0), data.select(["gyro"])):
        with pytest.raises(TypeError, match="cannot be changed"):
            some.readings["gyro"] = np.zeros((3, 2))  # type: ignore[index]


BUILT: dict[str, Callable[[StateSpaceModel], Any]] = {
    **ESTIMATORS,
    "ukf": lambda model: Ukf(model, UkfConfig(alpha=0.5)),
    "mhe": lambda model: Mhe(model, MheConfig(horizon=3), clock=time.monotonic),
    "mhe-ipopt": lambda model: MheIpopt(model, MheIpoptConfig(horizon=2)),
    "watched": lambda model: watched(Ekf(model, EkfConfig(gate_probability=0.99)), on_lost="hold"),
}


@pytest.mark.parametrize("again", AGAIN)
@pytest.mark.parametrize("name", BUILT)
def test_an_estimator_is_built_again(name: str, again: Callable[[Any], Any]) -> None:
    """Of its model and settings: its workspace stays where it is."""
    system = coupled_system(0)
    estimator = BUILT[name](system.model)
    found = again(estimator)
    assert_equal(found.config, estimator.config)
    given = system.simulate(np.arange(4.0), np.random.default_rng(1))
    told, wanted = (run_measurements(each, given).mean for each in (found, estimator))
    assert_equal(told, wanted)


def test_another_process_estimates_the_same() -> None:
    """To the last bit, with the model and the recording that it was sent."""
    told = [(name, body) for name in ESTIMATORS for body in ("pen24", "turntable")]
    sent = [(name, model(body), recording(body)) for name, body in told]
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        found = pool.map(estimate, sent)
    for (name, body), one in zip(told, found, strict=True):
        wanted = history(body, name)
        timed = {"step_time_s": wanted.step_time_s}
        assert_equal(dataclasses.replace(one, **timed), wanted)


def test_a_measurement_is_taken_by_a_model_that_was_sent() -> None:
    again = pickle.loads(pickle.dumps(model("pen15")))
    for name, build in ESTIMATORS.items():
        one, other = build(model("pen15")), build(again)
        measurement = Measurement(0.0, np.zeros(5))
        _, a = one.step(one.init(), measurement)
        _, b = other.step(other.init(), measurement)
        assert_equal(a.state, b.state)
        assert a.status == b.status, name
