"""The suite: which streams, one race for all of a case, figures and tables of what is there."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fnmatch import fnmatchcase
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import pandas as pd
import pytest

from benchmark.runner.tables import result_rows
from benchmark.tasks.results import RESULT_COLUMNS, SERIES_COLUMNS, Results
from benchmark.tasks.suite import Scope
from benchmark.tasks.task import Outcome, Quantity, Task
from benchmark.verdicts.claims import Claim, load_claims
from mhe.reuse import REUSE_THRESHOLD
from models.errors import InputError
from suites.real_time import suite as suite_module
from suites.real_time.cases import CASES, INSTANTS, LATE, deadline_case, reuse_case
from suites.real_time.deadlines import DUE, OVERRUN, PREDICTED, SOLVED, STOPPED
from suites.real_time.deadlines import LATE as LATE_STEPS
from suites.real_time.figures import AIM, DEFAULT, figures
from suites.real_time.reuse import FULL, KEPT, NEWEST, TIME, threshold_name
from suites.real_time.sample_times import time_quantities
from suites.real_time.streams import FOLDER, STREAMS, Stream
from suites.real_time.suite import NAME, SUITE
from suites.real_time.tables import tables


@pytest.fixture
def data(tmp_path: Path) -> str:
    (tmp_path / FOLDER).mkdir()
    return str(tmp_path)


def test_without_recordings_the_simulated_streams_are_left(data: str, tmp_path: Path) -> None:
    few, everything = SUITE.tasks(Scope(2)), SUITE.tasks(Scope(2, data))
    assert set(few) < set(everything)
    assert len(set(everything)) == len(everything)
    real = {task.case for task in set(everything) - set(few)}
    assert real == {name for name, case in CASES.items() if case.is_real} != set()
    assert {task.seed for task in everything} == {0, 1}
    assert not any("," in task.case or "," in task.estimator for task in everything)  # as options
    assert {SUITE.reads(task) for task in few} == {""}
    assert {SUITE.reads(task) for task in everything if task.case in real} == {FOLDER}
    assert "they need a folder with dpoint_pen/" in SUITE.missing(Scope())
    assert SUITE.missing(Scope(data=str(tmp_path / "other")))
    assert SUITE.missing(Scope(data=data)) == ""


@pytest.fixture
def raced(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[Stream]]:
    """The streams that a case was raced on."""
    seen: list[Stream] = []

    def race(stream: Stream) -> dict[str, Outcome]:
        seen.append(stream)
        return {name: Outcome(name, (), 1, 1.0, 0.0, 0.0) for name in ("a", "b")}

    cases = {"stub": replace(CASES["turntable_20"], contenders=("a", "b"), race=race)}
    monkeypatch.setattr(suite_module, "CASES", MappingProxyType(cases))
    suite_module._raced.cache_clear()
    yield seen
    suite_module._raced.cache_clear()


def test_a_case_is_raced_once_a_seed(raced: list[Stream]) -> None:
    for seed in (0, 1):
        for name in ("a", "b"):
            assert SUITE.run(Task(NAME, "stub", "", name, seed), Scope()).model == name
    first, second = raced
    assert np.abs(first.recording.sensor("gyro")[1] - second.recording.sensor("gyro")[1]).max() > 0
    with pytest.raises(InputError, match="estimator c is unknown"):
        SUITE.run(Task(NAME, "stub", "", "c", 0), Scope())
    with pytest.raises(InputError, match="case nowhere is unknown"):
        SUITE.run(Task(NAME, "nowhere", "", "a", 0), Scope())


@pytest.mark.parametrize("claim", load_claims(SUITE.claims), ids=lambda claim: claim.id)
def test_every_claim_finds_its_rows(claim: Claim, data: str) -> None:
    """Of judged streams only, and of all of these."""
    said = {NEWEST, TIME, LATE_STEPS}
    cases = claim.of["case"] if isinstance(claim.of["case"], tuple) else (claim.of["case"],)
    found = [
        task
        for task in SUITE.tasks(Scope(1, data))
        if any(fnmatchcase(task.case, str(case)) for case in cases)
        and task.estimator == claim.of.get("estimator", task.estimator)
    ]
    assert claim.of["quantity"] in said
    if claim.of["quantity"] == LATE_STEPS:
        assert [task.estimator for task in found] == ["mhe-rti", "mhe"]
        return
    horizons = {task.case.rpartition("_")[2] for task in found}
    judged = {
        reuse_case(name, int(N)) for name, s in STREAMS.items() if s.is_judged for N in horizons
    }
    assert {task.case for task in found} == judged
    assert {task.estimator for task in found} == {threshold_name(REUSE_THRESHOLD)}


def results_of(found: dict[Task, tuple[Quantity, ...]]) -> Results:
    rows: list[Any] = [
        row
        for task, quantities in found.items()
        for row in result_rows(task, Outcome("", quantities, 10, 1.0, 0.0, 0.0))
    ]
    return Results(
        pd.DataFrame(rows, columns=list(RESULT_COLUMNS)),
        pd.DataFrame(columns=list(SERIES_COLUMNS)),
    )


def kept(away: float, time: float) -> tuple[Quantity, ...]:
    return (
        Quantity(NEWEST, "σ", away, 0.0, 3 * away),
        Quantity.single(KEPT, "1", 0.8),
        Quantity.single(TIME, "full passes", time),
    )


def test_a_figure_has_a_line_per_stream_that_is_judged() -> None:
    found = {
        Task(NAME, reuse_case(stream, 20), "", threshold_name(threshold), seed): kept(away, time)
        for stream in ("pen24", "pen15")
        for threshold in (0.2, 0.5)
        for seed, away, time in ((0, 0.01, 0.4), (1, 0.03, 0.6))
    }
    (figure,) = figures(results_of(found))
    assert [panel.title for panel in figure.panels] == ["distance, N = 20", "time, N = 20"]
    for panel, (low, mean, high) in zip(
        figure.panels, ((0.01, 0.02, 0.03), (0.4, 0.5, 0.6)), strict=True
    ):
        aim, default, line = panel.lines
        assert (aim.name, default.name, line.name) == (AIM, DEFAULT, STREAMS["pen24"].label)
        assert line.x.tolist() == [0.2, 0.5]
        for values, expected in ((line.low, low), (line.y, mean), (line.high, high)):
            np.testing.assert_allclose(values, expected)  # type: ignore[arg-type]
    assert figures(results_of({})) == []


def test_tables_have_means_over_the_seeds() -> None:
    assert tables(results_of({})) == []
    times = np.array([1.0, 2.0, 6.0]) * 1e-6
    frames = np.array([True, False, False])
    both = (
        *time_quantities(times, frames, ", frames at capture"),
        *time_quantities(2 * times, frames, ", frames as they arrive"),
    )
    late = [
        tuple(
            Quantity.single(name, "1", value)
            for name, value in (
                *((LATE_STEPS, share), (OVERRUN, 1e3 * share), (DUE, 1e4)),
                *((PREDICTED, 0.25), (STOPPED, 0.0), (SOLVED, 0.75)),
            )
        )
        for share in (0.0, 0.02)
    ]
    found = {
        Task(NAME, reuse_case("pen24", 20), "", FULL, 0): kept(0.0, 1.0),
        Task(NAME, reuse_case("pen24", 20), "", "threshold 0.5", 0): kept(0.01, 0.4),
        Task(NAME, reuse_case("pen24", 20), "", "threshold 0.5", 1): kept(0.03, 0.6),
        Task(NAME, deadline_case("10-ms"), "", "mhe", 0): late[0],
        Task(NAME, deadline_case("10-ms"), "", "mhe", 1): late[1],
        Task(NAME, INSTANTS, "", "ekf", 0): time_quantities(times, frames),
        Task(NAME, LATE, "", "ekf", 0): both,
    }
    reuse, deadlines, instants, lates = (list(rows) for *_, rows in tables(results_of(found)))
    label = STREAMS["pen24"].label
    assert reuse == [
        (label, "20", FULL, "0.000", "0.00", "80%", "1.00"),
        (label, "20", "threshold 0.5 (default)", "0.020", "0.06", "80%", "0.50"),
    ]
    assert deadlines == [
        ("mhe", "10 ms", "10 ms", "20", "99.000%", "20 µs", "25.00%", "0.00%", "75.00%")
    ]
    assert instants == [("ekf", "2 µs", "5.92 µs", "6 µs", "1 µs")]
    assert lates == [
        ("ekf", "at capture", "2 µs", "3 µs", "5.92 µs", "1 µs", "1.00"),
        ("ekf", "as they arrive", "4 µs", "6 µs", "11.8 µs", "2 µs", "2.00"),
    ]
