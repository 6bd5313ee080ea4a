"""The driver, the history of a run and its table."""

from __future__ import annotations

import numpy as np

from ekf_baseline.ekf import Ekf
from estimation.estimate import Estimate, EstimateHistory
from estimation.estimator import run, run_measurements
from estimation.recording import Recording
from estimation.status import Status
from models.gaussian import GaussianState
from tests.linear_models import constant_acceleration_system

SYSTEM = constant_acceleration_system(1)


def recording(n: int = 12) -> Recording:
    rng = np.random.default_rng(8)
    measurements = SYSTEM.simulate(0.1 + 0.02 * np.arange(n), rng, missing=0.3)
    y = np.array([m.y for m in measurements])
    times = np.array([m.time_s for m in measurements])
    y[4] = np.nan
    return Recording("r", times, {"position": y[:, :1], "acceleration": y[:, 1:]})


def test_run_is_the_loop_of_steps() -> None:
    data, seen = recording(), []
    history = run(Ekf(SYSTEM.model), data, on_step=seen.append)
    ekf = Ekf(SYSTEM.model)
    state = ekf.init()
    for k, measurement in enumerate(data.measurements(SYSTEM.model)):
        state, estimate = ekf.step(state, measurement)
        np.testing.assert_array_equal(history.mean[k], estimate.state.mean)
        np.testing.assert_array_equal(history.covariance[k], estimate.state.covariance)
        np.testing.assert_array_equal(history.innovation[k], estimate.innovation)
        np.testing.assert_array_equal(seen[k].state.mean, estimate.state.mean)
        assert history.status[k] is estimate.status
    assert len(history) == len(seen) == 12
    assert history.estimator == "ekf"
    assert (history.step_time_s > 0).all()
    np.testing.assert_array_equal(history.time_s, data.time_s)


def test_table_has_the_states_their_deviations_and_the_status() -> None:
    history = run(Ekf(SYSTEM.model), recording())
    table = history.to_pandas()
    names = list(SYSTEM.model.state_names)
    assert list(table.columns) == [
        "time_s",
        *names,
        *(f"{name}_std" for name in names),
        "status",
        "iterations",
        "step_time_s",
    ]
    np.testing.assert_array_equal(table["s1_m"], history.mean[:, 1])
    np.testing.assert_array_equal(table["s2_m_std"], np.sqrt(history.covariance[:, 2, 2]))
    np.testing.assert_array_equal(history.column("s1_m"), history.mean[:, 1])
    assert table["status"][4] == "no_reading"
    assert table["status"][0] == "solved"
    assert table["iterations"].dtype.kind == "i"


def test_solved_fraction_counts_remarks_as_solved() -> None:
    gaussian = GaussianState(np.zeros(3), np.eye(3))
    statuses = [
        Status.SOLVED,
        Status.NO_READING | Status.NEAR_SINGULAR,
        Status.ITERATION_LIMIT,
        Status.NEAR_SINGULAR | Status.INFEASIBLE,
    ]
    estimates = [
        Estimate(float(k), gaussian, status, np.zeros(2), np.eye(2))
        for k, status in enumerate(statuses)
    ]
    history = EstimateHistory.collect("x", SYSTEM.model, estimates, [0.1] * 4)
    assert history.solved_fraction == 0.5
    assert history.std.shape == (4, 3)


def test_a_stream_without_measurements_gives_an_empty_table() -> None:
    history = run_measurements(Ekf(SYSTEM.model), [])
    assert len(history) == len(history.to_pandas()) == 0
    assert history.mean.shape == (0, 3)
    assert history.covariance.shape == (0, 3, 3)
