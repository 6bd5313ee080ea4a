from __future__ import annotations

import dataclasses

import numpy as np
import pandas as pd
import pytest

from benchmark.tasks.results import SERIES_COLUMNS, Results
from benchmark.tasks.suite import Scope
from benchmark.tasks.task import Outcome, Task
from benchmark.verdicts.claims import load_claims
from benchmark.verdicts.judge import NO_DATA, judge
from classical_baseline.fixed_weight import weight_of_sum
from classical_baseline.weight_search import CURVE_WEIGHTS, Ended
from models.errors import InputError
from suites.tilt import operations as operations_module
from suites.tilt import suite as suite_module
from suites.tilt.cases import CASES, CURVE_CASES, FULL_TURN, TWO_AXES
from suites.tilt.estimators import CURVE, MODEL_BASED
from suites.tilt.operations import COUNTS
from suites.tilt.suite import ESTIMATORS, NAME, SUITE
from suites.tilt.weights import trained_weights

SCOPE = Scope(seeds=1)
RUN = (FULL_TURN, TWO_AXES)
"""Cases that tests run."""


def rows_of(task: Task, outcome: Outcome) -> list[dict[str, object]]:
    once = {
        **dataclasses.asdict(task),
        "model": outcome.model,
        "samples": outcome.samples,
        "solved_fraction": outcome.solved_fraction,
        "step_time_median_s": outcome.step_time_median_s,
        "step_time_p99_s": outcome.step_time_p99_s,
        "status": outcome.status,
        "reason": outcome.reason,
    }
    rows = []
    for quantity in outcome.quantities:
        row = {"quantity" if k == "name" else k: v for k, v in vars(quantity).items()}
        rows.append({**once, **row})
    return rows


def series_of(task: Task, outcome: Outcome) -> list[pd.DataFrame]:
    tables = []
    for series in outcome.series:
        nothing = np.full(len(series.time_s), np.nan)
        columns = {
            **dataclasses.asdict(task),
            "quantity": series.quantity,
            "unit": series.unit,
            "time_s": series.time_s,
            "estimate": series.estimate,
            "std": nothing if series.std is None else series.std,
            "truth": nothing if series.truth is None else series.truth,
        }
        tables.append(pd.DataFrame(columns)[list(SERIES_COLUMNS)])
    return tables


@pytest.fixture(scope="module")
def outcomes() -> dict[Task, Outcome]:
    return {task: SUITE.run(task, SCOPE) for task in SUITE.tasks(SCOPE) if task.case in RUN}


@pytest.fixture(scope="module")
def results(outcomes: dict[Task, Outcome]) -> Results:
    rows = [row for pair in outcomes.items() for row in rows_of(*pair)]
    series = [table for pair in outcomes.items() for table in series_of(*pair)]
    return Results(pd.DataFrame(rows), pd.concat(series))


def found(outcome: Outcome) -> dict[str, float]:
    return {quantity.name: quantity.rmse for quantity in outcome.quantities}


def test_tasks_are_all_cases_and_estimators() -> None:
    tasks = SUITE.tasks(Scope(seeds=2))
    assert len(set(tasks)) == len(tasks)
    assert {task.case for task in tasks} == set(CASES)
    assert {(task.estimator, task.sensors) for task in tasks} == set(ESTIMATORS.items())
    assert {task.seed for task in tasks} == {0, 1}
    assert {task.suite for task in tasks} == {NAME}
    assert {task.case for task in tasks if task.estimator == CURVE} == set(CURVE_CASES)


def test_every_claim_judges_something(outcomes: dict[Task, Outcome]) -> None:
    """With the quantities that an estimator has in one case given to all its cases."""
    rows = []
    for task in SUITE.tasks(SCOPE):
        like = next(t for t in outcomes if t.estimator == task.estimator)
        rows += rows_of(task, outcomes[like])
    claims = load_claims(SUITE.claims)
    assert len({claim.id for claim in claims}) == len(claims) >= 20
    for claim, judgement in zip(claims, judge(claims, pd.DataFrame(rows)), strict=True):
        assert judgement.verdict != NO_DATA, claim.id
        cases = claim.of["case"]
        named = {cases} if isinstance(cases, str) else set(cases)  # type: ignore[arg-type]
        assert named <= set(CASES), claim.id
        if "case" in claim.every:
            assert {part.name for part in judgement.parts} == named, claim.id
        if "estimator" in claim.every:
            assert {part.name for part in judgement.parts} == set(claim.of["estimator"])  # type: ignore[arg-type]


def test_a_task_says_the_same_again(outcomes: dict[Task, Outcome]) -> None:
    for cached in (suite_module._samples, trained_weights):
        cached.cache_clear()
    for estimator in ("fixed-weight-best", "ekf", "mhe-rti"):
        task = Task(NAME, TWO_AXES, ESTIMATORS[estimator], estimator, 0)
        again = SUITE.run(task, SCOPE)
        assert again.quantities == outcomes[task].quantities


