"""The driver, the history of a run and its table."""

from __future__ import annotations

import csv
import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmark.bodies import BODIES
from ekf_baseline.ekf import Ekf
from estimation.collect import collected
from estimation.estimate import Estimate, EstimateHistory
from estimation.estimator import run, run_measurements
from estimation.recording import Recording, Truth
from estimation.status import Status
from models.errors import InputError
from models.gaussian import GaussianState
from models.turntable import paper_turntable, turntable_model
from tests.benchmark.hand_made import history as history_of
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
    history = run(Ekf(SYSTEM.model), data, on_step=seen.append, covariances=True)
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
    history = run(Ekf(SYSTEM.model), recording(), covariances=True)
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
    history = collected("x", SYSTEM.model, estimates, [0.1] * 4)
    assert history.solved_fraction == 0.5
    assert history.std.shape == (4, 3)


def test_a_stream_without_measurements_gives_an_empty_table() -> None:
    history = run_measurements(Ekf(SYSTEM.model), [], covariances=True)
    assert len(history) == len(history.to_pandas()) == 0
    assert history.mean.shape == (0, 3)
    assert history.covariance.shape == (0, 3, 3)


def test_slices_are_histories() -> None:
    history = run(Ekf(SYSTEM.model), recording(), covariances=True)
    for rows in (slice(2, 7), slice(None, None, 3), np.array([0, 5, 11]), history.time_s > 0.2):
        part = history[rows]
        np.testing.assert_array_equal(part.mean, history.mean[rows])
        np.testing.assert_array_equal(part.std, history.std[rows])
        np.testing.assert_array_equal(part.covariance, history.covariance[rows])
        np.testing.assert_array_equal(part.innovation_std, history.innovation_std[rows])
        numbers = np.arange(len(history))[rows]
        assert part.status == tuple(history.status[k] for k in numbers)
        assert len(part) == len(numbers)
        assert part.estimator == "ekf"
    with pytest.raises(InputError, match=r"asked for \[3\], expected a slice or an array"):
        history[3]  # type: ignore[index]


def test_a_part_between_two_times_has_both() -> None:
    history = run(Ekf(SYSTEM.model), recording())
    first, last = float(history.time_s[3]), float(history.time_s[6])
    np.testing.assert_array_equal(history.between(first, last).time_s, history.time_s[3:7])
    np.testing.assert_array_equal(history.between(start_s=first).time_s, history.time_s[3:])
    np.testing.assert_array_equal(history.between(end_s=last).time_s, history.time_s[:7])
    assert len(history.between(first + 1e-4, first + 2e-4)) == 0
    with pytest.raises(InputError, match=r"from 2 s to 1 s, expected an end after the start"):
        history.between(2.0, 1.0)


def test_parts_are_joined_to_the_whole() -> None:
    history = run(Ekf(SYSTEM.model), recording(), covariances=True)
    parts = [history[:5], history[5:6], history[6:6], history[6:]]
    for joined in (EstimateHistory.joined(parts), EstimateHistory.joined(iter(parts), 12)):
        np.testing.assert_array_equal(joined.mean, history.mean)
        np.testing.assert_array_equal(joined.covariance, history.covariance)
        np.testing.assert_array_equal(joined.squared_innovations, history.squared_innovations)
        assert joined.status == history.status
    with pytest.raises(InputError, match="no part of a history"):
        EstimateHistory.joined([])


def test_a_file_has_the_table_with_every_digit(tmp_path: Path) -> None:
    history = run(Ekf(SYSTEM.model), recording())
    path = tmp_path / "history.csv"
    history.to_csv(path)
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    table = history.to_pandas()
    assert list(rows[0]) == list(table.columns)
    for name in table.columns:
        wanted = table[name].tolist()
        assert [type(wanted[0])(row[name]) for row in rows] == wanted, name


def test_a_prompt_shows_one_line() -> None:
    history = run(Ekf(SYSTEM.model), recording())
    text = repr(history)
    assert "\n" not in text
    assert text.startswith("<EstimateHistory of ekf: 12 steps, 0.1 s to 0.32 s, 3 states, 100.00%")
    assert repr(history[:0]) == "<EstimateHistory of ekf: no steps, 3 states>"


def test_a_notebook_shows_a_table_of_the_states() -> None:
    model = turntable_model(paper_turntable())
    names = model.state_names
    mean, std = np.radians([[10.0, 20.0, 30.0, 40.0]] * 2), np.radians([[1.0, 2.0, 3.0, 4.0]] * 2)
    hand = dataclasses.replace(
        history_of(names, np.array([0.0, 1.0]), mean), std=std, estimator="<mhe>"
    )
    html = hand._repr_html_()
    for text in (
        "tilt phi",
        "tilt theta rate",
        "deg/s",
        "10 ± 1",
        "40 ± 4",
        "solved 2",
        "&lt;mhe&gt;",
    ):
        assert text in html, text
    assert html.count("<tr>") == 1 + len(names)
    assert "no steps" in hand[:0]._repr_html_()


def test_errors_go_the_short_way_round() -> None:
    model = turntable_model(paper_turntable())
    times, near = np.array([0.0, 1.0]), np.pi - 0.01
    mean = np.array([[near, 0.1, 0.2, 0.3], [0.0, 0.1, 0.2, 0.3]])
    truth = Truth(times, model.state_names[:1], np.array([[-near], [0.5]]))
    hand = history_of(model.state_names, times, mean)
    with_model = dataclasses.replace(hand, difference=model.difference)
    np.testing.assert_allclose(with_model.errors(truth)[:, 0], [-0.02, -0.5], atol=1e-12)
    np.testing.assert_allclose(hand.errors(truth)[:, 0], [2 * near, -0.5], atol=1e-12)
    assert np.isnan(with_model.errors(truth)[:, 1:]).all()


def test_no_steps_have_no_errors_and_are_at_no_instant() -> None:
    model = BODIES["turntable"]().model()  # whose angles wrap
    data = BODIES["turntable"]().record(0.1, 0)
    history = run(Ekf(model), data)
    assert data.truth is not None
    none = history[:0]
    assert none.errors(data.truth).shape == (0, model.n_x)
    with pytest.raises(InputError, match=r"no estimate at 0\.1 s"):
        none.at(np.array([0.1]))
    assert len(history.at(history.time_s[3])) == 1


@pytest.mark.parametrize(
    "rows", [3, slice(0.1, 0.2), np.ones(3, bool), np.array([0.5]), np.zeros((2, 2), int)]
)
def test_what_is_no_choice_of_steps_is_refused(rows: Any) -> None:
    with pytest.raises(InputError, match="expected a slice or an array of steps"):
        run(Ekf(SYSTEM.model), recording())[rows]


def test_parts_that_are_fewer_than_the_whole_are_refused() -> None:
    part = run(Ekf(SYSTEM.model), recording())[:2]
    with pytest.raises(InputError, match="parts of 2 steps in all, expected 5"):
        EstimateHistory.joined([part], 5)
