"""A recording in one compiled call is the same as its steps, to the last bit."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from ekf_baseline.ekf import Ekf, EkfConfig
from estimation.estimate import EstimateHistory
from estimation.estimator import BatchEstimator, run, run_measurements
from estimation.recording import Measurement, Recording
from mhe.config import MheConfig, MheRtiConfig
from mhe.realtime import Mhe, MheRti
from models.arrays import Array
from models.state_space import StateSpaceModel
from tests.disturbed import LATE_AT, disturbed
from tests.estimation import pens

RUN = pens.draw_pen_run(40, seed=11)
MEASUREMENTS = disturbed(RUN.measurements)
TIMES, Y = np.array([m.time_s for m in MEASUREMENTS]), np.array([m.y for m in MEASUREMENTS])
LOSSES: dict[str, Any] = {"huber": {"accel": 2.0}, "sparse_noise": 2.0}

ESTIMATORS: dict[str, Callable[[StateSpaceModel], Any]] = {
    "ekf": Ekf,
    "ekf that keeps nothing": lambda model: Ekf(model, EkfConfig(late_samples=0)),
    "ekf with a gate": lambda model: Ekf(model, EkfConfig(gate_probability=0.99)),
    "mhe-rti": lambda model: MheRti(model, MheRtiConfig(horizon=4)),
    "mhe-rti, smoothed": lambda model: MheRti(
        model, MheRtiConfig(horizon=4, arrival_cost="smoothed")
    ),
    "mhe": lambda model: Mhe(model, MheConfig(horizon=4)),
    "mhe with losses": lambda model: Mhe(model, MheConfig(horizon=4, **LOSSES)),
}
COMPARED = (
    "time_s",
    "mean",
    "covariance",
    "innovation",
    "innovation_covariance",
    "iterations",
    "std",
    "innovation_std",
    "squared_innovations",
)


@pytest.fixture(params=ESTIMATORS)
def estimator(request: pytest.FixtureRequest) -> Any:
    return ESTIMATORS[request.param](RUN.model)


def assert_same(one: EstimateHistory, other: EstimateHistory) -> None:
    for name in COMPARED:
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name), err_msg=name)
    assert one.status == other.status


def test_equals_the_loop(estimator: Any) -> None:
    """With a late, an empty, an infinite and an absurd measurement in the middle."""
    looped = run_measurements(estimator, MEASUREMENTS, covariances=True)
    _, history = estimator.batch(estimator.init(), TIMES, Y, covariances=True)
    assert_same(history, looped)
    assert history.estimator == looped.estimator == estimator.name
    assert history.time_s[LATE_AT] == history.time_s[LATE_AT - 1]
    assert (history.step_time_s > 0).all()


@pytest.mark.usefixtures("interpreted")
@pytest.mark.parametrize("name", ESTIMATORS)
def test_equals_the_loop_without_a_compiler(name: str) -> None:
    estimator = ESTIMATORS[name](RUN.model)
    _, history = estimator.batch(estimator.init(), TIMES[:24], Y[:24], covariances=True)
    assert_same(history, run_measurements(estimator, MEASUREMENTS[:24], covariances=True))


@pytest.mark.cover
@pytest.mark.parametrize("cut", [1, 3, LATE_AT, LATE_AT + 1, 30])
def test_a_batch_goes_on_where_another_ended(estimator: Any, cut: int) -> None:
    _, whole = estimator.batch(estimator.init(), TIMES, Y, covariances=True)
    state, first = estimator.batch(estimator.init(), TIMES[:cut], Y[:cut], covariances=True)
    kept = [array.copy() for array in arrays(state)]
    state_after, second = estimator.batch(state, TIMES[cut:], Y[cut:], covariances=True)
    assert_same(EstimateHistory.joined([first, second]), whole)
    for array, copy in zip(arrays(state), kept, strict=True):
        np.testing.assert_array_equal(array, copy)
    after, estimate = estimator.step(state_after, Measurement(TIMES[-1] + 0.01, Y[-1]))
    looped = run_measurements(
        estimator, [*MEASUREMENTS, Measurement(TIMES[-1] + 0.01, Y[-1])], covariances=True
    )
    np.testing.assert_array_equal(estimate.state.mean, looped.mean[-1])
    assert after is not state_after


def arrays(state: Any) -> list[Array]:
    if hasattr(state, "memory"):
        return [state.memory]
    return [state.gaussian.mean, state.gaussian.covariance]


def test_nothing_is_a_batch_too(estimator: Any) -> None:
    state, history = estimator.batch(estimator.init(), TIMES[:0], Y[:0], covariances=True)
    assert len(history) == 0
    assert history.mean.shape == (0, 15)
    _, after = estimator.batch(state, TIMES, Y, covariances=True)
    assert_same(after, estimator.batch(estimator.init(), TIMES, Y, covariances=True)[1])


def test_inputs_are_not_changed(estimator: Any) -> None:
    time_s, y, state = TIMES.copy(), Y.copy(), estimator.init()
    before = [array.copy() for array in arrays(state)]
    estimator.batch(state, time_s, y, covariances=True)
    np.testing.assert_array_equal(time_s, TIMES)
    np.testing.assert_array_equal(y, Y)
    for array, copy in zip(arrays(state), before, strict=True):
        np.testing.assert_array_equal(array, copy)


def test_a_recording_is_run_in_batches(estimator: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """The driver's parts are the whole, and it tells how far it is."""
    monkeypatch.setattr("estimation.collect.BATCH_STEPS", 7)
    assert isinstance(estimator, BatchEstimator)
    times, y = (np.array([getattr(m, name) for m in RUN.measurements]) for name in ("time_s", "y"))
    parts = zip(("accel", "gyro", "camera"), np.split(y, [3, 6], axis=1), strict=True)
    recording = Recording("r", times, dict(parts))
    told: list[int] = []
    history = run(estimator, recording, on_progress=told.append, covariances=True)
    one_by_one = run(estimator, recording, on_step=lambda estimate: None, covariances=True)
    assert_same(history, one_by_one)
    assert sum(told) == len(history) == 40
    assert max(told) == 7


