"""The EKF's steps: splitting changes nothing; late, empty and infinite readings."""

from __future__ import annotations

import numpy as np
import pytest

from ekf_baseline.ekf import Ekf, EkfConfig
from estimation.recording import Measurement
from estimation.status import Status
from models.arrays import Array
from models.state_space import StateSpaceModel
from tests.estimation.pens import draw_pen_run
from tests.linear_models import constant_acceleration_system, coupled_system, irregular_times

TOLERANCE_STD = 1e-10


def empty(time_s: float, like: Array) -> Measurement:
    return Measurement(time_s, np.full_like(like, np.nan))


def cases() -> dict[str, tuple[StateSpaceModel, list[Measurement]]]:
    rng = np.random.default_rng(21)
    pen, ca, coupled = draw_pen_run(40, 2), constant_acceleration_system(2), coupled_system(1)
    return {
        "pen": (pen.model, pen.measurements),
        "constant acceleration": (ca.model, ca.simulate(irregular_times(60, rng), rng)),
        "coupled": (coupled.model, coupled.simulate(irregular_times(60, rng), rng)),
    }


CASES = cases()


@pytest.mark.parametrize("name", CASES)
def test_empty_stages_in_between_change_nothing(name: str) -> None:
    model, measurements = CASES[name]
    ekf = Ekf(model)
    plain = split = ekf.init()
    last = measurements[0].time_s
    for k, measurement in enumerate(measurements):
        plain, wanted = ekf.step(plain, measurement)
        for share in (0.3, 0.31, 0.9)[: k % 4]:
            between = last + share * (measurement.time_s - last)
            split, filled = ekf.step(split, empty(between, measurement.y))
            assert Status.NO_READING in filled.status
        split, estimate = ekf.step(split, measurement)
        last, std = measurement.time_s, wanted.state.std
        error = np.asarray(model.difference(estimate.state.mean, wanted.state.mean)).ravel() / std
        error_P = (estimate.state.covariance - wanted.state.covariance) / np.outer(std, std)
        assert np.abs(error).max() < TOLERANCE_STD
        assert np.abs(error_P).max() < TOLERANCE_STD


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize(("late_samples", "place"), [(0, 18), (4, 13)])
def test_a_measurement_beyond_reach_is_flagged_and_changes_nothing(
    name: str, late_samples: int, place: int
) -> None:
    model, measurements = CASES[name]
    ekf = Ekf(model, EkfConfig(late_samples=late_samples))
    state = ekf.init()
    for measurement in measurements[:20]:
        state, before = ekf.step(state, measurement)
    late = Measurement(measurements[place].time_s, measurements[25].y)
    after, estimate = ekf.step(state, late)
    assert estimate.status is Status.LATE
    assert estimate.time_s == before.time_s == after.time_s
    np.testing.assert_array_equal(estimate.state.mean, before.state.mean)
    np.testing.assert_array_equal(after.gaussian.mean, state.gaussian.mean)
    np.testing.assert_array_equal(after.gaussian.covariance, state.gaussian.covariance)
    assert after.n_rows == state.n_rows


def test_a_late_measurement_is_not_said_to_lack_readings() -> None:
    """The sentence "no sensor had a reading" would be false: it had one, too late."""
    model, measurements = CASES["coupled"]
    ekf = Ekf(model, EkfConfig(late_samples=0))
    state = ekf.init()
    for measurement in measurements[:3]:
        state, _ = ekf.step(state, measurement)
    late = Measurement(measurements[0].time_s, np.array([0.1, 0.2, 0.3]))
    _, estimate = ekf.step(state, late)
    assert estimate.status is Status.LATE


def test_no_reading_gives_the_prediction() -> None:
    system = coupled_system(1)
    ekf = Ekf(system.model)
    y = np.array([0.3, -0.2, 0.1])
    state, first = ekf.step(ekf.init(), Measurement(2.0, y))
    _, estimate = ekf.step(state, empty(2.4, y))
    assert estimate.status is Status.NO_READING
    wanted = system.F(0.4) @ first.state.mean
    wanted_P = system.F(0.4) @ first.state.covariance @ system.F(0.4).T + system.Q(0.4)
    np.testing.assert_allclose(estimate.state.mean, wanted, rtol=0, atol=1e-12)
    np.testing.assert_allclose(estimate.state.covariance, wanted_P, rtol=0, atol=1e-12)


@pytest.mark.parametrize("bad", [np.inf, -np.inf])
def test_an_infinite_reading_is_flagged_and_counts_as_missing(bad: float) -> None:
    model, measurements = CASES["coupled"]
    ekf = Ekf(model)
    state, _ = ekf.step(ekf.init(), measurements[0])
    time_s, y = measurements[1].time_s, np.array([bad, 0.1, 0.1])
    _, estimate = ekf.step(state, Measurement(time_s, y))
    _, wanted = ekf.step(state, Measurement(time_s, np.where(np.isinf(y), np.nan, y)))
    assert estimate.status is Status.INFINITE_READING
    np.testing.assert_array_equal(estimate.state.mean, wanted.state.mean)
    np.testing.assert_array_equal(estimate.state.covariance, wanted.state.covariance)
    np.testing.assert_array_equal(np.isnan(estimate.innovation), [True, False, False])


def test_inputs_are_not_changed() -> None:
    model, measurements = CASES["coupled"]
    ekf = Ekf(model)
    state = ekf.init()
    y = measurements[0].y.copy()
    mean, covariance = state.gaussian.mean.copy(), state.gaussian.covariance.copy()
    ekf.step(state, measurements[0])
    np.testing.assert_array_equal(measurements[0].y, y)
    np.testing.assert_array_equal(state.gaussian.mean, mean)
    np.testing.assert_array_equal(state.gaussian.covariance, covariance)
