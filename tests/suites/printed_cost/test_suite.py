"""The suite: which tasks there are, and what the report shows of their seeds."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pandas as pd
import pytest

from benchmark.runner.tables import result_rows
from benchmark.tasks.results import RESULT_COLUMNS, SERIES_COLUMNS, Results
from benchmark.tasks.suite import Scope
from benchmark.tasks.task import Outcome, Quantity, Task, failed
from benchmark.verdicts.claims import load_claims
from benchmark.verdicts.judge import FAILS, HOLDS, NOT_JUDGED, judge
from pen_mhe.errors import NOT_OBSERVABLE
from suites.printed_cost import suite as suite_module
from suites.printed_cost.figures import LABELS, NOISE
from suites.printed_cost.run import (
    ACCEL_ERROR,
    ACCEL_NOISE,
    CASES,
    CONFIGURATIONS,
    MODELS,
    RIGID_BODY,
    TIP_SPEED,
    CostCase,
)
from suites.printed_cost.suite import NAME, SUITE
from suites.printed_cost.tables import HEAD
from suites.table import find_suite

PAYS = {RIGID_BODY: 1.0, "E2 only": 4.0, "E3 only": 3.0, "E4 only": 1.01, "as printed": 5.0}
TERMS = {RIGID_BODY: 0.0, "E2 only": 1.7, "E3 only": 1.3, "E4 only": 0.02, "as printed": 2.2}
"""Model → errors of tip and of accelerometer of results that are made up."""


def outcome_of(task: Task, pays: float) -> Outcome:
    camera = task.sensors == "with camera"
    return Outcome(
        "a model",
        (
            Quantity.single(TIP_SPEED, "mm/s", 30 * CASES[task.case] * (1 + task.seed)),
            Quantity.single(ACCEL_ERROR, "m/s²", TERMS[task.estimator]),
            Quantity.single(ACCEL_NOISE, "m/s²", 0.008),
            Quantity.single("tip", "mm", pays * (1 + 0.01 * task.seed), camera),
            Quantity.single("azimuth", "deg", 0.06, camera),
            Quantity.single("elevation", "deg", 0.03),
        ),
        *(400, 1.0, math.nan, math.nan),
    )


def made(seeds: int, pays: Callable[[Task], float] = lambda task: PAYS[task.estimator]) -> Results:
    """Results as the runner has them: tasks in the order of their names."""
    rows = [
        row
        for task in sorted(SUITE.tasks(Scope(seeds)))
        for row in result_rows(task, outcome_of(task, pays(task)))
    ]
    return Results(
        pd.DataFrame(rows, columns=list(RESULT_COLUMNS)), pd.DataFrame(columns=list(SERIES_COLUMNS))
    )


def verdicts(results: Results) -> dict[str, str]:
    assert SUITE.claims is not None
    found = judge(load_claims(SUITE.claims), results.rows)
    return {each.claim.id.split("-")[2]: each.verdict for each in found}


def test_every_model_at_every_speed_with_and_without_a_camera() -> None:
    assert find_suite(NAME) is SUITE
    found = SUITE.tasks(Scope(3))
    assert len(found) == len(set(found)) == len(CASES) * len(CONFIGURATIONS) * len(MODELS) * 3
    assert [task.seed for task in found[:4]] == [0, 1, 2, 0]  # a cell's seeds stand together


def test_a_task_is_a_run_at_its_speed(monkeypatch: pytest.MonkeyPatch) -> None:
    ran: list[tuple[CostCase, int]] = []
    monkeypatch.setattr(suite_module, "run_cost", lambda case, seed: ran.append((case, seed)))
    SUITE.run(Task(NAME, "speed 0.25", "with camera", "E2 only", 7), Scope())
    assert ran == [(CostCase(0.25, "with camera", "E2 only"), 7)]


def test_mean_and_spread_are_over_the_seeds() -> None:
    [(_, caption, head, rows)] = SUITE.tables(made(2))
    assert "over 2 seeds" in caption
    assert head == HEAD
    order = [(row[0], row[2], row[3]) for row in rows]
    assert order == [(c, s, m) for c in CASES for s in CONFIGURATIONS for m in MODELS]
    tip = {row[3]: row for row in rows if row[:1] + row[2:3] == ("speed 2", "with camera")}
    # 5 and 5.05: half their difference times √2; of the speeds 60 and 120 the root of the mean
    # square.
    assert tip["as printed"][5] == "5.025 ± 0.035"
    assert tip["as printed"][1] == f"{math.sqrt((60**2 + 120**2) / 2):.0f}"
    blind = [row for row in rows if row[2] == "without camera"]
    assert {(row[5], row[7]) for row in blind} == {(NOT_OBSERVABLE, NOT_OBSERVABLE)}
    [(_, _, _, single)] = SUITE.tables(made(1))
    assert single[0][5] == "1.000"


def test_the_figure_has_every_model_and_the_noise() -> None:
    [figure] = SUITE.figures(made(2))
    terms, tip, *others = figure.panels
    assert [line.name for line in terms.lines] == [*list(LABELS.values())[1:], NOISE]
    assert (terms.x_log, terms.y_log, tip.x_log, tip.y_log) == (True, True, True, False)
    assert terms.lines[-1].y.tolist() == [0.008, 0.008]
    assert [panel.title for panel in (tip, *others)] == [
        *("tip, EKF with camera", "azimuth, EKF with camera"),
        *("elevation, EKF with camera", "elevation, EKF without camera"),
    ]
    for panel in (tip, *others):
        assert [line.name for line in panel.lines] == list(LABELS.values())
    printed = tip.lines[-1]
    assert (np.diff(printed.x) > 0).all()
    np.testing.assert_allclose(printed.y, 5.025)
    assert printed.low is not None
    assert printed.high is not None
    np.testing.assert_allclose(printed.high - printed.y, 0.05 / math.sqrt(2))
    np.testing.assert_allclose(printed.y - printed.low, 0.05 / math.sqrt(2))


def test_nothing_is_shown_of_nothing() -> None:
    rows = list(result_rows(SUITE.tasks(Scope(1))[0], failed("it broke")))
    nothing = Results(
        pd.DataFrame(rows, columns=list(RESULT_COLUMNS)), pd.DataFrame(columns=list(SERIES_COLUMNS))
    )
    assert list(SUITE.figures(nothing)) == list(SUITE.tables(nothing)) == []


def test_claims_hold_and_can_fail() -> None:
    assert set(verdicts(made(5)).values()) == {HOLDS}
    costs_nothing = verdicts(made(5, lambda task: 1.0))
    assert {name for name, verdict in costs_nothing.items() if verdict == FAILS} == {"3", "4"}
    all_pay = verdicts(made(5, lambda task: 1.0 if task.estimator == RIGID_BODY else 4.0))
    assert {name for name, verdict in all_pay.items() if verdict == FAILS} == {"5"}
    assert set(verdicts(made(1)).values()) == {NOT_JUDGED}
