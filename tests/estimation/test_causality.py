"""Causality, proved: what arrives after an instant changes no estimate before it, by one bit."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pen_mhe as pm
from estimation.estimate import EstimateHistory
from estimation.estimator import Estimator, run, run_measurements
from estimation.history import PER_STEP
from estimation.recording import Recording
from models.pen import pen_model
from models.pen_file import load_pen
from models.state_space import StateSpaceModel
from tests.engines import needs_compiler
from tests.estimation.arriving import Reading, changed_after, readings_of, recording_of
from tests.estimation.test_arrivals import model as forced_walk
from tests.pages import run_python

SENSORS = ("accel", "gyro", "camera")
LAGS = (14, 15, 16, 17)
SETTINGS: dict[str, dict[str, Any]] = {
    "ekf": {},
    "mhe-rti": {"horizon": 20, "lag_samples": LAGS},
    "mhe": {"horizon": 20, "lag_samples": LAGS},
    "mhe-ipopt": {"horizon": 20, "lag_samples": LAGS},
}
QUICK_S, LONG_S = 0.4, 2.0
PAGE = Path(__file__).resolve().parents[2] / "docs" / "late_readings.md"
TIMES = ("step_time_s",)
"""What a clock says of a run is its own."""


@cache
def model() -> StateSpaceModel:
    """A pen with a late camera."""
    return pen_model(load_pen("reference"), SENSORS)


@cache
def model_with_area() -> StateSpaceModel:
    """The same with a writing area, whose readings no sensor brings.

    The area's periods are longer than the IMU's: a frame that comes late may be a period's first.
    """
    built = pen_model(load_pen("reference"), (*SENSORS, "area"))
    sensors = [
        each if each.constant_reading is None else replace(each, rate_hz=40.0)
        for each in built.sensors
    ]
    return built.replace(sensors=tuple(sensors))


def recorded(duration_s: float) -> list[Reading]:
    recording = pm.simulate("reference", SENSORS, motion="handwriting", duration_s=duration_s)
    return readings_of(recording, np.random.default_rng(1), late="camera")


def one_by_one(estimator: Estimator[Any], recording: Recording) -> EstimateHistory:
    return run_measurements(estimator, recording.measurements(estimator.model, causal=True))


def check(estimator: Estimator[Any], duration_s: float, *, cuts: int, driver: Any) -> None:
    """Compare the estimates told until an instant with those of a recording changed after it."""
    readings, rng = recorded(duration_s), np.random.default_rng(2)
    whole = driver(estimator, recording_of("whole", readings))
    late = (np.diff(whole.arrival_s) > 0) & (np.diff(whole.time_s) == 0)
    assert late.sum() > 3
    for after_s in rng.uniform(0.5, 0.9, cuts) * duration_s:
        changed = driver(estimator, recording_of("changed", changed_after(readings, after_s, rng)))
        n = int(np.searchsorted(whole.arrival_s, after_s, side="right"))
        assert n == np.searchsorted(changed.arrival_s, after_s, side="right")
        assert 20 < n < len(whole)
        assert not np.array_equal(whole.mean[n], changed.mean[n])
        check_same(whole[:n], changed[:n])


def check_same(one: EstimateHistory, other: EstimateHistory) -> None:
    assert one.status == other.status
    for name in set(PER_STEP) - set(TIMES):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name), name)
    for lag, told in one.lagged.items():
        for ours, theirs in zip(told.arrays(), other.lagged[lag].arrays(), strict=True):
            np.testing.assert_array_equal(ours, theirs)


def causal_run(estimator: Estimator[Any], recording: Recording) -> EstimateHistory:
    return run(estimator, recording, causal=True)


DRIVERS = {"batch": causal_run, "step by step": one_by_one}


QUICK = [(name, driver) for name in ("ekf", "mhe-rti") for driver in DRIVERS] + [("mhe", "batch")]


@needs_compiler
@pytest.mark.parametrize(("name", "driver"), QUICK)
def test_what_arrives_later_changes_no_estimate(name: str, driver: str) -> None:
    estimator = pm.create_estimator(name, model(), **SETTINGS[name])
    check(estimator, QUICK_S, cuts=2, driver=DRIVERS[driver])


def test_later_arrivals_change_no_row_before() -> None:
    """What estimators are given, whatever they make of it: the writing area's readings too."""
    readings, rng = recorded(LONG_S), np.random.default_rng(3)
    whole = recording_of("whole", readings).as_arrived(model_with_area())
    for after_s in rng.uniform(0.2, 0.9, 20) * LONG_S:
        changed = recording_of("changed", changed_after(readings, after_s, rng))
        n = int(np.searchsorted(whole[2], after_s, side="right"))
        for one, other in zip(whole, changed.as_arrived(model_with_area()), strict=True):
            np.testing.assert_array_equal(one[:n], other[:n])


@pytest.mark.usefixtures("interpreted")
@pytest.mark.parametrize("name", ["ekf", "mhe-rti"])
def test_nor_do_inputs_that_come_later(name: str) -> None:
    """Those of a model of one's own, at instants of their own."""
    rng, walk, settings = np.random.default_rng(6), forced_walk(inputs=("force",)), {}
    if name != "ekf":
        settings = {"horizon": 8, "lag_samples": (3, 4)}
    times = {"encoder": 0.01 * np.arange(30), "camera": 0.003 + 0.03 * np.arange(10)}
    plain = Recording.from_sensors(
        "plain", {key: (at, rng.standard_normal((len(at), 1))) for key, at in times.items()}
    )
    readings, force_s, after_s = readings_of(plain, rng, late="camera"), 0.007 * np.arange(42), 0.2
    force = rng.standard_normal(42)
    later = np.where(force_s > after_s, rng.standard_normal(42), force)
    estimator = pm.create_estimator(name, walk, **settings)
    whole = causal_run(estimator, recording_of("whole", readings, {"force": (force_s, force)}))
    changed_readings = changed_after(readings, after_s, rng)
    kept = (force_s <= after_s) | (rng.random(42) > 1 / 3)
    changed = causal_run(
        estimator,
        recording_of("changed", changed_readings, {"force": (force_s[kept], later[kept])}),
    )
    n = int(np.searchsorted(whole.arrival_s, after_s, side="right"))
    assert n == np.searchsorted(changed.arrival_s, after_s, side="right") > 40
    check_same(whole[:n], changed[:n])
    assert not np.array_equal(whole.mean[-1], changed.mean[-1])


@pytest.mark.slow
@needs_compiler
@pytest.mark.parametrize("driver", DRIVERS)
@pytest.mark.parametrize("name", ["ekf", "mhe-rti", "mhe"])
def test_nor_in_a_longer_recording(name: str, driver: str) -> None:
    estimator = pm.create_estimator(name, model_with_area(), **SETTINGS[name])
    check(estimator, LONG_S, cuts=6, driver=DRIVERS[driver])


@pytest.mark.slow
@pytest.mark.parametrize("name", ["ekf", "mhe-rti", "mhe", "mhe-ipopt"])
def test_nor_interpreted_or_by_ipopt(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("estimation.native.compiler", lambda: None)
    estimator = pm.create_estimator(name, model_with_area(), **SETTINGS[name])
    check(estimator, QUICK_S, cuts=1, driver=one_by_one)


@needs_compiler
def test_the_page_runs() -> None:
    names = run_python(PAGE)
    samples = names["samples"]
    np.testing.assert_array_equal(names["known"].arrival_s, samples)
    np.testing.assert_array_equal(names["later"].arrival_s, samples[14:])
    np.testing.assert_array_equal(names["later"].time_s, samples[:-14])
