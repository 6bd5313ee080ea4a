"""The suite: a window a seed, what becomes of it as quantities, and what is shown of them."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from itertools import groupby
from typing import Any

import numpy as np
import pandas as pd
import pytest

from benchmark.runner.tables import result_rows
from benchmark.tasks.results import RESULT_COLUMNS, SERIES_COLUMNS, Results
from benchmark.tasks.suite import Scope
from benchmark.tasks.task import OK, Outcome, Task, failed
from benchmark.verdicts.claims import load_claims
from benchmark.verdicts.judge import FAILS, HOLDS, judge
from estimation.status import Status
from suites.execute import row_of
from suites.optimum.cases import WindowKey, window_key
from suites.optimum.figures import LIMIT
from suites.optimum.kinds import KINDS
from suites.optimum.quantities import COUNTED, window_outcome
from suites.optimum.run import ABOVE, BELOW, IPOPT_FAILED, SAME, WindowRow, compare
from suites.optimum.suite import NAME, SUITE
from suites.optimum.tables import LISTED
from suites.table import find_suite

FINE = Status.SOLVED
SOLVED = WindowRow(
    window_key(0), SAME, FINE, FINE, 5.0, 5.0, 0.0, 1e-9, 1e-9, 1e-9, 0, 0, 4, 9, 1
)  # fmt: skip
IMPROBABLE = Status.IMPROBABLE
ROWS: dict[str, dict[str, Any]] = {
    "same and near": {},
    "same, but apart": {"newest_distance": 1e-5, "newton_length": 2e-6},
    "above, said": {"verdict": ABOVE, "status": IMPROBABLE, "relative": 0.2},
    "above, unsaid": {"verdict": ABOVE, "relative": 0.2},
    "below": {"verdict": BELOW, "relative": -0.2},
    "ipopt failed": {"verdict": IPOPT_FAILED, "ipopt_newton_length": 1e-3, "ipopt_runs": 2},
}
"""What a window can come to."""


def named(found: Outcome) -> dict[str, float]:
    return {each.name: each.bias for each in found.quantities}


def made(seeds: int, changes: dict[int, dict[str, Any]]) -> Results:
    """Results of windows that all are near but for some, by seed."""
    rows = []
    for task in SUITE.tasks(Scope(seeds)):
        key = window_key(task.seed)
        row = replace(SOLVED, key=key, **changes.get(task.seed, {}))
        rows += result_rows(task, window_outcome(row, "a model"))
    return Results(
        pd.DataFrame(rows, columns=list(RESULT_COLUMNS)), pd.DataFrame(columns=list(SERIES_COLUMNS))
    )


def verdicts(results: Results) -> dict[str, str]:
    assert SUITE.claims is not None
    return {
        found.claim.id: found.verdict for found in judge(load_claims(SUITE.claims), results.rows)
    }


def test_a_task_is_a_window_of_the_table() -> None:
    assert find_suite(NAME) is SUITE
    found = SUITE.tasks(Scope(1000))
    keys = {task.seed: window_key(task.seed) for task in found}
    assert sorted(keys) == list(range(len(found))) == list(range(1000))
    for task in found:
        key = keys[task.seed]
        assert (task.case, task.sensors, task.estimator) == (key.kind, key.model, "mhe")


def test_solvers_of_a_model_and_horizon_are_built_once() -> None:
    """All windows that need them are one row, which stays with its process."""
    rows = [row for row, _ in groupby(SUITE.tasks(Scope(1000)), row_of)]
    assert len(rows) == len(set(rows))
    of_seed = {(key.model, key.horizon) for key in map(window_key, range(1000))}
    assert {row[1] for row in rows} == of_seed  # type: ignore[index]


def test_a_run_is_the_comparison_of_its_window() -> None:
    key = next(key for key in map(window_key, range(100)) if key.model == "turntable gyro")
    task = Task(NAME, key.kind, key.model, "mhe", key.seed)
    found, row = SUITE.run(task, Scope()), compare(key)
    assert (found.status, found.solved_fraction, found.samples) == (OK, 1.0, 1)
    figures = named(found)
    assert [figures[name] for name in ("cost", "cost of IPOPT")] == [row.cost, row.ipopt_cost]
    assert figures["newest states apart"] == row.newest_distance
    assert figures["iterations"] == row.iterations
    assert sum(figures[name] for name in COUNTED) == 1.0


@pytest.mark.parametrize("case", ROWS)
def test_what_a_window_comes_to(case: str) -> None:
    figures = named(window_outcome(replace(SOLVED, **ROWS[case]), "a model"))
    found = {name for name in COUNTED if figures[name] == 1.0}
    expected = {"above, said": {ABOVE}, "above, unsaid": {ABOVE, "above, unsaid"}}
    assert found == expected.get(case, {case})
    assert {figures[name] for name in COUNTED} == {0.0, 1.0}


def test_an_improbable_window_says_so() -> None:
    found = window_outcome(replace(SOLVED, **ROWS["above, said"]), "a model")
    assert found.reason == "two minima; mhe says improbable"
    assert found.solved_fraction == 1.0
    short = replace(SOLVED, **ROWS["above, said"], newton_length=np.inf)
    said = "mhe stopped short, inf left: improbable"
    assert window_outcome(short, "a model").reason == said
    unsolved = window_outcome(replace(SOLVED, status=Status.ITERATION_LIMIT), "a model")
    assert (unsolved.reason, unsolved.solved_fraction) == ("mhe says iteration_limit", 0.0)


@pytest.mark.parametrize(
    ("case", "seeds", "missed"),
    [
        ("same and near", 0, set()),
        ("same, but apart", 500, {"optimum-1-same", "optimum-2-near"}),
        ("above, said", 500, {"optimum-1-same", "optimum-3-above"}),
        ("above, unsaid", 500, {"optimum-1-same", "optimum-3-above", "optimum-4-said"}),
        ("below", 500, {"optimum-1-same"}),
        ("ipopt failed", 500, {"optimum-1-same", "optimum-5-reference"}),
    ],
)
def test_claims_can_fail(case: str, seeds: int, missed: set[str]) -> None:
    found = verdicts(made(1000, dict.fromkeys(range(seeds), ROWS[case])))
    assert {name for name, verdict in found.items() if verdict == FAILS} == missed
    assert {verdict for name, verdict in found.items() if name not in missed} == {HOLDS}


def test_windows_are_counted_and_those_that_differ_are_listed() -> None:
    some = {seed: change for seed, change in enumerate(ROWS.values()) if change}
    results = made(200, some)
    by_sensors, by_kind, *lists = SUITE.tables(results)
    for _, caption, _, rows in (by_sensors, by_kind):
        assert "200 windows; in 1 of them IPOPT was carried on" in caption
        assert rows[-1] == ("all", "200", "195", "1", "2", "1", "1", "1.0e-05", "0.0e+00")
        assert sum(int(row[1]) for row in rows[:-1]) == 200
    kinds = Counter(window_key(seed).kind for seed in range(200))
    assert {row[0]: int(row[1]) for row in by_kind[3][:-1]} == {
        KINDS[name].label: count for name, count in kinds.items()
    }
    listed = [dict(zip(LISTED, row, strict=True)) for _, _, _, rows in lists for row in rows]
    assert sorted(int(row["seed"]) for row in listed) == sorted(some)
    for row in listed:
        key: WindowKey = window_key(int(row["seed"]))
        assert (row["sensors"], row["N"]) == (key.model, str(key.horizon))
        assert row["why"]


def test_shares_in_the_figure() -> None:
    """Of four windows of a kind one is farther apart; one in another minimum does not count."""
    plain = [seed for seed in range(96) if window_key(seed).kind == "plain"][:5]
    changes = {
        plain[0]: {"newest_distance": 1e-5},
        plain[1]: {"verdict": ABOVE, "newest_distance": 9.0},
    }
    results = made(96, changes)
    rows = results.rows[results.rows["seed"].isin(plain)]
    [figure] = SUITE.figures(Results(rows, results.series))
    line, allowed = figure.panels[0].lines
    assert (line.name, allowed.name) == (KINDS["plain"].label, LIMIT)
    assert np.unique(line.y).tolist() == [0.0, 25.0, 100.0]
    assert line.y[np.searchsorted(line.x, 1e-6)] == 25.0
    assert set(allowed.x) == {1e-6}


def test_nothing_is_shown_of_nothing() -> None:
    task = SUITE.tasks(Scope(1))[0]
    rows = pd.DataFrame(list(result_rows(task, failed("it broke"))), columns=list(RESULT_COLUMNS))
    nothing = Results(rows, pd.DataFrame(columns=list(SERIES_COLUMNS)))
    assert list(SUITE.figures(nothing)) == list(SUITE.tables(nothing)) == []


def test_claims_speak_of_what_is_found() -> None:
    assert SUITE.claims is not None
    for claim in load_claims(SUITE.claims):
        assert claim.id.startswith(f"{NAME}-")
        assert claim.of["quantity"] in COUNTED
