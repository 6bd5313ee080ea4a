"""What is judged of a run on the table, against loops over hand-made errors; who sees what."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import suites.pen.turntable_starts
from benchmark.tasks.task import Outcome, Quantity, Task
from estimation.estimator import run
from models.turntable import TILTS
from suites.pen import table_run
from suites.pen.table_run import (
    DEG,
    STARTS,
    STROKES,
    near_corner,
    run_stroke,
    run_wrong_start,
    settling_time,
    stroke_quantities,
)
from suites.pen.turntable_starts import StartRun, StartTrial, run_start

SEEN = {f"{tilt}{state}": True for tilt in TILTS for state in ("_rad", "_rate_rad_s")}
TIME_S = np.round(np.arange(0, 6.001, 0.01), 10) + 2.0
CORNERS_S = np.array([3.5, 3.75, 6.0]) + 0.0


def by_name(quantities: list[Quantity] | tuple[Quantity, ...]) -> Mapping[str, Quantity]:
    named = {quantity.name: quantity for quantity in quantities}
    assert len(named) == len(quantities)
    return named


def errors_and_rates(seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    return rng.normal([0.01, 0, 0, 0], 0.02, (len(TIME_S), 4)), rng.normal(0, 0.1, (len(TIME_S), 2))


def rms(values: list[float]) -> float:
    return math.sqrt(sum(value**2 for value in values) / len(values))


def test_quantities_by_loops() -> None:
    errors, rates = errors_and_rates()
    found = by_name(stroke_quantities(TIME_S, errors, rates, CORNERS_S, SEEN))
    start, end = TIME_S[0], TIME_S[-1]
    parts: dict[str, list[int]] = {"": [], "_corner": [], "_straight": [], "_last": []}
    for k, t in enumerate(TIME_S):
        if t - start >= 1.0:
            parts[""].append(k)
            corner = any(c <= t < c + 0.5 for c in CORNERS_S)
            parts["_corner" if corner else "_straight"].append(k)
        if t >= end - 1.0:
            parts["_last"].append(k)
    for part, rows in parts.items():
        for name, columns, unit in (("tilts", (0, 1), "deg"), ("tilt_rates", (2, 3), "deg/s")):
            lengths = [DEG * math.hypot(*(errors[k, i] for i in columns)) for k in rows]
            quantity = found[f"{name}{part}"]
            assert quantity.unit == unit
            assert quantity.rmse == pytest.approx(rms(lengths))
            assert quantity.max_error == pytest.approx(max(lengths))
    for column, name in enumerate(("tilt_phi", "tilt_theta", "tilt_phi_rate", "tilt_theta_rate")):
        single = [DEG * errors[k, column] for k in parts[""]]
        assert found[name].rmse == pytest.approx(rms(single))
        assert found[name].bias == pytest.approx(sum(single) / len(single))
    of_rates = [math.hypot(*errors[k, 2:]) for k in parts[""]]
    of_motion = [math.hypot(*rates[k]) for k in parts[""]]
    relative = rms(of_rates) / rms(of_motion)
    assert found["tilt_rates_relative"].bias == pytest.approx(relative)
    steps = [math.dist(a[:2], b[:2]) * DEG for a, b in pairwise(errors)]
    assert found["jitter"].rmse == pytest.approx(rms(steps))
    inside = [k for k in parts["_straight"] if k - 1 in parts["_straight"]]
    off_corners = [steps[k - 1] for k in inside]
    assert found["jitter_straight"].rmse == pytest.approx(rms(off_corners))
    assert len(off_corners) < len(parts["_straight"])


def test_drift_is_the_slope_of_the_errors() -> None:
    """Of a line through them: exact for a line, whatever its level."""
    slopes = np.array([0.003, -0.004])
    errors = np.zeros((len(TIME_S), 4))
    errors[:, :2] = 0.2 + slopes * TIME_S[:, None]
    found = by_name(stroke_quantities(TIME_S, errors, errors[:, 2:], CORNERS_S, SEEN))
    assert found["drift"].bias == pytest.approx(DEG * 0.005)
    assert found["jitter"].rmse == pytest.approx(DEG * 0.005 * 0.01)


def test_a_table_at_rest_has_no_relative_rates_and_no_corners() -> None:
    errors, rates = errors_and_rates()
    found = by_name(stroke_quantities(TIME_S, errors, 0 * rates, np.array([]), SEEN))
    missing = {"tilt_rates_relative", "tilts_corner", "tilt_rates_corner"}
    assert not missing & set(found)
    assert found["tilts_straight"].rmse == found["tilts"].rmse
    moving = by_name(stroke_quantities(TIME_S, errors, rates, CORNERS_S, SEEN))
    assert set(moving) - set(found) == missing


@pytest.mark.parametrize("hidden", SEEN)
def test_what_is_not_seen_is_said_of_all_that_needs_it(hidden: str) -> None:
    errors, rates = errors_and_rates()
    seen = {**SEEN, hidden: False}
    quantities = stroke_quantities(TIME_S, errors, rates, CORNERS_S, seen)
    of_rates = "_rate" in hidden
    expected = {hidden.removesuffix("_rad_s").removesuffix("_rad")}
    if of_rates:
        expected |= {f"tilt_rates{p}" for p in ("", "_corner", "_straight", "_last", "_relative")}
    else:
        expected |= {f"tilts{p}" for p in ("", "_corner", "_straight", "_last")} | {"settling"}
    assert {q.name for q in quantities if not q.observable} == expected


def test_near_a_corner() -> None:
    time_s = np.array([0.99, 1.0, 1.25, 1.49, 1.5, 1.99, 2.0, 2.2, 2.5, 2.6])
    near = near_corner(time_s, np.array([1.0, 2.0, 2.2]))
    assert list(near) == [False, True, True, True, False, False, True, True, True, True]
    assert not near_corner(time_s, np.array([])).any()


def settled_by_loops(time_s: np.ndarray, errors: np.ndarray) -> float:
    """The first instant from which on all samples of half a second are within."""
    for t in time_s:
        if t + 0.5 > time_s[-1] + 1e-9:
            return math.inf
        window = (time_s >= t - 1e-9) & (time_s <= t + 0.5 + 1e-9)
        if (np.abs(errors[window]) <= math.radians(2)).all():
            return float(t - time_s[0])
    return math.inf


@pytest.mark.parametrize("seed", range(30))
def test_settling_by_loops(seed: int) -> None:
    """Errors that come and go; steps that are exact in binary, so that no tie is rounded."""
    rng = np.random.default_rng(seed)
    time_s = 1.0 + np.arange(0, 4, 1 / 64)
    level = np.repeat(rng.choice([0.5, 2.5], 32, p=[0.75, 0.25]), 8)[: len(time_s)]
    errors = np.radians(np.column_stack([level, rng.uniform(-1.9, 1.9, len(time_s))]))
    assert settling_time(time_s, errors) == settled_by_loops(time_s, errors)


@pytest.mark.parametrize(
    ("outside", "expected"),
    [
        ((), 0.0),
        (((0, 1.0),), 1.0),
        (((0, 1.0), (1.25, 1.5)), 1.5),  # settles, but leaves after a quarter of a second
        (((0, 1.0), (2.0, 2.5)), 1.0),  # leaves only when it had settled
        (((0, 6.01),), math.inf),
        (((0, 5.75),), math.inf),  # not half a second is left
        (((0, 5.5),), 5.5),
    ],
)
@pytest.mark.parametrize("axis", [0, 1])
def test_settling(outside: tuple[tuple[float, float], ...], expected: float, axis: int) -> None:
    time_s = np.arange(0, 6.001, 1 / 64)
    errors = np.zeros((len(time_s), 2))
    for begin, end in outside:
        errors[(time_s >= begin) & (time_s < end), axis] = -math.radians(2.001)
    assert settling_time(time_s, errors) == expected
    assert settling_time(time_s + 7, errors) == expected


def test_errors_that_are_no_numbers_never_settle() -> None:
    assert settling_time(np.arange(0, 2, 0.01), np.full((200, 2), np.nan)) == math.inf


def start_run(outcome: str) -> StartRun:
    n = 501
    error = np.tile([0.001, -0.002, 0.0, 0.01], (n, 1))
    judged = np.arange(n) >= n - 100
    return StartRun(
        0, np.zeros(2), outcome, np.arange(n) / 100, error, error, judged, 0.5, np.arange(n) / n
    )


@pytest.mark.parametrize(
    ("outcome", "status"), [("mirror", "mirror"), ("converged", "ok"), ("lost", "ok")]
)
def test_a_run_in_the_mirror_has_a_status_of_its_own(
    monkeypatch: pytest.MonkeyPatch, outcome: str, status: str
) -> None:
    asked: list[tuple[StartTrial, int]] = []

    def found(trial: StartTrial, seed: int, **_: object) -> StartRun:
        asked.append((trial, seed))
        return start_run(outcome)

    monkeypatch.setattr(table_run, "run_start", found)
    ran = run_wrong_start(Task("pen", "start 30 deg", "accel", "ekf", 7))
    ((trial, seed),) = asked
    assert (trial.configuration, trial.estimator, seed) == ("accel", "ekf", 7)
    assert trial.start_error_rad == pytest.approx(math.radians(30))
    assert ran.status == status
    assert ("cannot tell from the truth" in ran.reason) == (status == "mirror")
    of = by_name(ran.quantities)
    assert of["tilts_last"].rmse == pytest.approx(DEG * math.hypot(0.001, 0.002))
    assert of["tilt_rates_last"].max_error == pytest.approx(DEG * 0.01)
    assert of["settling"].bias == 0.0
    assert (ran.samples, ran.solved_fraction) == (501, 0.5)
    assert ran.step_time_median_s == pytest.approx(250 / 501)


def test_the_mirror_is_found_where_it_is() -> None:
    """From 60 deg off some runs end there; each by its own distance to both solutions."""
    statuses = []
    for seed in (3, 4):
        task = Task("pen", "start 60 deg", "accel+gyro", "ekf", seed)
        ran = run_wrong_start(task)
        run_of = run_start(StartTrial(task.sensors, task.estimator, STARTS[task.case]), seed)
        last = run_of.time_s > run_of.time_s[-1] - 1.0
        to_truth, to_mirror = (
            np.abs(e[last, :2]).max() for e in (run_of.error, run_of.mirror_error)
        )
        assert ran.status == ("mirror" if to_mirror < to_truth else "ok")
        assert min(to_truth, to_mirror) < math.radians(10)
        statuses.append(ran.status)
    assert set(statuses) == {"ok", "mirror"}


@pytest.mark.parametrize("case", ["principle: dot", "start 30 deg"])
@pytest.mark.parametrize("sensors", ["gyro", "accel+gyro"])
def test_a_gyroscope_alone_shows_rates_but_no_tilts(case: str, sensors: str) -> None:
    of = by_name(_run(Task("pen", case, sensors, "ekf", 0)).quantities)
    assert of["tilt_rates_last"].observable
    for name in ("tilts_last", "settling"):
        assert of[name].observable == (sensors != "gyro")


def test_the_estimator_gets_no_truth_and_no_other_sensor(monkeypatch: pytest.MonkeyPatch) -> None:
    given: list[tuple[Any, set[str]]] = []

    def spied(estimator: Any, recording: Any, **options: Any) -> Any:
        given.append((recording.truth, set(recording.readings)))
        return run(estimator, recording, **options)

    monkeypatch.setattr(table_run, "run", spied)
    monkeypatch.setattr(suites.pen.turntable_starts, "run", spied)
    for case in ("principle: dot", "start 0 deg"):
        _run(Task("pen", case, "gyro", "ekf", 0))
    assert given == [(None, {"gyro"})] * 2


def test_the_start_of_a_stroke_is_drawn_as_it_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two degrees in each tilt; the prior says so; a seed is a start, whoever estimates."""
    priors: dict[tuple[str, int], Any] = {}

    def spied(estimator: Any, recording: Any, prior: Any, **options: Any) -> Any:
        priors[estimator.model.sensors[0].name, seed] = prior
        return run(estimator, recording, prior=prior, **options)

    monkeypatch.setattr(table_run, "run", spied)
    for sensors in ("gyro", "accel"):
        for seed in range(12):
            _run(Task("pen", "principle: dot", sensors, "ekf", seed))
    means = np.array([priors["gyro", seed].mean[:2] for seed in range(12)])
    assert np.array_equal(means, [priors["accel", seed].mean[:2] for seed in range(12)])
    off = DEG * means - [20, 20]
    assert np.sqrt(np.mean(off**2)) == pytest.approx(2.0, rel=0.45)
    assert np.abs(off).max() < 8
    for prior in priors.values():
        assert np.sqrt(np.diag(prior.covariance)[:2]) == pytest.approx(np.radians([2, 2]))


def _run(task: Task) -> Outcome:
    return run_wrong_start(task) if task.case in STARTS else run_stroke(task)


def test_every_stroke_of_the_table_is_a_case() -> None:
    assert len(STROKES) == 11
    assert [math.degrees(error) for error in STARTS.values()] == pytest.approx(
        [0, 10, 20, 30, 45, 60]
    )
