"""The suite: which tasks there are, what one finds, and what the report shows of them."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from benchmark.runner.tables import result_rows
from benchmark.tasks.results import RESULT_COLUMNS, SERIES_COLUMNS, Results
from benchmark.tasks.suite import Scope
from benchmark.tasks.task import OK, Outcome, Task
from benchmark.verdicts.claims import load_claims
from suites.faults import cells, clean, real
from suites.faults.cells import Bench, bare, run_cell, summary
from suites.faults.contenders import CONTENDERS, SEEDS, without_watch
from suites.faults.protocol import SENSORS, faults_for
from suites.faults.quantities import fault_quantities
from suites.faults.scoring import FaultScore, RunErrors, broken
from suites.faults.suite import SUITE
from suites.faults.table import Fault, fault_named
from suites.table import find_suite
from tests.suites.small_runs import small_suites

BOTH = "accel+gyro"


def task(case: str, estimator: str, sensors: str = BOTH, seed: int = 0) -> Task:
    return Task("faults", case, sensors, estimator, seed)


def named(outcome: Outcome) -> dict[str, float]:
    return {each.name: each.bias for each in outcome.quantities}


def test_it_is_one_of_the_suites() -> None:
    assert find_suite("faults") is SUITE
    assert "faults" in small_suites("")


def test_the_whole_table_runs_from_ten_seeds_on() -> None:
    found = SUITE.tasks(Scope(SEEDS))
    assert len(found) == len(set(found))
    for name in ("ekf", "mhe-rti", "mhe"):
        mine = Counter((each.case, each.sensors) for each in found if each.estimator == name)
        assert set(mine.values()) == {SEEDS}
        expected = {(fault.key, sensors) for sensors in SENSORS for fault in faults_for(sensors)}
        assert expected == {cell for cell in mine if cell[0] not in clean.CLEAN}
        assert {(case, s) for case in clean.CLEAN for s in SENSORS} < set(mine)
    assert {each.seed for each in found if each.estimator == "mhe-ipopt"} == {0}
    assert {each.seed for each in found if each.estimator == without_watch("ekf")} == {0, 1, 2}


def test_below_that_a_seed_of_every_row_of_the_table() -> None:
    found = SUITE.tasks(Scope(5))
    assert {each.seed for each in found} == {0}
    assert {each.estimator for each in found} == {"ekf", without_watch("ekf")}
    rows = [fault_named(each.case).name for each in found if each.case not in clean.CLEAN]
    assert set(Counter(rows).values()) == {2}  # with a watch and without
    assert set(rows) == {fault.name for fault in faults_for("accel+gyro+camera")}


def test_its_claims_speak_of_what_it_finds() -> None:
    assert SUITE.claims is not None
    found = load_claims(SUITE.claims)
    score = broken("so it was")
    quantities = {
        each.name
        for key in ("hole, all, 2 s", "1 Hz, all")
        for each in fault_quantities(fault_named(key), score, sees_tip=True)
    } | {"flags", "lost", "flags on a real recording"}
    for claim in found:
        assert claim.of["quantity"] in quantities
        assert set(claim.of["estimator"]) <= set(CONTENDERS)  # type: ignore[arg-type]
        assert claim.at_most is not None
    limits = {claim.id.split("-", 2)[1]: claim.at_most for claim in found}
    assert [limits[str(n)] for n in range(1, len(found) + 1)] == [
        *(0.03, 0.05, 0.08, 0.05, 0.05, 0.15, 0.15, 0.0, 0.0, 0.05, 1.0, 0.1, 0.0, 0.0)
    ]


@pytest.fixture(scope="module")
def outcome() -> Outcome:
    """A stuck IMU on an EKF that nobody watches."""
    return SUITE.run(task("stuck, imu, 1 s", without_watch("ekf")), Scope(1))


def test_a_task_with_a_fault(outcome: Outcome) -> None:
    found = named(outcome)
    assert outcome.status == OK
    assert outcome.samples == 801
    assert found["silent wrong"] == 1
    assert found["silent"] == found["wrong"] > 0.2
    assert found["not right within 2 s"] == float(found["right again"] > 2)
    assert found["peak error"] > 5
    assert "not right within 2 s, fault stays" not in found
    (tip,) = (each for each in outcome.quantities if each.name == "peak tip error")
    assert not tip.observable


def test_a_watch_says_what_is_stuck() -> None:
    outcome = SUITE.run(task("stuck, imu, 1 s", "ekf"), Scope(1))
    assert "accel:stuck" in outcome.reason
    assert named(outcome)["silent wrong"] == 0


def test_a_run_that_breaks_off_is_a_score(monkeypatch: pytest.MonkeyPatch) -> None:
    def breaks(*_: object) -> Any:
        raise ValueError("so it\nwas")

    monkeypatch.setattr(cells, "injected", breaks)
    outcome = SUITE.run(task("stuck, gyro, 1 s", without_watch("ekf")), Scope(1))
    assert (outcome.status, outcome.reason) == (OK, "ValueError: so it was")
    found = named(outcome)
    assert found["broke off or not finite"] == found["silent wrong"] == 1
    assert found["right again"] == math.inf


def test_a_fault_that_is_none_changes_nothing() -> None:
    """Injection, estimator and truth beside the plain run: scaled by one."""
    bench = Bench("ekf", BOTH, bare)
    nothing = replace(fault_named("scale 5 %, gyro"), size=1.0)
    score, errors = bench.scored(nothing, 1)
    clean_errors = bench.clean(1, 8.0)
    assert errors is not None
    np.testing.assert_array_equal(errors.errors, clean_errors.errors)
    assert (score.silent_s, score.wrong_s, score.right_s) == (0, 0, 0)
    assert clean_errors.stds.max() < 5
    assert np.degrees(np.abs(clean_errors.errors[-1]).max()) < 5


def test_a_cell_has_a_score_for_every_seed() -> None:
    scores = run_cell("hole, all, 2 s", "ekf", BOTH, seeds=range(2))
    assert len(scores) == 2
    assert scores[0] != scores[1]
    assert scores == run_cell(fault_named("hole, all, 2 s"), "ekf", BOTH, seeds=range(2))


def test_a_summary_takes_a_cell_for_its_worst_seed() -> None:
    good = FaultScore(0.1, 0.1, 0.0, 0.0, 1, 1, 1, 0, 0, 0, 0)
    bad = replace(good, silent_s=0.3, right_s=2.5)
    found = summary(
        {
            ("hole, all, 2 s", "ekf", BOTH): [good, bad],
            ("dropout, imu, 2 s", "ekf", BOTH): [good, good],
            ("scale 5 %, gyro", "ekf", BOTH): [bad, bad],
        }
    )
    assert found["silent wrong, runs"] == pytest.approx(3 / 6)
    assert found["silent wrong, cells"] == pytest.approx(2 / 3)
    assert found["right again, runs"] == pytest.approx(3 / 4)
    assert found["right again, cells"] == pytest.approx(1 / 2)
    assert found["right again, fault stays, cells"] == 0
    assert found["accurate again, cells"] == 1


def test_a_fault_free_stream_counts_flags_by_hour_and_sensor(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("suites.faults.run.SHORT_S", 2.0)
    outcome = SUITE.run(task("clean, speed 1", without_watch("ekf")), Scope(1))
    assert named(outcome) == {"flags": 0.0, "lost": 0.0}
    assert outcome.samples == 201


def test_real_recordings_run_where_they_are(tmp_path: Path) -> None:
    assert not [each for each in SUITE.tasks(Scope(SEEDS)) if SUITE.reads(each)]
    (tmp_path / "dpoint_pen").mkdir()
    found = [each for each in SUITE.tasks(Scope(SEEDS, str(tmp_path))) if SUITE.reads(each)]
    assert {SUITE.reads(each) for each in found} == {"dpoint_pen"}
    names = ("ekf", "mhe-rti", "mhe")
    expected = {(s, name) for s in (BOTH, "accel+gyro+camera") for name in names}
    assert {(each.sensors, each.estimator) for each in found} == expected
    (tmp_path / "isa_imu_array").mkdir()
    found = [each for each in SUITE.tasks(Scope(SEEDS, str(tmp_path))) if each.case == real.ARRAY]
    assert Counter(each.estimator for each in found) == dict.fromkeys(names, 8)
    assert not [each for each in SUITE.tasks(Scope(5, str(tmp_path))) if SUITE.reads(each)]


@pytest.mark.slow
@pytest.mark.parametrize(("case", "samples"), [(real.DPOINT, 4600), (real.ARRAY, 30600)])
def test_what_is_said_of_real_recordings(case: str, samples: int, data_folder: Path) -> None:
    outcome = SUITE.run(task(case, "ekf"), Scope(SEEDS, str(data_folder)))
    assert outcome.status == OK
    assert set(named(outcome)) == {"flags on a real recording"}
    assert outcome.samples == pytest.approx(samples, rel=0.03)


def hand_made(case: str, estimator: str, seed: int, score: FaultScore, said: str) -> list[Any]:
    quantities = fault_quantities(fault_named(case), score, sees_tip=True)
    outcome = Outcome("m", tuple(quantities), 9, 1.0, 1e-5, 1e-5, reason=said)
    return list(result_rows(task(case, estimator, seed=seed), outcome))


def test_the_report_shows_the_worst_seed_of_every_cell() -> None:
    good = FaultScore(0.0, 0.5, 0.0, 0.0, 1, 2.0, 3.0, 0, 0, 0, 0)
    rows = [
        *hand_made("hole, all, 2 s", "ekf", 0, good, "lost 2 s"),
        *hand_made("hole, all, 2 s", "ekf", 1, replace(good, silent_s=0.7, peak_deg=9.0), ""),
        *hand_made("stuck, imu, 1 s", "ekf", 0, replace(good, right_s=math.inf), "stuck 1 s"),
    ]
    table = pd.DataFrame(rows, columns=list(RESULT_COLUMNS))
    results = Results(table, pd.DataFrame(columns=list(SERIES_COLUMNS)))
    ((title, _, head, shown),) = SUITE.tables(results)
    assert title == "Every cell of ekf"
    assert {len(row) for row in shown} == {len(head)}
    assert [list(row) for row in shown] == [
        ["hole, all, 2 s", BOTH, "0.7", "0", "9", "3", "nothing"],
        ["stuck, imu, 1 s", BOTH, "0", "never", "2", "3", "stuck 1 s"],
    ]
    silent, right = SUITE.figures(results)
    (panel,) = silent.panels
    (line,) = panel.lines
    assert [line.y[line.x < 0.7].min(), line.y[line.x > 0.71].max()] == [50, 0]
    assert set(right.panels[0].lines[0].y) == {50}  # one at once, one never


def test_errors_are_against_the_motion_at_any_stamp() -> None:
    """Stamps that jitter are judged where they stand: the truth is a function of time."""
    bench = Bench("ekf", BOTH, bare)
    fault: Fault = fault_named("jitter, all, 4 ms, 2 s")
    errors: RunErrors = bench.errors(fault, 0)
    assert len(errors.time_s) == 801
    assert not np.array_equal(errors.time_s, bench.clean(0, 8.0).time_s)
    assert np.degrees(np.abs(errors.errors).max()) < 10
