"""The suite: its tasks, what one finds, and what the report says of many."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from benchmark.configurations import BENCHMARK_ESTIMATORS
from benchmark.runner.tables import result_rows
from benchmark.tasks.results import RESULT_COLUMNS, SERIES_COLUMNS, Results
from benchmark.tasks.suite import Scope
from benchmark.tasks.task import OK, Outcome, Task
from benchmark.verdicts.claims import load_claims
from benchmark.verdicts.judge import NO_DATA, judge
from models.errors import InputError
from models.pen_file import load_pen
from suites.consistency.figures import EXPECTED
from suites.consistency.pens import choices, made_of, own
from suites.consistency.quantities import FIRST_NEES, NEES, NIS, STATE_ERROR, STATES, quantities
from suites.consistency.run import CASES, ConsistencyRuns, run_case
from suites.consistency.suite import NAME, SUITE
from suites.execute import chosen_tasks

SENSORS = "accel+gyro+camera"
BLIND = "accel+gyro"
CASE = "settled"


def task(seed: int = 0, case: str = CASE, estimator: str = "ekf", sensors: str = SENSORS) -> Task:
    return Task(NAME, case, sensors, estimator, seed)


def test_every_case_runs_with_and_without_the_camera() -> None:
    found = SUITE.tasks(Scope(3))
    assert len(found) == len(set(found))
    assert {(each.case, each.sensors, each.estimator, each.seed) for each in found} == {
        (case, sensors, estimator, seed)
        for case in CASES
        for sensors in (SENSORS, BLIND)
        for estimator in BENCHMARK_ESTIMATORS
        for seed in range(3)
    }


def test_what_is_asked_for_in_vain_is_named() -> None:
    assert {each.estimator for each in chosen_tasks([NAME], Scope(1, estimators=("ukf",)))} == {
        "ukf"
    }
    for scope, sentence in (
        (Scope(1, estimators=("eks",)), "estimator eks is unknown, expected one of ekf, mhe, "),
        (Scope(1, cases=("calm",)), "case calm is unknown, expected one of handwriting, moving, "),
        (Scope(1, pen="nowhere.toml"), "pen file nowhere.toml does not exist"),
    ):
        with pytest.raises(InputError, match=sentence):
            chosen_tasks([NAME], scope)
    with pytest.raises(InputError, match="case calm is unknown, expected one of settled, moving"):
        SUITE.run(task(case="calm"), Scope(1))
    with pytest.raises(InputError, match="sensor radar is not in the pen D-POINT"):
        SUITE.run(task(sensors="accel+radar"), Scope(1))


@cache
def outcome(seed: int) -> Outcome:
    return SUITE.run(task(seed), Scope(2))


def table_of(outcomes: dict[Task, Outcome]) -> pd.DataFrame:
    rows = [row for each, found in outcomes.items() for row in result_rows(each, found)]
    return pd.DataFrame(rows, columns=list(RESULT_COLUMNS))


def test_rows_put_together_are_the_runs_of_the_seeds() -> None:
    """A seed is one run, whatever was run before it in the same process."""
    seeds = (1, 0)
    runs = run_case(load_pen("dpoint"), ("accel", "gyro", "camera"), CASES[CASE], "ekf", seeds)
    for i, seed in enumerate(seeds):
        found = outcome(seed)
        assert (found.status, found.solved_fraction) == (OK, 1.0)
        figures = {each.name: each.bias for each in found.quantities}
        assert figures == {
            NEES: runs.nees[i],
            FIRST_NEES: runs.first_nees[i],
            NIS: runs.nis_per_row[i],
            STATE_ERROR: runs.state_error[i],
            STATES: 24,
        }
    results = Results(table_of({task(seed): outcome(seed) for seed in seeds}), series_of(()))
    ((title, caption, head, rows),) = SUITE.tables(results)
    assert title == "D-POINT stylus, 6 degrees of freedom: accel+gyro+camera, 2 runs each"
    assert caption.startswith("Consistent: within 2.6 standard errors of the number of states.")
    (row,) = rows
    assert len(row) == len(head)
    assert row[:2] == (CASES[CASE].label, "ekf")
    assert row[2] == f"{runs.nees.mean():.4g} (median {np.median(runs.nees):.4g})"
    assert row[3] == "24"
    assert row[4].startswith(f"{runs.deviation:+.1f} (")
    assert row[6:] == (f"{runs.nis_per_row.mean():.3f}", f"{runs.state_error.mean():.3f}")


def made_up_run(nees: float) -> ConsistencyRuns:
    return ConsistencyRuns(8, *(np.array([value]) for value in (nees, 9.0, 1.0, 1.1)))


def made_up(case: str, nees: list[float], sensors: str = SENSORS) -> dict[Task, Outcome]:
    found = {}
    for seed, value in enumerate(nees):
        one = made_up_run(value)
        found[task(seed, case, sensors=sensors)] = Outcome(
            "pen", quantities(one), 1, 1.0, 1e-5, 1e-5
        )
    return found


def series_of(rows: Any) -> pd.DataFrame:
    return pd.DataFrame(rows, columns=list(SERIES_COLUMNS))


@pytest.mark.parametrize(
    ("case", "nees", "said"),
    [
        # √(2 · 8 / 4) = 2 is the largest standard error of four runs.
        ("settled", [8.0, 8.0, 8.0, 28.0], "+2.5 (consistent)"),
        ("settled", [8.0, 8.0, 8.0, 36.0], "+3.5 (not consistent)"),
        ("settled", [13.0, 14.0, 13.0, 14.0], "+19.1 (not consistent)"),
        ("handwriting", [5.0, 6.0, 5.0, 6.0], "-8.7 (not drawn from the model)"),
    ],
)
def test_a_verdict_counts_standard_errors(case: str, nees: list[float], said: str) -> None:
    ((_, _, _, rows),) = SUITE.tables(Results(table_of(made_up(case, nees)), series_of(())))
    assert [row[4] for row in rows] == [said]


def test_choices_of_sensors_have_tables_of_their_own() -> None:
    found = made_up("settled", [8.0, 9.0]) | made_up("settled", [8.0, 9.0], BLIND)
    titles = [title for title, *_ in SUITE.tables(Results(table_of(found), series_of(())))]
    assert titles == [f"pen: {sensors}, 2 runs each" for sensors in (SENSORS, BLIND)]


def test_the_figure_draws_the_mean_over_runs_of_nees_per_state() -> None:
    (one,) = outcome(0).series
    assert one.estimate.shape == one.time_s.shape
    assert one.estimate[0] == pytest.approx(
        next(each.bias for each in outcome(0).quantities if each.name == FIRST_NEES) / 24
    )
    rows = [
        (*(NAME, "moving", SENSORS, "ekf", seed, NEES, "1", time_s), scale * time_s, np.nan, np.nan)
        for seed, scale in enumerate((1.0, 2.0, 6.0))
        for time_s in (1.0, 2.0)
    ]
    (figure,) = SUITE.figures(Results(table_of({}), series_of(rows)))
    (panel,) = figure.panels
    ekf, expected = panel.lines
    np.testing.assert_allclose(ekf.y, [3.0, 6.0])
    assert ekf.band is not None
    np.testing.assert_allclose(ekf.band, [[1.2, 2.4], [5.2, 10.4]])
    assert (expected.name, set(expected.y)) == (EXPECTED, {1.0})


def test_claims_speak_of_what_is_measured() -> None:
    assert SUITE.claims is not None
    found = Outcome("pen", quantities(made_up_run(8.0)), 1, 1.0, 1e-5, 1e-5)
    table = table_of(dict.fromkeys(SUITE.tasks(Scope(1)), found))
    judged = judge(load_claims(SUITE.claims), table)
    assert not [each.claim.id for each in judged if each.verdict == NO_DATA]


def test_choices_leave_out_what_reads_no_motion() -> None:
    reference = load_pen("reference")
    inertial = ("accel", "gyro", "accel_lower", "accel_upper")
    assert choices(reference) == [(*inertial, "camera"), inertial]
    only = {"sensors": {name: reference.sensors[name] for name in ("camera", "contact", "area")}}
    assert choices(reference.model_copy(update=only)) == [("camera",)]
    none = {"sensors": {name: reference.sensors[name] for name in ("contact", "area", "rest")}}
    with pytest.raises(InputError, match="has no sensor with a rate that reads its motion"):
        choices(reference.model_copy(update=none))


def test_a_pen_of_ones_own_is_asked(tmp_path: Path) -> None:
    assert (made_of(Scope(1)), own(Scope(1))) == ("", {})
    path = tmp_path / "my pen.toml"
    path.write_text(
        'name = "mine"\n[sensors.imu]\npreset = "ADXL202"\nposition_m = [0.0, 0.0, 0.02]\n'
        "rate_hz = 50.0\n"
    )
    scope = Scope(2, pen=str(path), estimators=("ekf",), cases=("settled",))
    first = made_of(scope)
    found = chosen_tasks([NAME], scope)
    assert {each.sensors for each in found} == {"imu"}
    outcome = SUITE.run(found[0], scope)
    assert outcome.model.startswith("mine, ")
    assert own(scope)["again"] == (
        f"pen-mhe benchmark consistency --pen '{path}' --seeds 2 --estimators ekf --cases settled"
    )
    path.write_text(path.read_text().replace("0.02]", "0.03]"))
    assert made_of(scope) != first
    assert made_of(replace(scope, pen="reference")) != made_of(replace(scope, pen="dpoint"))
