"""Every estimator finds rest alike: batches, steps, compiled and interpreted, and snapshots."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from estimation.estimate import EstimateHistory
from estimation.estimator import run
from estimation.recording import Measurement, Recording
from mhe.scheme import TOLERANCE
from models.arrays import Array
from models.state_space import StateSpaceModel
from pen_mhe.estimators import create_estimator
from tests.engines import compiled_and_interpreted, needs_compiler, steps
from tests.estimation.resting import (
    INERTIAL,
    columns,
    inertial,
    instants,
    model_at_rest,
    rests,
)

MODEL = model_at_rest()
PICKED_UP_S = 1.6


def disturbed() -> tuple[Array, Array]:
    """Return instants (n,) and readings (n, n_y): still, lost readings, a limit, then a turn."""
    time_s = instants(1.9)
    time_s = time_s[(time_s < 1.2) | (time_s > 1.32)]
    turn = 0.3 * np.maximum(time_s - PICKED_UP_S, 0)[:, None] * [1.0, 2.0, 0.0]
    y = inertial(MODEL, time_s, 1, rate=turn, bias_rad_s=0.01)
    y[5, columns(MODEL, "accel")] = 50.0
    y[20:30, columns(MODEL, "accel")] = np.nan
    y[130, columns(MODEL, "gyro")] = np.nan
    area = columns(MODEL, "area")
    y[:, area] = MODEL.sensor("area").constant_reading
    return time_s, y


TIME_S, Y = disturbed()
FOUND = rests(MODEL, TIME_S, Y)


def said(model: StateSpaceModel, history: EstimateHistory) -> Array:
    """Return at which steps (n,) a reading of rest was used."""
    start = 0
    for sensor in model.sensors:
        if sensor.name == "still":
            return np.isfinite(history.innovation[:, start : start + 3]).all(axis=1)
        start += sensor.n_r
    raise KeyError("still")


def test_the_case_is_one() -> None:
    assert not FOUND[TIME_S < 1.0].any()
    assert 20 < FOUND.sum() < 60
    assert not FOUND[TIME_S > PICKED_UP_S + 0.05].any()


@needs_compiler
@pytest.mark.parametrize("name", ["ekf", "mhe-rti", pytest.param("mhe", marks=pytest.mark.slow)])
def test_compiled_is_interpreted(name: str) -> None:
    settings: dict[str, Any] = {} if name == "ekf" else {"horizon": 3}
    machine, plain = compiled_and_interpreted(lambda: create_estimator(name, MODEL, **settings))
    _, a = machine.batch(machine.init(), TIME_S, Y)
    _, b = plain.batch(plain.init(), TIME_S, Y)
    assert (said(MODEL, a) == FOUND).all()
    assert (said(MODEL, b) == FOUND).all()
    apart = np.abs(a.mean - b.mean).max()
    if name == "mhe":  # each ends where its own tolerance lets it
        assert (np.abs(a.mean - b.mean) / a.std).max() < TOLERANCE
    else:
        assert apart == 0


@pytest.mark.parametrize("name", ["ekf", "mhe-rti"])
def test_a_batch_is_its_steps_and_a_snapshot_goes_on(name: str) -> None:
    estimator: Any = create_estimator(name, MODEL)
    _, whole = estimator.batch(estimator.init(), TIME_S, Y)
    measurements = [Measurement(float(t), y) for t, y in zip(TIME_S, Y, strict=True)]
    one_by_one = steps(estimator, measurements)
    assert (np.array([e.state.mean for e in one_by_one]) == whole.mean).all()
    state, _ = estimator.batch(estimator.init(), TIME_S[:125], Y[:125])
    _, rest = estimator.batch(state, TIME_S[125:], Y[125:])
    _, again = estimator.batch(state, TIME_S[125:], Y[125:])
    assert (rest.mean == whole.mean[125:]).all()
    assert (again.mean == whole.mean[125:]).all()


def test_a_late_measurement_changes_nothing() -> None:
    estimator: Any = create_estimator("ekf", MODEL)
    state, _ = estimator.batch(estimator.init(), TIME_S[:120], Y[:120])
    same, _ = estimator.step(state, Measurement(float(TIME_S[50]), Y[50]))
    assert (same.rest == state.rest).all()


@pytest.mark.slow
def test_the_reference_finds_it_too() -> None:
    estimator = create_estimator("mhe-ipopt", MODEL, horizon=1)
    few = [Measurement(float(t), y) for t, y in zip(TIME_S[:125], Y[:125], strict=True)]
    found = [np.isfinite(e.innovation[-3:]).all() for e in steps(estimator, few)]
    assert (np.array(found) == FOUND[:125]).all()


def recorded(**more: Array) -> Recording:
    readings = {name: Y[:, columns(MODEL, name)] for name in INERTIAL}
    return Recording("still", TIME_S, {**readings, **more})


def test_readings_in_a_recording_are_taken_instead() -> None:
    told = np.full((len(TIME_S), 3), np.nan)
    told[30:40] = 0
    history = run(create_estimator("ekf", MODEL), recorded(still=told))
    assert np.flatnonzero(said(MODEL, history)).tolist() == list(range(30, 40))
    assert (said(MODEL, run(create_estimator("ekf", MODEL), recorded())) == FOUND).all()
