"""The benchmark's question of a pen of one's own: which choices, what they are judged by."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmark.tasks.suite import Scope
from benchmark.tasks.task import Task
from models.errors import InputError
from models.pen_file import load_pen
from recordings.formats.tables import recording_to_table, write_table
from recordings.simulate_pen import simulate
from suites.execute import chosen_tasks, task_identity
from suites.own_pen import own_run
from suites.own_pen.choices import choices
from suites.own_pen.suite import NAME, SUITE

PEN = "dpoint"
OWN = Scope(seeds=2, pen=PEN)
INERTIAL = {"accel", "gyro", "accel+gyro", "accel+gyro+contact"}


def labels(pen: str, *among: str) -> list[str]:
    return [row.label for row in choices(load_pen(pen), among)]


def recorded(folder: Path, *, has_truth: bool, sensors: tuple[str, ...]) -> str:
    whole = simulate(PEN, sensors, motion="handwriting", duration_s=2.0, seed=3)
    path = folder / "mine.csv"
    kept = whole if has_truth else replace(whole, truth=None)
    write_table(recording_to_table(kept, load_pen(PEN)), path)
    return str(path)


def test_choices_follow_from_what_the_kinds_read() -> None:
    assert set(labels("reference", "accel", "gyro", "contact", "area", "rest")) == INERTIAL
    assert labels("reference", "accel", "gyro") == ["accel", "gyro", "accel+gyro"]
    two = labels("reference", "accel_lower", "accel_upper", "camera")
    assert two[:2] == ["accel_lower", "accel_lower+accel_upper"]
    assert set(two[2:]) == {
        "camera", "accel_lower+camera", "accel_lower+accel_upper+camera",
    }  # fmt: skip
    assert set(labels("reference", "accel", "gyro", "contact", "camera")) == INERTIAL | {
        *("camera", "accel+camera", "gyro+camera", "accel+gyro+camera"),
        "accel+gyro+camera+contact",
    }
    assert labels("reference", "contact", "camera") == ["camera", "camera+contact"]
    with pytest.raises(InputError, match="no sensor with readings that observes"):
        labels("reference", "contact", "area")


def test_a_simulated_pen_has_every_choice_estimator_and_seed() -> None:
    tasks = SUITE.tasks(OWN)
    # Three sensors have a rate: a contact without one cannot be simulated.
    assert len(tasks) == len(set(tasks)) == 7 * 3 * 2
    assert {task.case for task in tasks} == {"handwriting"}
    outcome = SUITE.run(Task(NAME, "handwriting", "accel+gyro", "ekf", 0), OWN)
    found = {quantity.name: quantity for quantity in outcome.quantities}
    assert found["elevation"].observable
    assert not found["tip"].observable
    with pytest.raises(InputError, match="motion writing is unknown"):
        SUITE.tasks(replace(OWN, motion="writing"))


def test_a_recording_is_judged_by_its_truth_or_by_a_camera_that_is_not_used(tmp_path: Path) -> None:
    sensors = ("accel", "gyro", "camera")
    scope = replace(OWN, recording=recorded(tmp_path, has_truth=False, sensors=sensors))
    assert {task.seed for task in SUITE.tasks(scope)} == {0}
    without = SUITE.run(Task(NAME, "mine.csv", "accel+gyro", "ekf", 0), scope)
    (elevation,) = without.quantities
    assert elevation.name == "elevation"
    assert np.isfinite(elevation.rmse)
    assert SUITE.run(Task(NAME, "mine.csv", "accel+camera", "ekf", 0), scope).quantities == ()
    # The contact of this pen has no rate; with a recording it is a sensor like the others.
    assert own_run._seen(scope, ("accel", "gyro", "contact"))["elevation_rad"]
    (tmp_path / "b").mkdir()
    blind = recorded(tmp_path / "b", has_truth=False, sensors=("accel", "gyro"))
    with pytest.raises(InputError, match="has neither a truth nor readings of a camera"):
        SUITE.tasks(replace(OWN, recording=blind))


def test_what_is_finished_is_of_one_pen_and_motion() -> None:
    task = chosen_tasks([NAME], OWN)[0]
    others = [replace(OWN, pen="reference"), replace(OWN, motion="turn")]
    assert len({task_identity(task, scope) for scope in (OWN, *others)}) == 3
    assert task_identity(task, OWN) == task_identity(task, replace(OWN, estimators=("ekf",)))


def test_no_estimator_sees_the_truth(monkeypatch: pytest.MonkeyPatch) -> None:
    real, given = own_run.run, []

    def spied(estimator, recording):  # type: ignore[no-untyped-def]
        given.append((recording.truth, set(recording.readings)))
        return real(estimator, recording)

    monkeypatch.setattr(own_run, "run", spied)
    SUITE.run(Task(NAME, "handwriting", "gyro", "ekf", 0), OWN)
    assert given == [(None, {"gyro"})]
