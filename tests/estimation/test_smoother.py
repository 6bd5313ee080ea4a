"""Forth and back over a whole recording: on linear models the textbook's smoother."""

from __future__ import annotations

import numpy as np
import pytest

import pen_mhe as pm
from ekf_baseline.ekf import Ekf
from estimation.consistency import nees
from estimation.estimator import run
from estimation.recording import Recording
from estimation.smoother import smoothed
from models.errors import InputError
from models.state_space import StateSpaceModel
from tests.linear_models import (
    LinearSystem,
    constant_acceleration_system,
    coupled_system,
    irregular_times,
)
from tests.references import smoother

SYSTEMS = {"axes": constant_acceleration_system(2, density=20.0), "coupled": coupled_system(3)}


def recorded(system: LinearSystem, n: int) -> tuple[Recording, list[np.ndarray]]:
    rng = np.random.default_rng(4)
    measurements = system.simulate(irregular_times(n, rng), rng, missing=0.0)
    rows = [m.y for m in measurements]
    readings, at = {}, 0
    for sensor in system.model.sensors:
        values = np.array(rows)[:, at : at + sensor.n_y].copy()
        values[rng.uniform(size=n) < 0.35] = np.nan
        readings[sensor.name] = values
        at += sensor.n_y
    times = np.array([m.time_s for m in measurements])
    return Recording("linear", times, readings), list(np.hstack(list(readings.values())))


@pytest.mark.parametrize("which", SYSTEMS)
def test_on_linear_models_it_is_the_textbooks(which: str) -> None:
    system = SYSTEMS[which]
    recording, rows = recorded(system, 60)
    times, prior = list(recording.time_s), system.model.prior
    filtered = smoother.run(
        (prior.mean, prior.covariance), times, rows, system.F, system.Q, system.H, system.R
    )
    history = run(Ekf(system.model), recording, covariances=True)
    found = smoothed(system.model, recording, history)
    for k in range(len(times)):
        lag = len(times) - 1 - k
        x, P = smoother.smoothed(filtered, times, system.F, system.Q, len(times) - 1, lag)
        std = np.sqrt(np.diag(P))
        assert np.abs((found.mean[k] - x) / std).max() < 1e-9
        assert np.abs((found.covariance[k] - P) / np.outer(std, std)).max() < 1e-9
    np.testing.assert_array_equal(found.mean[-1], history.mean[-1])
    np.testing.assert_array_equal(found.std[-1], history.std[-1])


@pytest.fixture(scope="module")
def pen() -> tuple[StateSpaceModel, Recording]:
    sensors = ["accel", "gyro", "camera"]
    model = pm.pen_model("reference", sensors)
    return model, pm.simulate("reference", sensors, motion="handwriting", duration_s=1.0, seed=2)


def test_a_pen_is_better_known_and_no_surer_than_it_may_be(
    pen: tuple[StateSpaceModel, Recording],
) -> None:
    model, recording = pen
    history = run(Ekf(model), recording, covariances=True)
    found = smoothed(model, recording, history)
    assert recording.truth is not None
    truth = recording.truth.states(model.state_names, recording.time_s)
    tip = [found.index(f"tip_{axis}_m") for axis in "xyz"]
    before, after = (
        np.sqrt(np.mean(h.errors(recording.truth)[:, tip] ** 2)) for h in (history, found)
    )
    assert after < 0.8 * before
    assert np.nanmean(nees(model, found, truth)) < 1.5 * model.n_x
    assert (
        np.linalg.eigvalsh(found.covariance / np.einsum("ki,kj->kij", found.std, found.std)) > -1e-9
    ).all()
    assert np.isnan(found.innovation).all()


def test_what_makes_no_sense_is_refused(pen: tuple[StateSpaceModel, Recording]) -> None:
    model, recording = pen
    short = recording.first(0.1)
    with pytest.raises(InputError, match="kept standard deviations only"):
        smoothed(model, short, run(Ekf(model), short))
    with pytest.raises(InputError, match="expected one estimate at each of its instants"):
        smoothed(model, recording, run(Ekf(model), short, covariances=True))
    with pytest.raises(InputError, match="a filter's estimates and mhe-rti is none, expected ekf"):
        pm.estimate(short, sensors=["accel", "gyro", "camera"], smooth=True)


def test_in_one_call(pen: tuple[StateSpaceModel, Recording]) -> None:
    _, recording = pen
    options = {"sensors": ["accel", "gyro", "camera"], "estimator": "ekf"}
    part = recording.first(0.4)
    plain, found = (pm.estimate(part, **options, smooth=each) for each in (False, True))
    assert len(found.output) == len(plain.output)
    assert found.true_rms["tip_mm"] < plain.true_rms["tip_mm"]
    assert any(sentence.startswith("smoothed: ") for sentence in found.sentences())
    assert found.nis is not None
    assert plain.nis is not None
    assert found.nis.mean == plain.nis.mean
