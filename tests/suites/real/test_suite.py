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
from suites.real.cases import (
    AWAY,
    BEST,
    CAMERA_ALONE,
    CASES,
    CAUSAL,
    LAG,
    NO_CAMERA,
    UNBIASED,
    WITHOUT,
    ZERO_DELAY,
)
from suites.real.dpoint_run import FOLDER
from suites.real.figures import figures
from suites.real.ingredients import INGREDIENTS
from suites.real.suite import FAST, NAME, SLOW, SUITE

BLIND = (NO_CAMERA, UNBIASED)


@pytest.fixture
def scope(tmp_path: Path) -> Scope:
    """As if there were a recording: tasks are listed without reading it."""
    (tmp_path / FOLDER).mkdir()
    return Scope(seeds=20, data=str(tmp_path))


def error_of(task: Task) -> float:
    """The interval of a task's camera, and a figure for each phase on top."""
    return 1.0 if task.case in BLIND else 1.0 / CASES[task.case].rate_hz + task.seed


@pytest.fixture
def rows(scope: Scope) -> pd.DataFrame:
    """What every task would say."""
    found = []
    for task in SUITE.tasks(scope):
        blind = task.case in BLIND
        names = ("elevation", "elevation_spread") if blind else (
            "ink", f"ink_{LAG}", "left_out_position")  # fmt: skip
        quantities = tuple(Quantity.single(name, "mm", error_of(task)) for name in names)
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
        # Every phase of what is judged causally, a quarter of the seeds of the rest.
        few = case not in CAUSAL or estimator == SLOW or (estimator, sensors == BEST) == (
            "mhe-rti", False)  # fmt: skip
        most = 1 if case in BLIND else 30 // CASES[case].rate_hz
        wanted = 20 if case == AWAY else min(most, scope.few_seeds) if few else most
        assert number == wanted, (case, sensors, estimator)
        seeds = {t.seed for t in tasks if (t.case, t.sensors, t.estimator) == (
            case, sensors, estimator)}  # fmt: skip
        assert seeds == set(range(number))
    assert set(SUITE.tasks(Scope(seeds=2, data=scope.data))) < set(tasks)
    assert {t.case for t in tasks} == {*CASES, *BLIND}
    assert {t.sensors for t in tasks if t.estimator == SLOW} == {BEST, "accel+gyro"}
    assert not {t.case for t in tasks if t.sensors == CAMERA_ALONE} - set(ZERO_DELAY)


def test_every_claim_judges_something(rows: pd.DataFrame) -> None:
    for claim in load_claims(SUITE.claims):
        table = paired_values(claim, rows)
        assert len(table), claim.id
        if "estimator" in claim.every:
            assert len(set(table["estimator"])) == 2, claim.id


def test_the_claims_look_at_every_rate_and_ingredient() -> None:
    judged = {str(claim.of["case"]) for claim in load_claims(SUITE.claims)}
    left_out = {
        str(claim.against["case"])
        for claim in load_claims(SUITE.claims)
        if claim.against and "case" in claim.against
    }
    assert set(CAUSAL) <= judged
    for name in INGREDIENTS:
        assert {f"causal, {rate} Hz, no {name}" for rate in (10, 3)} <= left_out & {*WITHOUT}


def test_figures_are_over_the_cameras_rate(rows: pd.DataFrame) -> None:
    results = Results(rows, pd.DataFrame(columns=list(SERIES_COLUMNS)))
    over_rate, ingredients = figures(results)
    assert (over_rate.key, ingredients.key) == ("real-camera-rate", "real-ingredients")
    by_time, by_sensors, left_out = over_rate.panels
    ours = [line.name for line in by_time.lines if line.style == "line"]
    assert ours == ["ekf", "mhe-rti", f"mhe-rti, {LAG} samples later", "ekf, zero delay"]
    assert len(by_sensors.lines) == len(left_out.lines) == 4
    line = by_sensors.lines[0]
    assert list(line.x) == [30, 15, 10, 6, 5, 3]
    phases = 30 / line.x
    assert line.low is not None
    assert line.high is not None
    assert line.y == pytest.approx(1 / line.x + (phases - 1) / 2)
    assert line.low == pytest.approx(1 / line.x)
    assert line.high == pytest.approx(1 / line.x + phases - 1)
    assert [panel.title for panel in ingredients.panels] == [*FAST]
    for panel in ingredients.panels:
        assert [line.name for line in panel.lines] == [f"no {name}" for name in INGREDIENTS]
        assert all(line.y == pytest.approx(0, abs=1e-9) for line in panel.lines)


def test_a_run_that_is_lost_has_no_place(rows: pd.DataFrame) -> None:
    rows.loc[(rows["case"] == "causal, 3 Hz") & (rows["sensors"] == "accel+camera"), "rmse"] = 1e6
    results = Results(rows, pd.DataFrame(columns=list(SERIES_COLUMNS)))
    by_sensors = figures(results)[0].panels[1]
    drawn = {line.name: list(line.x) for line in by_sensors.lines}
    assert drawn["accel+camera"] == [30, 15, 10, 6, 5]
    assert drawn["gyro+camera"] == [30, 15, 10, 6, 5, 3]


def test_figures_of_what_is_left(rows: pd.DataFrame) -> None:
    no_series = pd.DataFrame(columns=list(SERIES_COLUMNS))
    assert figures(Results(rows[:0], no_series)) == []
    slow = rows[rows["case"].isin(["causal, 3 Hz"]) & (rows["estimator"] == "ekf")]
    (figure,) = figures(Results(slow, no_series))
    assert [list(line.x) for line in figure.panels[1].lines] == [[3.0]] * 4
    paths = pd.concat(
        pd.DataFrame(
            {**vars(Task(NAME, "zero delay, 10 Hz", "camera", "ekf", 0)), "quantity": quantity,
             "unit": "mm", "time_s": [0.0, 1.0], "estimate": [level, 2.0],
             "std": float("nan"), "truth": float("nan")}
        )
        for quantity, level in (("tip_x", 5.0), ("tip_y", 7.0))
    )  # fmt: skip
    (figure,) = figures(Results(rows[:0], paths))
    assert figure.key == "real-paths"
    drawn = {panel.title: panel.lines for panel in figure.panels}
    (line,) = drawn["zero delay, 10 Hz"]
    assert (line.name, list(line.x), list(line.y)) == ("camera", [5.0, 2.0], [7.0, 2.0])
    assert drawn["zero delay, 30 Hz"] == drawn["zero delay, 15 Hz"] == []