def test_estimators_are_worth_what_they_are_worth(outcomes: dict[Task, Outcome]) -> None:
    errors = {
        (task.case, task.estimator): found(outcome).get("direction")
        for task, outcome in outcomes.items()
    }
    raw, best = errors[FULL_TURN, "accelerometer"], errors[FULL_TURN, "fixed-weight-best"]
    light = errors[FULL_TURN, "fixed-weight"]
    assert best < light < raw  # type: ignore[operator]
    # White noise through the filter, apart from what the gyroscope adds: 1 / (1 + 2w).
    assert light / raw == pytest.approx(1 / np.sqrt(1 + 2 * 0.25), rel=0.05)  # type: ignore[operator]
    for case in RUN:
        assert errors[case, "mhe"] == pytest.approx(errors[case, "ekf"], rel=0.01)
    assert errors[TWO_AXES, "fixed-weight-carried"] > 5 * raw  # type: ignore[operator]


def test_the_search_says_that_it_ended_at_its_bound(outcomes: dict[Task, Outcome]) -> None:
    of = {
        task.case: found(outcome)
        for task, outcome in outcomes.items()
        if task.estimator == "fixed-weight-searched"
    }
    assert of[FULL_TURN]["weight"] == 1
    assert of[FULL_TURN]["search ended, upper bound"] == 1
    assert of[TWO_AXES]["search ended, inside"] == 1
    assert 0 < of[TWO_AXES]["weight"] < 1
    assert trained_weights(FULL_TURN).searched.ended is Ended.UPPER_BOUND


def test_weights_are_found_over_ten_recordings() -> None:
    found = trained_weights(FULL_TURN)
    assert found.curves.shape == (10, len(CURVE_WEIGHTS))
    assert len(np.unique(found.curves[:, 0])) == 10, "recordings are one and the same"
    np.testing.assert_allclose(found.curve, np.sqrt(np.mean(found.curves**2, axis=0)))
    assert min(found.best_of_each) < found.best < max(found.best_of_each)
    assert found.best == CURVE_WEIGHTS[int(np.argmin(found.curve))]


def test_what_is_said_of_the_bound_depends_on_the_reading() -> None:
    """As a convex sum the same search ends inside, at the best weight of the sum."""
    found = trained_weights(FULL_TURN)
    assert found.searched_convex.ended is Ended.INSIDE
    as_sum = weight_of_sum(found.searched_convex.weight)
    near = CURVE_WEIGHTS.index(found.best)
    assert CURVE_WEIGHTS[near - 2] < as_sum < CURVE_WEIGHTS[near + 2]


def test_series_are_of_seed_0_only(outcomes: dict[Task, Outcome]) -> None:
    assert sum(len(outcome.series) for outcome in outcomes.values()) <= 40
    assert SUITE.run(Task(NAME, FULL_TURN, "accel+gyro", "ekf", 1), SCOPE).series == ()
    ekf = outcomes[Task(NAME, FULL_TURN, "accel+gyro", "ekf", 0)]
    assert {series.quantity for series in ekf.series} == {"roll", "direction error"}
    assert all(np.isfinite(series.estimate).all() for series in ekf.series)
    roll = next(series for series in ekf.series if series.quantity == "roll")
    assert roll.truth is not None
    assert roll.truth[-1] == pytest.approx(360)
    assert np.abs(roll.estimate - roll.truth).max() < 1


def test_figures_are_drawn(results: Results) -> None:
    figures = SUITE.figures(results)
    assert [figure.key for figure in figures] == [
        "tilt-full-turn",
        "tilt-weights",
        "tilt-axes",
        "tilt-cost",
    ]
    for figure in figures:
        for panel in figure.panels:
            assert panel.lines, panel.title
            for line in panel.lines:
                assert len(line.x) == len(line.y) > 0
                if panel.y_log:
                    assert np.nanmin(line.y) > 0
    assert "in 1 of 2 cases" in figures[1].caption


def test_figures_stand_what_is_missing(results: Results) -> None:
    none = Results(results.rows[:0], results.series[:0])
    assert SUITE.figures(none) == []
    only_rows = Results(results.rows, results.series[:0])
    assert [figure.key for figure in SUITE.figures(only_rows)] == ["tilt-weights", "tilt-cost"]
    without = results.rows[results.rows["estimator"] != "ekf"]
    assert len(SUITE.figures(Results(without, results.series))) == 4


def test_unknown_tasks() -> None:
    with pytest.raises(InputError, match="case half turn is unknown"):
        SUITE.run(Task(NAME, "half turn", "accel+gyro", "ekf", 0), SCOPE)
    with pytest.raises(InputError, match="estimator ekf with sensors accel is unknown"):
        SUITE.run(Task(NAME, FULL_TURN, "accel", "ekf", 0), SCOPE)


def test_an_estimator_without_a_count_says_so(
    results: Results, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It has no figure of operations, least of all another's."""
    assert set(MODEL_BASED) <= set(COUNTS)
    (cost,) = [figure for figure in SUITE.figures(results) if figure.key == "tilt-cost"]
    assert "not counted" not in cost.caption
    known = {name: count for name, count in COUNTS.items() if name != "mhe-rti"}
    monkeypatch.setattr(operations_module, "COUNTS", known)
    outcome = SUITE.run(Task(NAME, TWO_AXES, ESTIMATORS["mhe-rti"], "mhe-rti", 0), SCOPE)
    assert "operations" not in found(outcome)
    assert "passes" in found(outcome)
    (cost,) = [figure for figure in SUITE.figures(results) if figure.key == "tilt-cost"]
    assert "The operations of mhe-rti are not counted: it has no row in" in cost.caption
