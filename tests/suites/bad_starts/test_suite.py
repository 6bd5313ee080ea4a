"""The suite: its tasks, what one finds, and what the report shows of many."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from functools import cache

import numpy as np
import pandas as pd
import pytest

from benchmark.configurations import BENCHMARK_ESTIMATORS, CONFIGURATIONS
from benchmark.runner.tables import result_rows
from benchmark.tasks.results import RESULT_COLUMNS, SERIES_COLUMNS, Results
from benchmark.tasks.suite import Scope
from benchmark.tasks.task import OK, Outcome, Task
from benchmark.verdicts.claims import load_claims
from benchmark.verdicts.judge import NO_DATA, judge
from models.errors import InputError
from suites.bad_starts.cases import CASES, KNOWLEDGE, case_model
from suites.bad_starts.figures import SHOWN
from suites.bad_starts.quantities import (
    AT_S,
    END,
    FIRST_RATES,
    FIRST_UP,
    HONEST,
    NEAR,
    RATES,
    UP,
    quantities,
    series,
    up_after,
)
from suites.bad_starts.run import BadStartRun, run_bad_start
from suites.bad_starts.suite import NAME, SUITE, UNSCENTED, UNSCENTED_CASES
from suites.bad_starts.tables import CELLS
from suites.execute import chosen_tasks

CASE = "gesture-30"


def task(case: str = CASE, estimator: str = "ekf", seed: int = 0) -> Task:
    return Task(NAME, case, "two accelerometers", estimator, seed)


def test_every_case_runs_with_the_benchmark_s_estimators() -> None:
    found = SUITE.tasks(Scope(2))
    assert len(found) == len(set(found))
    for name in BENCHMARK_ESTIMATORS:
        mine = Counter(each.case for each in found if each.estimator == name)
        assert mine == dict.fromkeys(CASES, 2)
    unscented = {each.case for each in found if each.estimator == UNSCENTED}
    assert unscented == set(UNSCENTED_CASES)
    for each in found:
        assert CONFIGURATIONS[each.sensors].sensors == CASES[each.case].sensors


def test_an_estimator_that_is_asked_for_runs_in_every_case() -> None:
    found = chosen_tasks([NAME], Scope(1, estimators=("ekf", "mhe-ipopt")))
    assert {(each.case, each.estimator) for each in found} == {
        (case, name) for case in CASES for name in ("ekf", "mhe-ipopt")
    }
    with pytest.raises(InputError, match="estimator eks is unknown, expected one of ekf, mhe, "):
        chosen_tasks([NAME], Scope(1, estimators=("eks",)))
    with pytest.raises(InputError, match="case writing-20 is unknown, expected one of calibrated"):
        chosen_tasks([NAME], Scope(1, cases=("writing-20",)))


@cache
def outcome(seed: int = 0) -> Outcome:
    return SUITE.run(task(seed=seed), Scope(1))


def test_a_task_is_a_run() -> None:
    found, run = outcome(1), run_bad_start(CASES[CASE], "ekf", 1)
    assert (found.status, found.model) == (OK, case_model(CASES[CASE]).name)
    assert (found.samples, found.solved_fraction) == (101, run.solved_fraction)
    assert 0 < found.step_time_median_s <= found.step_time_p99_s
    assert list(found.quantities) == quantities(run)
    for shown, expected in zip(found.series, series(run), strict=True):
        np.testing.assert_array_equal(shown.estimate, expected.estimate)
    with pytest.raises(InputError, match="case worse is unknown, expected one of writing-0, "):
        SUITE.run(task("worse"), Scope(1))
    with pytest.raises(InputError, match="estimator eks is unknown"):
        SUITE.run(task(estimator="eks"), Scope(1))


def made_up_run(size: float, end: float) -> BadStartRun:
    """Return a run of 2 s whose error is `size` in the first second and `end` afterwards."""
    time_s = 4.0 + np.arange(201) / 100
    error = np.where(time_s <= 5.0 + 1e-9, size, end)
    std, step_time_s = np.full(201, 0.1), np.full(201, 1e-5)
    return BadStartRun(0, 0.5, time_s, error, std, 2 * error, step_time_s, 0.5)


def figures_of(size: float, end: float = 1.0) -> dict[str, float]:
    return {each.name: each.rmse for each in quantities(made_up_run(size, end))}


def test_a_run_is_judged_by_its_first_second_and_its_last_instant() -> None:
    """An error of 2 rad, then of 0.05; it claims 0.1."""
    found = figures_of(2.0, 0.05)
    degrees = np.degrees(2.0)
    assert found[FIRST_UP] == pytest.approx(degrees, rel=1e-14)
    assert found[FIRST_RATES] == pytest.approx(4.0, rel=1e-14)
    assert [found[up_after(t)] for t in AT_S[:2]] == pytest.approx([degrees] * 2, rel=1e-14)
    assert up_after(AT_S[2]) not in found  # the run is over by then
    assert found[END] == pytest.approx(0.5)


def test_a_run_has_arrived_within_3_degrees_and_is_honest_within_3_deviations() -> None:
    """3° is 0.052 rad; 3 claimed deviations are 0.3 rad."""
    found = [figures_of(size) for size in (0.05, 0.06, 0.2, 0.4)]
    assert [run[NEAR] for run in found] == [1, 0, 0, 0]
    assert [run[HONEST] for run in found] == [1, 1, 1, 0]


def test_figures_show_every_second_sample_then_every_tenth() -> None:
    up, rates = series(made_up_run(2.0, 0.05))
    assert (up.quantity, up.unit, rates.quantity, rates.unit) == (UP, "deg", RATES, "rad/s")
    np.testing.assert_allclose(np.diff(up.time_s), [0.02] * 50 + [0.1] * 10)
    np.testing.assert_array_equal(up.time_s, rates.time_s)
    np.testing.assert_allclose(up.estimate, np.degrees(np.where(up.time_s <= 5.001, 2.0, 0.05)))
    np.testing.assert_allclose(rates.estimate, 2 * np.radians(up.estimate))


def results(runs: Iterable[tuple[Task, BadStartRun]]) -> Results:
    rows, lines = [], []
    for each, run in runs:
        shown = series(run)
        found = Outcome("pen", tuple(quantities(run)), 201, 0.5, 1e-5, 1e-5, series=shown)
        rows += list(result_rows(each, found))
        for one in shown:
            frame = pd.DataFrame({"time_s": one.time_s, "estimate": one.estimate})
            of_task = {name: getattr(each, name) for name in SERIES_COLUMNS[:5]}
            lines.append(frame.assign(**of_task, quantity=one.quantity))
    return Results(pd.DataFrame(rows, columns=list(RESULT_COLUMNS)), pd.concat(lines))


def test_tables_have_medians_and_90th_percentiles() -> None:
    """Of 1, 2, 3 and 4 rad the median is 2.5 and the 90th percentile 3.7; rates are twice that."""
    ends = (0.01, 0.05, 0.2, 0.3)
    runs = [(task(seed=k), made_up_run(k + 1.0, ends[k])) for k in range(4)]
    runs += [(task("strokes-30", "mhe", k), made_up_run(0.01, 0.01)) for k in range(4)]
    up, rates, near, end = tables = SUITE.tables(results(runs))
    assert [title for title, *_ in tables] == list(CELLS)
    for _, caption, head, rows in tables:
        assert caption == "4 runs of each case by each estimator."
        assert head[3:] == ("ekf", "mhe")
        case = CASES[CASE]
        assert [row[0] for row in rows] == [CASES["strokes-30"].label, case.label]
        assert rows[1][:3] == (case.label, KNOWLEDGE[case.knowledge].label, "30")
        assert (rows[0][3], rows[1][4]) == ("", "")  # not run
    assert up[3][1][3] == "1.4e+02 (2.1e+02); 1.4e+02 (2.1e+02)"
    assert rates[3][1][3] == "5 (7.4)"
    assert (near[3][0][4], near[3][1][3]) == ("100%, 100%", "0%, 0%")
    assert (end[3][0][4], end[3][1][3]) == ("0.1", "1.2")  # of 0.1, 0.5, 2 and 3: 1.25


def test_the_figure_draws_medians_and_the_band_of_most_runs() -> None:
    """Errors 1 … 5: median 3; 10 % and 90 % are 1.4 and 4.6; rates twice that."""
    runs = [
        (task(case, estimator, k), made_up_run(k * scale, k * scale))
        for case in SHOWN
        for estimator, scale in (("ekf", 1.0), ("mhe", 0.1))
        for k in range(1, 6)
    ]
    (figure,) = SUITE.figures(results(runs))
    assert len(figure.panels) == 2 * len(SHOWN)
    for panel, factor in zip(figure.panels[:2], (np.degrees(1.0), 2.0), strict=True):
        assert panel.y_log
        ekf, mhe = panel.lines
        assert (ekf.name, mhe.name) == ("ekf", "mhe")
        np.testing.assert_allclose(ekf.y, 3 * factor)
        np.testing.assert_allclose(mhe.y, 0.3 * factor)
        assert ekf.band is not None
        np.testing.assert_allclose(ekf.band[0], 1.4 * factor)
        np.testing.assert_allclose(ekf.band[1], 4.6 * factor)
    assert [panel.y_label for panel in figure.panels[:2]] == ["error of up (deg)", "error (rad/s)"]
    assert all(case in CASES for case in SHOWN)


def test_of_other_cases_the_first_four_are_shown() -> None:
    runs = [(task(case), made_up_run(1.0, 1.0)) for case in reversed(CASES) if case not in SHOWN]
    (figure,) = SUITE.figures(results(runs))
    shown = [panel.title.partition(":")[0] for panel in figure.panels[::2]]
    assert shown == [case for case in CASES if case not in SHOWN][:4]


def test_claims_speak_of_what_is_measured() -> None:
    assert SUITE.claims is not None
    claims = load_claims(SUITE.claims)
    tasks = SUITE.tasks(Scope(1))
    rows = [
        row
        for each in tasks
        for row in result_rows(
            each, Outcome("pen", tuple(quantities(made_up_run(1.0, 1.0))), 1, 1.0, 1.0, 1.0)
        )
    ]
    table = pd.DataFrame(rows, columns=list(RESULT_COLUMNS))
    assert not [found.claim.id for found in judge(claims, table) if found.verdict == NO_DATA]
