"""The suite: its tasks, its claims, its figures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from benchmark.tasks.results import RESULT_COLUMNS, SERIES_COLUMNS, Results
from benchmark.tasks.suite import Scope
from benchmark.tasks.task import Outcome, Quantity, Task
from benchmark.verdicts.claims import load_claims
from classical_baseline.differentiators import DIFFERENTIATORS
from models.errors import InputError
from suites.gyro_free.array_pairs import FOLDER, PARTS
from suites.gyro_free.array_task import run_array
from suites.gyro_free.cases import (
    ARRAY_CASES,
    BEGIN,
    CASES,
    CLASSICAL,
    LOOKS_AHEAD,
    NO_ROLL,
    NO_SPIN,
    TWO_ACCELS,
)
from suites.gyro_free.figure_sweeps import BY_DISTANCE, BY_NOISE
from suites.gyro_free.gesture import GestureConfig, gesture
from suites.gyro_free.scores import Estimated, angle_between, growth, scores
from suites.gyro_free.suite import SUITE, array_tasks, run, simulated_tasks
from tests.recordings.array_recording import write_array

SCOPE = Scope(seeds=1)
PLAIN = ("gyro-free-integrated", "gyro-free")
SEGMENTS = dict.fromkeys(PARTS, 3)


def task(case: str, estimator: str, sensors: str = TWO_ACCELS, seed: int = 0) -> Task:
    return Task("gyro-free", case, sensors, estimator, seed)


@pytest.fixture(scope="module")
def made_up(tmp_path_factory: pytest.TempPathFactory) -> str:
    data = tmp_path_factory.mktemp("data")
    write_array(data / FOLDER)
    return str(data)


@pytest.fixture(scope="module")
def outcomes(made_up: str) -> dict[Task, Outcome]:
    """One seed of a few cases, all kinds of estimators."""
    chosen = [
        *(task("test case", name) for name in CLASSICAL if name != "gyro-free-careful"),
        *(
            task(case, name)
            for case in ("l 10 mm", "noise x10")
            for name in ("gyro-free-integrated", "gyro-free")
        ),
        task("test case", "ekf", NO_ROLL),
        task("test case", "mhe-rti", NO_ROLL),
    ]
    found = {one: run(one, SCOPE) for one in chosen}
    for one in array_tasks(1, SEGMENTS):
        if one.estimator in PLAIN:
            found[one] = run(one, Scope(1, made_up))
    return found


def tables(outcomes: Mapping[Task, Outcome]) -> Results:
    rows: list[dict[str, Any]] = []
    series = []
    for one, outcome in outcomes.items():
        figures = {key: getattr(outcome, key) for key in RESULT_COLUMNS if hasattr(outcome, key)}
        for quantity in outcome.quantities:
            values = asdict(quantity)
            rows.append({**asdict(one), **figures, **values, "quantity": values.pop("name")})
        for line in outcome.series:
            n = len(line.time_s)
            nan = np.full(n, np.nan)
            series.append(
                pd.DataFrame(
                    {
                        **asdict(one),
                        "quantity": line.quantity,
                        "unit": line.unit,
                        "time_s": line.time_s,
                        "estimate": line.estimate,
                        "std": nan if line.std is None else line.std,
                        "truth": nan if line.truth is None else line.truth,
                    }
                )
            )
    return Results(
        pd.DataFrame(rows, columns=RESULT_COLUMNS),
        pd.concat(series) if series else pd.DataFrame(columns=SERIES_COLUMNS),
    )


def test_tasks_are_unique_and_slow_ones_come_first() -> None:
    tasks = SUITE.tasks(Scope(seeds=2))
    assert len(set(tasks)) == len(tasks)
    assert {one.suite for one in tasks} == {"gyro-free"}
    estimators = [one.estimator for one in tasks]
    assert estimators[:2] == ["mhe-ipopt", "mhe"]
    full = [one for one in SUITE.tasks(Scope(seeds=20)) if one.estimator == "mhe-ipopt"]
    assert [(one.case, one.seed) for one in full] == [(BEGIN, seed) for seed in range(5)]
    beside = {one.seed for one in tasks if one.case == BEGIN and one.estimator == "mhe"}
    assert beside == {0}
    assert "mhe" not in estimators[estimators.index("ekf") :]
    assert {one.case for one in tasks} == set(CASES)


def test_every_claim_judges_something() -> None:
    tasks = [*simulated_tasks(1), *array_tasks(1, SEGMENTS)]
    known = {
        *(quantity.name for quantity in run(task("test case", "gyro-free"), SCOPE).quantities),
        "rate by size",
    }
    for claim in load_claims(SUITE.claims):
        assert claim.id.startswith("gyro-free-")
        for chosen in (claim.of, {**claim.of, **(claim.against or {})}):
            for column, values in chosen.items():
                for value in values if isinstance(values, tuple) else (values,):
                    rest = {**chosen, column: value}
                    quantities = rest.pop("quantity")
                    assert (
                        set(quantities if isinstance(quantities, tuple) else [quantities]) <= known
                    )
                    assert any(
                        all(
                            getattr(one, key) in (v if isinstance(v, tuple) else (v,))
                            for key, v in rest.items()
                        )
                        for one in tasks
                    ), f"{claim.id}: nothing has {column} {value}"


def test_a_task_is_deterministic(outcomes: dict[Task, Outcome]) -> None:
    for one in (task("test case", "gyro-free-backward"), task("test case", "mhe-rti", NO_ROLL)):
        again = run(one, SCOPE)
        first = outcomes[one]
        assert again.quantities == first.quantities
        for line, other in zip(again.series, first.series, strict=True):
            np.testing.assert_array_equal(line.estimate, other.estimate)
        assert (again.samples, again.solved_fraction) == (first.samples, first.solved_fraction)


def test_the_compensation_helps_and_the_plain_difference_harms(
    outcomes: dict[Task, Outcome],
) -> None:
    def rate(name: str, sensors: str = TWO_ACCELS) -> float:
        quantities = outcomes[task("test case", name, sensors)].quantities
        return next(quantity.rmse for quantity in quantities if quantity.name == "rate")

    assert rate("gyro-free") < 0.9 * rate("gyro-free-integrated") < rate("gyro-free-backward")
    assert rate("ekf", NO_ROLL) < rate("gyro-free")


def test_a_bias_of_the_difference_is_an_error_that_is_known(
    outcomes: dict[Task, Outcome],
) -> None:
    """Integrated, 1e-4 g over 2 l in either axis grows to b T: RMS √2 b T / √3."""
    quantities = outcomes[task("test case", "gyro-free-integrated")].quantities
    found = {quantity.name: quantity.rmse for quantity in quantities}
    bias = np.degrees(1e-4 * 9.81 / 0.08)
    assert found["rate"] == pytest.approx(bias * 2.0 * np.sqrt(2 / 3), rel=0.02)
    assert found["angular acceleration"] == pytest.approx(bias * np.sqrt(2), rel=0.02)
    assert found["rate growth"] == pytest.approx(np.sqrt(7), rel=0.02)
    assert found["compensated"] == 0


def test_figures_are_drawn(outcomes: dict[Task, Outcome]) -> None:
    keys = [figure.key for figure in SUITE.figures(tables(outcomes))]
    assert keys == [
        "gyro-free-figures-3-4",
        "gyro-free-distance",
        "gyro-free-noise",
        "gyro-free-helps",
        "gyro-free-path",
        "gyro-free-array",
    ]
    for figure in SUITE.figures(tables(outcomes)):
        for panel in figure.panels:
            assert panel.x_label
            for line in panel.lines:
                assert line.x.shape == line.y.shape
                assert np.isfinite(line.y).all()


def test_figures_say_nothing_of_what_did_not_run(outcomes: dict[Task, Outcome]) -> None:
    assert list(SUITE.figures(tables({}))) == []
    one = task("l 10 mm", "gyro-free")
    assert [f.key for f in SUITE.figures(tables({one: outcomes[one]}))] == ["gyro-free-distance"]


def test_sweeps_change_one_thing() -> None:
    assert sorted(BY_DISTANCE.values()) == [10, 20, 40, 80, 160]
    assert sorted(BY_NOISE.values()) == [1, 3, 10, 30, 100]


def test_without_data_there_are_no_array_tasks_and_a_line_says_so(tmp_path: Path) -> None:
    for scope in (Scope(1), Scope(1, str(tmp_path))):
        assert not {one.case for one in SUITE.tasks(scope)} & set(ARRAY_CASES)
        assert FOLDER in SUITE.missing(scope)
        assert "\n" not in SUITE.missing(scope)
    with pytest.raises(InputError, match="array edge has no data"):
        run(task("array edge", "gyro-free"), SCOPE)
    with pytest.raises(InputError, match="case nowhere is unknown"):
        run(task("nowhere", "gyro-free"), SCOPE)


def test_with_data_every_part_is_run(made_up: str) -> None:
    scope = Scope(50, made_up)
    assert SUITE.missing(scope) == ""
    tasks = [one for one in SUITE.tasks(scope) if one.case in ARRAY_CASES]
    for name, case in ARRAY_CASES.items():
        seeds = {one.seed for one in tasks if one.case == name}
        assert seeds == set(range(len(PARTS[case.part](made_up))))
        assert seeds


def test_an_array_task_pools_all_its_pairs(made_up: str, outcomes: dict[Task, Outcome]) -> None:
    one = task("array edge", "gyro-free-integrated")
    outcome = outcomes[one]
    segment = PARTS["turns"](made_up)[0].samples
    assert outcome.samples == len(ARRAY_CASES["array edge"].pairs) * (segment.stop - segment.start)
    found = {quantity.name: quantity for quantity in outcome.quantities}
    assert set(found) == {"rate", "roll rate", "rate by size"}
    assert run_array(one, made_up).quantities == outcome.quantities


def test_who_looks_ahead_says_so() -> None:
    ahead = {name for name, row in CLASSICAL.items() if row and row.differentiator.ahead}
    assert set(LOOKS_AHEAD) == ahead == {"gyro-free-central", "gyro-free-centred"}
    assert all(DIFFERENTIATORS[key].ahead for key in ("central", "savitzky-golay-centred"))
    assert NO_SPIN in CASES["roll"].sensors


def test_scores_of_a_perfect_and_of_a_shifted_estimate() -> None:
    motion = gesture(GestureConfig(), 0)
    perfect = scores(motion, Estimated(motion.rate, motion.C, motion.position))
    assert all(quantity.rmse == 0 for quantity in perfect if quantity.name != "rate growth")
    shift = np.array([0.5, 0.03, -0.04])
    away = motion.position + np.array([0.003, 0, 0.004])
    shifted = scores(motion, Estimated(motion.rate + np.radians(shift), motion.C, away))
    found = {quantity.name: quantity.rmse for quantity in shifted}
    assert found["rate"] == pytest.approx(0.05)
    assert found["rate growth"] == pytest.approx(1)
    assert found["roll rate"] == pytest.approx(0.5)
    assert found["path"] == found["path end"] == pytest.approx(5)
    length = np.linalg.norm(np.diff(motion.position, axis=0), axis=1).sum()
    assert found["path end by length"] == pytest.approx(0.5 / length)
    assert isinstance(shifted[0], Quantity)


def test_a_roll_that_is_taken_for_zero_is_not_observed(outcomes: dict[Task, Outcome]) -> None:
    for one, outcome in outcomes.items():
        roll = next(quantity for quantity in outcome.quantities if quantity.name == "roll rate")
        assert not roll.observable, one
        assert all(q.observable for q in outcome.quantities if q.name != "roll rate")
    free = run(task("test case", "ekf"), SCOPE)
    assert all(quantity.observable for quantity in free.quantities)


def test_angles_between_attitudes() -> None:
    from scipy.spatial.transform import Rotation

    first = Rotation.random(9, random_state=0)
    for size in (1e-9, 1e-3, 1.0, 3.0):
        second = Rotation.from_rotvec(size * np.array([0.6, 0.0, 0.8])) * first
        found = angle_between(first.as_matrix(), second.as_matrix())
        np.testing.assert_allclose(found, size, rtol=1e-6)
    assert growth(np.ones((10, 2))) == 1
    assert growth(np.repeat([0.0, 1.0], 5)[:, None]) == np.inf
