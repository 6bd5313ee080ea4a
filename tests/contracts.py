"""What every model and every estimator must keep: checks, called by test_contracts."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from estimation.estimate import EstimateHistory
from estimation.estimator import Estimator
from estimation.recording import Measurement
from estimation.status import Status
from models.state_space import StateSpaceModel
from models.units import UNITS, split_unit

SMALLEST_CORRELATION_EIGENVALUE = -1e-10


def check_model(model: StateSpaceModel, rng: np.random.Generator) -> None:
    """Shapes, units, manifold and finiteness of a model."""
    assert len(set(model.state_names)) == model.n_x
    check_names(model.state_names, model.state_units)
    if model.outputs is not None:
        check_names(model.outputs.names, model.outputs.units)
        assert len(set(model.outputs.names)) == len(model.outputs.names)
    start = model.retract(model.prior.mean, model.prior.std * rng.standard_normal(model.n_x))
    x = np.asarray(start).ravel()
    w = rng.standard_normal(model.n_w)
    assert np.asarray(model.f(x, w, 0.01)).shape == (model.n_x, 1)
    still = np.asarray(model.f(x, w, 0.0)).ravel()
    np.testing.assert_allclose(still, x, atol=1e-12)
    delta = rng.normal(0, 0.1, model.n_x)
    back = np.asarray(model.difference(model.retract(x, delta), x)).ravel()
    np.testing.assert_allclose(back, delta, atol=1e-9)
    for sensor in model.sensors:
        y = np.asarray(sensor.h(x)).ravel()
        residual = np.asarray(sensor.residual(y, x)).ravel()
        assert y.shape == (sensor.n_y,)
        assert residual.shape == (sensor.n_r,) == (len(sensor.unit_of_row),)
        assert len(sensor.unit_of_axis) == sensor.n_y
        np.testing.assert_allclose(residual, 0, atol=1e-9)
        assert (sensor.noise_std > 0).all()


def check_names(names: Sequence[str], units: Sequence[str]) -> None:
    """A name ends in its unit; one of a pure number has none."""
    for name, of_name in zip(names, units, strict=True):
        stem, unit = split_unit(name)
        assert stem
        if of_name == "1":
            assert not unit, f"{name} is a pure number and ends in {unit}"
        else:
            assert unit in UNITS, f"{name} ends in no unit"


def check_history(model: StateSpaceModel, history: EstimateHistory, n_steps: int) -> None:
    """Shapes, no NaN, positive covariances, a status with a sentence for every step."""
    n_x, n_r = model.n_x, model.n_r
    assert history.mean.shape == (n_steps, n_x)
    assert history.covariance.shape == (n_steps, n_x, n_x)
    assert history.innovation.shape == (n_steps, n_r)
    assert history.innovation_covariance.shape == (n_steps, n_r, n_r)
    assert np.isfinite(history.mean).all()
    assert np.isfinite(history.covariance).all()
    np.testing.assert_array_equal(history.covariance, history.covariance.transpose(0, 2, 1))
    correlation = history.covariance / (history.std[:, :, None] * history.std[:, None, :])
    assert np.linalg.eigvalsh(correlation).min() >= SMALLEST_CORRELATION_EIGENVALUE
    for status in history.status:
        assert status.sentence.endswith(".")
    names = model.state_names if model.outputs is None else model.outputs.names
    assert history.names == names
    assert history.values.shape == history.values_std.shape == (n_steps, len(names))
    assert (history.values_std >= 0).all()
    table = history.to_pandas()
    expected = ["time_s", *names, *(f"{name}_std" for name in names)]
    assert list(table.columns) == [*expected, "status", "iterations", "step_time_s"]
    assert not table.isna().to_numpy().any()


def check_inputs_unchanged(estimator: Estimator[Any], measurements: list[Measurement]) -> None:
    """A step changes neither the measurement nor the state that it is given."""
    state = estimator.init()
    for measurement in measurements:
        y = measurement.y.copy()
        before = list(arrays_within(state))
        copies = [array.copy() for array in before]
        estimator_state, _ = estimator.step(state, measurement)
        np.testing.assert_array_equal(measurement.y, y)
        for array, copy in zip(before, copies, strict=True):
            np.testing.assert_array_equal(array, copy)
        state = estimator_state


def check_failures(estimator: Estimator[Any], measurements: list[Measurement]) -> None:
    """Late, empty and absurd readings: a status with a sentence, finite numbers."""
    model, state = estimator.model, estimator.init()
    for measurement in measurements:
        state, estimate = estimator.step(state, measurement)
    newest = measurements[-1].time_s
    late = Measurement(newest - 0.005, measurements[-1].y)
    before, (_, estimate) = estimate, estimator.step(state, late)
    assert np.array_equal(estimate.state.mean, before.state.mean) == (
        Status.LATE in estimate.status
    )
    assert estimate.time_s == newest
    assert np.isfinite(estimate.state.mean).all()
    assert np.isfinite(estimate.state.covariance).all()
    assert estimate.time_s == newest
    assert np.isfinite(estimate.state.mean).all()
    empty = Measurement(newest + 0.005, np.full(model.n_y, np.nan))
    _, estimate = estimator.step(state, empty)
    assert Status.NO_READING in estimate.status
    assert np.isfinite(estimate.state.mean).all()
    infinite = Measurement(newest + 0.005, np.full(model.n_y, np.inf))
    _, estimate = estimator.step(state, infinite)
    assert Status.INFINITE_READING in estimate.status
    assert np.isfinite(estimate.state.mean).all()
    absurd = Measurement(newest + 0.005, np.full(model.n_y, 1e200))
    _, estimate = estimator.step(state, absurd)
    assert np.isfinite(estimate.state.mean).all()
    assert np.isfinite(estimate.state.covariance).all()


def arrays_within(value: Any) -> Iterator[np.ndarray]:
    """Go through all arrays inside nested dataclasses and tuples."""
    if isinstance(value, np.ndarray):
        yield value
    elif isinstance(value, tuple):
        for item in value:
            yield from arrays_within(item)
    elif is_dataclass(value):
        for field in fields(value):
            yield from arrays_within(getattr(value, field.name))
