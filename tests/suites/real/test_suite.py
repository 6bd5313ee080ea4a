"""The suite of the real pen as the runner, the judge and the report see it."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pandas as pd
import pytest

from benchmark.runner.tables import result_rows
from benchmark.tasks.results import RESULT_COLUMNS, SERIES_COLUMNS, Results
from benchmark.tasks.suite import Scope
from benchmark.tasks.task import Outcome, Quantity, Task
from benchmark.verdicts.claims import load_claims
from benchmark.verdicts.judge import paired_values
from suites.real.dpoint_run import FOLDER, NO_CAMERA, RATES, UNBIASED
from suites.real.figures import figures
from suites.real.suite import NAME, SUITE


@pytest.fixture
def scope(tmp_path: Path) -> Scope:
    """As if there were a recording: tasks are listed without reading it."""
    (tmp_path / FOLDER).mkdir()
    return Scope(seeds=20, data=str(tmp_path))


@pytest.fixture
def rows(scope: Scope) -> pd.DataFrame:
    """What every task would say, with an error that is its camera's interval."""
    found = []
    for task in SUITE.tasks(scope):
        blind = task.case in (NO_CAMERA, UNBIASED)
        names = ("elevation", "elevation_spread") if blind else ("ink", "left_out_position")
        error = 1.0 if blind else 1.0 / RATES[task.case] + task.seed
        quantities = tuple(Quantity.single(name, "mm", error) for name in names)
        found += result_rows(task, Outcome("m", quantities, 1, 1.0, 0.0, 0.0))
    return pd.DataFrame(found, columns=list(RESULT_COLUMNS))


def test_without_data_one_line_says_so(tmp_path: Path) -> None:
    nowhere, empty = Scope(), Scope(data=str(tmp_path))
    assert SUITE.missing(nowhere) == (
        "suite real: left out, it needs recordings (--data FOLDER, or the variable PEN_MHE_DATA)"
    )
    assert SUITE.missing(empty) == f"suite real: left out, {tmp_path} has no folder dpoint_pen"
    assert list(SUITE.tasks(nowhere)) == list(SUITE.tasks(empty)) == []


def test_a_phase_is_a_task(scope: Scope) -> None:
    assert SUITE.missing(scope) == ""
    tasks = SUITE.tasks(scope)
    assert len(set(tasks)) == len(tasks)
    assert {SUITE.reads(task) for task in tasks} == {FOLDER}
    phases = Counter((t.case, t.sensors, t.estimator) for t in tasks)
    for (case, sensors, estimator), number in phases.items():
        # Every phase that there is, whatever the number of seeds.
        assert number == (1 if case in (NO_CAMERA, UNBIASED) else 30 // RATES[case])
        seeds = {t.seed for t in tasks if (t.case, t.sensors, t.estimator) == (
            case, sensors, estimator)}  # fmt: skip
        assert seeds == set(range(number))
    few = SUITE.tasks(Scope(seeds=2, data=scope.data))
    assert set(few) == {task for task in tasks if task.seed < 2}
    assert {t.sensors for t in tasks if t.estimator == "mhe" and t.case in RATES} == {
        "accel+gyro+camera"
    }


def test_every_claim_judges_something(rows: pd.DataFrame) -> None:
    for claim in load_claims(SUITE.claims):
        table = paired_values(claim, rows)
        assert len(table), claim.id
        if "case" in claim.every:
            named = claim.of["case"]
            wanted = set(named) if isinstance(named, tuple) else set(RATES)
            assert set(table["case"]) == wanted <= set(RATES), claim.id
        if "estimator" in claim.every:
            assert set(table["estimator"]) == {"ekf", "mhe"}, claim.id


def test_figures_are_over_the_cameras_rate(rows: pd.DataFrame) -> None:
    results = Results(rows, pd.DataFrame(columns=list(SERIES_COLUMNS)))
    (figure,) = figures(results)
    assert figure.key == "real-camera-rate"
    by_sensors, by_estimator = figure.panels[0], figure.panels[3]
    assert [line.name for line in by_estimator.lines] == ["ekf", "mhe-rti", "mhe"]
    assert len(by_sensors.lines) == 5
    line = by_sensors.lines[0]
    assert list(line.x) == [30, 15, 10, 6, 5, 3]
    phases = 30 / line.x
    assert line.low is not None
    assert line.high is not None
    assert line.y == pytest.approx(1 / line.x + (phases - 1) / 2)
    assert line.low == pytest.approx(1 / line.x)
    assert line.high == pytest.approx(1 / line.x + phases - 1)


def test_figures_of_what_is_left(rows: pd.DataFrame) -> None:
    no_series = pd.DataFrame(columns=list(SERIES_COLUMNS))
    assert figures(Results(rows[:0], no_series)) == []
    slow = rows[rows["case"].isin(["camera at 3 Hz"]) & (rows["estimator"] == "ekf")]
    (figure,) = figures(Results(slow, no_series))
    assert [list(line.x) for line in figure.panels[3].lines] == [[3.0]]
    paths = pd.concat(
        pd.DataFrame(
            {**vars(Task(NAME, "camera at 10 Hz", "camera", "ekf", 0)), "quantity": quantity,
             "unit": "mm", "time_s": [0.0, 1.0], "estimate": [level, 2.0],
             "std": float("nan"), "truth": float("nan")}
        )
        for quantity, level in (("tip_x", 5.0), ("tip_y", 7.0))
    )  # fmt: skip
    (figure,) = figures(Results(rows[:0], paths))
    assert figure.key == "real-paths"
    drawn = {panel.title: panel.lines for panel in figure.panels}
    (line,) = drawn["camera at 10 Hz"]
    assert (line.name, list(line.x), list(line.y)) == ("camera", [5.0, 2.0], [7.0, 2.0])
    assert drawn["camera at 30 Hz"] == drawn["camera at 15 Hz"] == []
