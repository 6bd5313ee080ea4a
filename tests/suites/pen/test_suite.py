"""The suite as the runner, the judge and the report see it."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd
import pytest

from benchmark.configurations import CONFIGURATIONS, TURNTABLE_CONFIGURATIONS
from benchmark.runner.tables import result_rows
from benchmark.tasks.suite import Scope
from benchmark.tasks.task import OK, Outcome, Task
from benchmark.verdicts.claims import STATUS_IS, load_claims
from benchmark.verdicts.judge import paired_values
from estimation.estimator import run
from pen_mhe.estimators import ESTIMATORS
from suites.pen import pen_run, table_run
from suites.pen.known_start import BEGIN as KNOWN_BEGIN
from suites.pen.known_start import KNOWN_STARTS, NO_SPIN
from suites.pen.pen_cases import (
    ON_AXIS_BEGIN,
    PEN_CASES,
    PRINTED_BEGIN,
    REFERENCE,
    SPIN_IGNORED,
    WITH_IPOPT,
    WITHOUT_SPIN,
)
from suites.pen.suite import NAME, SUITE
from suites.pen.table_run import STARTS, STROKES
from suites.pen.table_run import WITH_IPOPT as TABLE_WITH_IPOPT
from suites.pen.told_tolerance import SHOWN, SWEEP

ONE = Scope(seeds=1)
EXAMPLES = {
    "stroke": "compound: horizontal-turn-vertical",
    "rest": "rest",
    "start": "start 0 deg",
    "pen": REFERENCE,
    "known": NO_SPIN,
}


def kind(case: str) -> str:
    """Cases of a kind have the same quantities."""
    if case in PEN_CASES:
        return "pen"
    if case in KNOWN_STARTS:
        return "known"
    return "start" if case in STARTS else "rest" if case == "rest" else "stroke"


@cache
def example(case: str) -> Outcome:
    return SUITE.run(Task(NAME, case, "accel+gyro", "ekf", 0), ONE)


def test_tasks_are_all_cases_sensors_and_estimators_once() -> None:
    tasks = SUITE.tasks(Scope(seeds=3))
    assert len(set(tasks)) == len(tasks) == len({task.key for task in tasks})
    assert {task.suite for task in tasks} == {NAME}
    assert {task.seed for task in tasks} == {0, 1, 2}
    others = (*PEN_CASES, *SWEEP, *KNOWN_STARTS)
    table = {(t.case, t.sensors, t.estimator) for t in tasks if t.case not in others}
    by_ipopt = {
        (TABLE_WITH_IPOPT, sensors, name)
        for sensors in TURNTABLE_CONFIGURATIONS
        for name in ("mhe-ipopt", "mhe")
    }
    assert table == by_ipopt | {
        (case, sensors, estimator)
        for case in (*STROKES, *STARTS)
        for sensors in TURNTABLE_CONFIGURATIONS
        for estimator in ("ekf", "mhe-rti", "mhe", "mhe-sparse")
    }
    swept = {(t.case, t.sensors, t.estimator) for t in tasks if t.case in SWEEP}
    assert swept == {(case, s, "ekf") for case in SWEEP for s in TURNTABLE_CONFIGURATIONS}
    pens = {(t.case, t.sensors) for t in tasks if t.case in PEN_CASES}
    assert pens == {(case, sensors) for case, row in PEN_CASES.items() for sensors in row.sensors}
    assert {t.estimator for t in tasks} <= set(ESTIMATORS)
    assert {t.sensors for t in tasks if t.case == REFERENCE} == set(CONFIGURATIONS)
    assert not SUITE.missing(ONE)


@pytest.mark.parametrize(("seeds", "of_ipopt"), [(1, 1), (5, 1), (20, 5)])
def test_ipopt_runs_on_every_choice_of_sensors_and_few_seeds(seeds: int, of_ipopt: int) -> None:
    tasks = SUITE.tasks(Scope(seeds=seeds))
    found = {(t.case, t.sensors, t.seed) for t in tasks if t.estimator == "mhe-ipopt"}
    rows = [(WITH_IPOPT, sensors) for sensors in CONFIGURATIONS]
    rows += [(case, "accel+gyro+camera") for case in (ON_AXIS_BEGIN, PRINTED_BEGIN)]
    rows += [(TABLE_WITH_IPOPT, sensors) for sensors in TURNTABLE_CONFIGURATIONS]
    few = {(*row, seed) for row in rows for seed in range(of_ipopt)}
    assert found == few | {(KNOWN_BEGIN, "accel+gyro", seed) for seed in range(seeds)}
    beside = {(t.case, t.sensors, t.seed) for t in tasks if t.estimator == "mhe"}
    assert found <= beside


@pytest.mark.slow
def test_the_optimum_says_how_far_mhe_is_from_it() -> None:
    outcome = SUITE.run(Task(NAME, TABLE_WITH_IPOPT, "accel+gyro", "mhe-ipopt", 0), ONE)
    quantity = next(q for q in outcome.quantities if q.name == "distance from mhe")
    assert quantity.unit == "σ"
    assert 0 < quantity.rmse <= quantity.max_error < 0.1


def test_a_row_of_seeds_stands_together() -> None:
    """So that its estimator is built once."""
    rows = [(t.case, t.sensors, t.estimator) for t in SUITE.tasks(Scope(seeds=3))]
    assert sum(a != b for a, b in pairwise(rows)) + 1 == len(set(rows))


def test_every_claim_judges_something() -> None:
    """With the quantities of an example of their kind given to all cases."""
    tasks = SUITE.tasks(ONE)
    rows = pd.DataFrame(
        [row for task in tasks for row in result_rows(task, example(EXAMPLES[kind(task.case)]))]
    )
    claims = load_claims(SUITE.claims)
    assert len(claims) >= 20
    for claim in claims:
        found = paired_values(claim, rows)
        assert len(found), claim.id
        for chosen in (claim.of, {**claim.of, **(claim.against or {})}):
            for column, values in chosen.items():
                for value in values if isinstance(values, tuple) else (values,):
                    alone = {"of": {**chosen, column: value}, "against": None}
                    assert len(paired_values(claim.model_copy(update=alone), rows)), claim.id
        if not claim.value.startswith(STATUS_IS):
            assert "quantity" in claim.of, claim.id
        if "case" in claim.every:
            begin = str(claim.of["case"]).removesuffix("*")
            named = claim.of["case"]
            assert set(found["case"]) == (
                set(named)
                if isinstance(named, tuple)
                else {case for case in (*STROKES, *SWEEP) if case.startswith(begin)}
            )


def test_the_claims_of_the_paper_are_there() -> None:
    sources = [claim.source for claim in load_claims(SUITE.claims)]
    assert {f"[Pen] {number}" for number in (1, 2, 3, 4)} <= set(sources)


@pytest.mark.parametrize(
    ("case", "sensors", "estimator"),
    [
        ("principle: hook", "accel", "mhe-rti"),
        ("start 45 deg", "accel+gyro", "ekf"),
        (REFERENCE, "accel+gyro", "ekf"),
    ],
)
def test_a_task_finds_the_same_again(case: str, sensors: str, estimator: str) -> None:
    """Whatever ran before it, and with an estimator that was just built."""
    task, scope = Task(NAME, case, sensors, estimator, 1), Scope(seeds=2)
    first = SUITE.run(task, scope)
    for module in (table_run, pen_run):
        for cached in vars(module).values():
            if hasattr(cached, "cache_clear"):
                cached.cache_clear()
    again = SUITE.run(task, scope)
    other = SUITE.run(Task(NAME, case, sensors, estimator, 2), scope)
    assert again.quantities == first.quantities
    assert (again.samples, again.solved_fraction) == (first.samples, first.solved_fraction)
    assert other.quantities != first.quantities
    for outcome in (first, again):
        assert 0 < outcome.step_time_median_s <= outcome.step_time_p99_s


def test_the_pens_estimator_gets_no_truth(monkeypatch: pytest.MonkeyPatch) -> None:
    given: list[Any] = []

    def spied(estimator: Any, recording: Any, **options: Any) -> Any:
        given.append((recording.truth, set(recording.readings)))
        return run(estimator, recording, **options)

    monkeypatch.setattr(pen_run, "run", spied)
    SUITE.run(Task(NAME, "accelerations neglected, speed 1", "accel+gyro", "ekf", 0), ONE)
    assert given == [(None, {"accel", "gyro"})]


def test_what_is_observable_of_a_pen() -> None:
    def seen(sensors: str) -> Mapping[str, bool]:
        outcome = SUITE.run(Task(NAME, REFERENCE, sensors, "ekf", 0), ONE)
        assert outcome.status == OK
        return {quantity.name: quantity.observable for quantity in outcome.quantities}

    inertial = seen("accel+gyro")
    assert inertial == {
        "tip": False, "azimuth": False, "elevation": True, "spin": True, "rates": True
    }  # fmt: skip
    # A gyroscope knows how the pen turns, and nothing of how it stands.
    assert seen("gyro") == dict.fromkeys(inertial, False) | {"rates": True}
    assert seen("accel+gyro+camera") == dict.fromkeys(inertial, True)


def test_rates_are_those_that_model_and_truth_share() -> None:
    """Of the body for a free pen, of the angles for one that cannot spin, none between the two."""
    found = {}
    for case in (REFERENCE, WITHOUT_SPIN, SPIN_IGNORED):
        outcome = SUITE.run(Task(NAME, case, "accel+gyro", "ekf", 0), ONE)
        found[case] = {quantity.name: quantity for quantity in outcome.quantities}
        assert all(np.isfinite(quantity.rmse) for quantity in outcome.quantities)
        assert all(quantity.claimed is not None for quantity in outcome.quantities)
    angles = ["tip", "azimuth", "elevation"]
    assert list(found[REFERENCE]) == [*angles, "spin", "rates"]
    assert list(found[WITHOUT_SPIN]) == [*angles, "rates"]
    assert list(found[SPIN_IGNORED]) == angles
    # Who believes in no spin is wrong, and sure of it; who does not is as wrong as it says.
    believed, free = (found[case]["elevation"] for case in (SPIN_IGNORED, REFERENCE))
    assert believed.rmse > 100 * (believed.claimed or np.inf)
    assert free.rmse < 3 * (free.claimed or 0.0)


def test_series_are_of_seed_0_and_of_what_figures_show() -> None:
    shown = [
        task
        for task in SUITE.tasks(ONE)
        if task.case in SHOWN or task.sensors in pen_run.SHOWN_SENSORS.get(task.case, {})
    ]
    assert len(shown) == 2 * 3 * 4 + (4 + 2) * 3 + 4
    stroke = example(EXAMPLES["stroke"])
    assert [series.quantity for series in stroke.series] == [
        *("tilt_phi", "tilt_phi_rate", "tilt_theta", "tilt_theta_rate")
    ]
    assert example("rest").series == example("start 0 deg").series == ()
    assert SUITE.run(Task(NAME, SHOWN[0], "accel+gyro", "ekf", 1), ONE).series == ()
    raw = SUITE.run(Task(NAME, SHOWN[0], "accel", "ekf", 0), ONE).series[4:]
    assert [series.quantity for series in raw] == [
        *(f"raw accel {axis}" for axis in "xyz"),
        *("raw gyro x", "raw gyro y"),
    ]
    assert np.abs(np.median(np.linalg.norm([s.estimate for s in raw[:3]], axis=0)) - 9.81) < 0.5
    phi = stroke.series[0]
    assert phi.truth is not None
    assert phi.std is not None
    later = phi.time_s >= 1.0
    quantity = next(q for q in stroke.quantities if q.name == "tilt_phi")
    error = (phi.estimate - phi.truth)[later]
    assert np.sqrt(np.mean(error**2)) == pytest.approx(quantity.rmse)
    assert (np.abs(error) <= 3 * phi.std[later]).mean() > 0.9