def test_any_memory_is_accepted(estimator: Any) -> None:
    """Read-only, strided, in Fortran's order, big-endian, with half the digits."""
    _, wanted = estimator.batch(estimator.init(), TIMES, Y, covariances=True)
    frozen = Y.copy()
    frozen.setflags(write=False)
    strided = np.repeat(Y, 2, axis=1)[:, ::2]
    for y in (frozen, strided, np.asfortranarray(Y), Y.astype(">f8")):
        _, history = estimator.batch(estimator.init(), TIMES, y, covariances=True)
        assert_same(history, wanted)
        looped = [Measurement(t, row) for t, row in zip(TIMES, y, strict=True)]
        assert_same(run_measurements(estimator, looped, covariances=True), wanted)
    with np.errstate(over="ignore"):
        half = Y.astype(np.float32)
    _, rounded = estimator.batch(estimator.init(), TIMES, half, covariances=True)
    _, exact = estimator.batch(estimator.init(), TIMES, half.astype(np.float64), covariances=True)
    assert_same(rounded, exact)
    looped = [Measurement(t, row) for t, row in zip(TIMES, half, strict=True)]
    assert_same(run_measurements(estimator, looped, covariances=True), exact)


def test_one_instance_carries_nothing_from_one_stream_to_another(estimator: Any) -> None:
    """The workspace is scratch: two streams in turn are two streams."""
    other = pens.draw_pen_run(20, seed=5).measurements
    wanted = [
        run_measurements(estimator, stream, covariances=True)
        for stream in (MEASUREMENTS[:20], other)
    ]
    states, found = [estimator.init(), estimator.init()], ([], [])  # type: ignore[var-annotated]
    for pair in zip(MEASUREMENTS[:20], other, strict=True):
        for i, measurement in enumerate(pair):
            states[i], estimate = estimator.step(states[i], measurement)
            found[i].append(estimate.state.mean)
    for history, means in zip(wanted, found, strict=True):
        np.testing.assert_array_equal(history.mean, means)
