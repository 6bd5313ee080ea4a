"""Figures from a small table, and from what is left of it."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from benchmark.figures.figure import TRUTH, Figure
from benchmark.runner.tables import result_rows
from benchmark.tasks.results import RESULT_COLUMNS, SERIES_COLUMNS, Results
from benchmark.tasks.task import Outcome, Quantity, Task, failed
from suites.pen.figures import figures
from suites.pen.pen_cases import REFERENCE, SPIN_IGNORED, WITHOUT_SPIN
from suites.pen.told_tolerance import SHOWN, SWEEP

ESTIMATORS = ("ekf", "mhe")
TIME_S = np.arange(0, 2, 0.5)
NEGLECTED = "accelerations neglected, speed 3"
KEYS = [
    *("pen-elevation", "pen-paths", "pen-spin-ignored", "pen-speeds"),
    *("pen-figure-4-vertical", "pen-figure-4", "pen-starts", "pen-by-stroke"),
]


def outcome(rmse: float, *names: str, status: str = "ok") -> Outcome:
    quantities = tuple(Quantity(name, "deg", rmse, 0.0, rmse) for name in names)
    return Outcome("m", quantities, 9, 1.0, 0.0, 0.0, status)


def series(task: Task, quantity: str, level: float) -> pd.DataFrame:
    task_columns = {**vars(task), "quantity": quantity, "unit": "deg"}
    columns = {"time_s": TIME_S, "estimate": level + TIME_S, "std": 0.5, "truth": TIME_S}
    return pd.DataFrame({**task_columns, **columns})[list(SERIES_COLUMNS)]


@pytest.fixture(scope="module")
def results() -> Results:
    found: dict[Task, Outcome] = {}
    lines = []
    for level, estimator in enumerate(ESTIMATORS, start=1):
        for seed in range(3):
            for case, names in (
                (SHOWN[0], ("tilts", "tilt_rates")),
                (WITHOUT_SPIN, ("elevation", "rates")),
                (NEGLECTED, ("elevation", "rates")),
                ("start 0 deg", ("tilts_last",)),
            ):
                task = Task("pen", case, "accel+gyro", estimator, seed)
                found[task] = outcome(level * (seed + 1.0), *names)
        for seed, (rmse, status) in enumerate([(1.0, "ok"), (90.0, "mirror"), (5.0, "ok")]):
            task = Task("pen", "start 60 deg", "accel", estimator, seed)
            found[task] = outcome(level * rmse, "tilts_last", status=status)
        for quantity in ("tilt_phi", "tilt_theta", "tilt_phi_rate", "tilt_theta_rate"):
            lines += [
                series(Task("pen", case, "gyro", estimator, 0), quantity, level) for case in SHOWN
            ]
        for quantity in ("tip_x", "tip_y", "elevation"):
            task = Task("pen", REFERENCE, "camera", estimator, 0)
            lines.append(series(task, quantity, level))
        for case, wrong in ((SPIN_IGNORED, 20), (REFERENCE, 1)):
            task = Task("pen", case, "accel+gyro", estimator, 0)
            lines.append(series(task, "elevation", level * wrong))
    found[Task("pen", SHOWN[1], "accel", "ekf", 0)] = failed("it broke")
    rows = pd.DataFrame(
        [row for pair in found.items() for row in result_rows(*pair)], columns=list(RESULT_COLUMNS)
    )
    return Results(rows, pd.concat(lines, ignore_index=True))


def drawn(results: Results) -> dict[str, Figure]:
    return {figure.key: figure for figure in figures(results)}


@pytest.fixture(scope="module")
def whole(results: Results) -> dict[str, Figure]:
    """The figures of the whole table."""
    return drawn(results)


def test_all_are_drawn_with_units_in_their_labels(whole: dict[str, Figure]) -> None:
    assert list(whole) == KEYS
    for figure in whole.values():
        for panel in figure.panels:
            assert panel.y_label.endswith(")")
            assert len({line.name for line in panel.lines}) == len(panel.lines)
            for line in panel.lines:
                assert len(line.x) == len(line.y) > 0


def test_a_stroke_over_time_has_truth_and_bands(whole: dict[str, Figure]) -> None:
    (panel,) = [
        panel for panel in whole["pen-figure-4-vertical"].panels
        if panel.title == "gyroscope: rate of θ"
    ]  # fmt: skip
    assert [line.name for line in panel.lines] == [TRUTH, *ESTIMATORS]
    truth, ekf, mhe = panel.lines
    assert (list(truth.y), truth.std) == (list(TIME_S), None)
    assert list(ekf.y) == list(1 + TIME_S)
    assert list(mhe.y) == list(2 + TIME_S)
    assert ekf.std is not None
    assert list(ekf.std) == [0.5] * len(TIME_S)


def test_raw_readings_and_the_noise_over_the_tolerance() -> None:
    """A channel is a line; the noise is that of the gyroscope over that of the accelerometer."""
    told = {case: row for case, row in SWEEP.items() if row.stroke == SHOWN[0]}
    raw = Task("pen", SHOWN[0], "accel", "ekf", 0)
    lines = [series(raw, f"raw accel {axis}", 1.0) for axis in "xyz"]
    found = {
        Task("pen", case, sensors, "ekf", seed): outcome(noise * (seed + 1), "jitter")
        for case in (SHOWN[0], *told)
        for sensors, noise in (("gyro", 3.0), ("accel", 2.0))
        for seed in range(2)
    }
    rows = [row for pair in found.items() for row in result_rows(*pair)]
    both = drawn(Results(pd.DataFrame(rows, columns=list(RESULT_COLUMNS)), pd.concat(lines)))
    panels = [panel for panel in both["pen-figure-3"].panels if panel.lines]
    assert [line.name for panel in panels for line in panel.lines] == [
        f"accel {axis}" for axis in "xyz"
    ]
    (line,) = [line for panel in both["pen-tolerance"].panels for line in panel.lines]
    assert list(line.x) == [0.03, 0.1, 0.3, 1.0, 3.0, 10.0]
    assert list(line.y) == [1.5] * 6


def test_mirror_solutions_are_counted_and_not_averaged(whole: dict[str, Figure]) -> None:
    panels = whole["pen-starts"].panels
    by_title = {panel.title: panel for panel in panels}
    errors, mirrors = (
        by_title[f"accelerometer: {what}"] for what in ("runs at the truth", "mirror solutions")
    )
    ekf, mhe = errors.lines
    assert (list(ekf.x), list(ekf.y)) == ([60.0], [3.0])
    assert (ekf.low, ekf.high) == (np.array([1.0]), np.array([5.0]))
    assert list(mhe.y) == [6.0]
    assert [list(line.y) for line in mirrors.lines] == [[pytest.approx(100 / 3)]] * 2


def test_speeds_are_sorted_and_have_their_spread(whole: dict[str, Figure]) -> None:
    elevation, _ = whole["pen-speeds"].panels
    lines = {line.name: line for line in elevation.lines}
    assert set(lines) == {
        f"{name}, {estimator}"
        for name in ("rigid body", "accelerations neglected")
        for estimator in ESTIMATORS
    }
    neglected = lines["accelerations neglected, mhe"]
    assert (list(neglected.x), list(neglected.y)) == ([3.0], [4.0])
    assert (neglected.low, neglected.high) == (np.array([2.0]), np.array([6.0]))
    assert list(lines["rigid body, ekf"].x) == [1.0]


def test_a_pen_taken_for_one_that_cannot_spin_stands_beside_the_free_one(
    whole: dict[str, Figure],
) -> None:
    (panel,) = [panel for panel in whole["pen-spin-ignored"].panels if panel.lines[1:]]
    assert [line.name for line in panel.lines] == [TRUTH, "no spin believed", "free"]
    assert [line.y[0] for line in panel.lines] == [0.0, 20.0, 1.0]


def test_strokes_are_numbered_as_the_caption_says(whole: dict[str, Figure]) -> None:
    figure = whole["pen-by-stroke"]
    number = int(figure.panels[2].lines[0].x[0])
    assert f"{number} {SHOWN[0].partition(': ')[2]}" in figure.caption
    assert list(figure.panels[2].lines[0].y) == [2.0]


def test_the_path_begins_where_errors_are_judged(whole: dict[str, Figure]) -> None:
    (panel,) = whole["pen-paths"].panels
    assert panel.equal
    assert [line.name for line in panel.lines] == [TRUTH, *ESTIMATORS]
    assert list(panel.lines[1].x) == [2.0, 2.5]  # from 1 s on, at level 1


@pytest.mark.parametrize(
    ("column", "value"),
    [
        ("quantity", "tilts"),
        pytest.param("quantity", "tip_y", marks=pytest.mark.slow),
        ("case", REFERENCE),
        pytest.param("case", SPIN_IGNORED, marks=pytest.mark.slow),
        pytest.param("case", WITHOUT_SPIN, marks=pytest.mark.slow),
        ("sensors", "accel+gyro"),
    ],
)
def test_what_is_left_is_drawn(results: Results, column: str, value: str) -> None:
    left = Results(
        results.rows[results.rows[column] != value],
        results.series[results.series[column] != value],
    )
    found = drawn(left)
    assert list(found) == [key for key in KEYS if key in found]
    assert {"pen-figure-4-vertical", "pen-figure-4", "pen-starts"} <= set(found)
    assert all(any(panel.lines for panel in figure.panels) for figure in found.values())


def test_without_the_ekf_the_truth_is_the_others(results: Results) -> None:
    without_ekf = Results(
        results.rows[results.rows["estimator"] != "ekf"],
        results.series[results.series["estimator"] != "ekf"],
    )
    lines = drawn(without_ekf)["pen-figure-4-vertical"].panels[1].lines
    assert [line.name for line in lines] == [TRUTH, "mhe"]


def test_nothing_is_drawn_of_nothing(results: Results) -> None:
    nothing = Results(results.rows[:0], results.series[:0])
    assert figures(nothing) == []
    only_series = Results(results.rows[:0], results.series)
    assert [figure.key for figure in figures(only_series)] == [
        *("pen-elevation", "pen-paths", "pen-spin-ignored", "pen-figure-4-vertical", "pen-figure-4")
    ]
