"""The command ``benchmark speed``."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from benchmark.report.numbers import in_unit
from commands.cli import app
from suites.speed import study
from suites.speed.contender import CONVERGED, STEP, STREAM_CALL
from suites.speed.figures import contender_figure, horizon_figure
from suites.speed.problems import find_problem
from suites.speed.rows import Row
from suites.speed.study import run_speed
from suites.speed.suite import StreamPlan

pytestmark = pytest.mark.usefixtures("interpreted")


def call(*arguments: str) -> Any:
    return CliRunner().invoke(app, arguments)


def test_the_suite_writes_rows_problems_and_figures(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    problems = [find_problem("turntable_20"), find_problem("turntable_20_bounded")]
    few = partial(run_speed, problems=problems, windows=1, stream=StreamPlan(2, 1, 1))
    monkeypatch.setattr(study, "run_speed", few)
    output = tmp_path / "made"
    result = call("benchmark", "speed", "--output", str(output))
    assert result.exit_code == 0, result.stderr
    assert sorted(path.name for path in output.iterdir()) == [
        "journal-speed.jsonl",
        "journal-speed.jsonl.lock",
        "problem_turntable_20.npz",
        "problem_turntable_20_bounded.npz",
        "speed.json",
        "speed.png",
        "speed_horizon.png",
    ]
    rows = json.loads((output / "speed.json").read_text("utf-8"))
    windows = [row for row in rows if row["problem"] == "turntable"]
    assert {row["windows"] for row in windows} == {1}
    for bounds in (False, True):
        ran = {row["contender"] for row in windows if row["bounds"] == bounds}
        assert {"mhe-rti", "mhe", "ipopt", "osqp"} <= ran
    printed = result.stdout
    assert printed.count("| turntable | 20 |") == len(windows)
    (active,) = {row["active_rows"] for row in windows if row["bounds"]}
    assert printed.count(f"| turntable | 20 | {active:.1f} | ") == len(windows) / 2
    for line in printed.splitlines():
        if line.startswith("left out: "):
            assert line.count(": ") >= 2
    verdicts = printed[printed.index("What was promised") :]
    uncompiled = "not judged: there is no compiled call without a compiler"
    promise = "one pass, N = 20, compiled call: at least 200 times faster than ipopt"
    assert f"| {promise} |  | ≥ 200 | {uncompiled} |" in verdicts
    promise = "one pass, N = 20, whole step: at least 200 times faster than ipopt"
    assert f"| {promise} |  | ≥ 200 | no figure |" in verdicts
    promise = "bounded, converged, N = 20, compiled call: against one unbounded pass"
    assert f"| {promise} |  | ≤ 8 | {uncompiled} |" in verdicts
    assert f"problems and figures in {output}" in verdicts


def test_bounded_windows_and_streams_have_panels_of_their_own() -> None:
    def timed(problem: str, mode: str, horizon: int, bounds: bool = False) -> Row:
        return Row(
            problem=problem,
            bounds=bounds,
            contender="a",
            mode=mode,
            horizon=horizon,
            windows=3,
            median_s=1e-3,
            p99_s=2e-3,
            max_s=3e-3,
            cost=None,
            build_s=1.0,
            version="1",
            newest_error_std=None,
            newest_error_max_std=None,
            solved=1.0,
            min_s=1e-3,
            cpu_min_s=1e-3,
            cpu_median_s=1e-3,
        )

    rows = [
        timed("pen15", CONVERGED, 20),
        timed("pen15", CONVERGED, 100),
        timed("pen15", CONVERGED, 20, bounds=True),
        timed("pen15", STEP, 0),
        timed("pen24", STREAM_CALL, 20),
        timed("pen24", STREAM_CALL, 100),
    ]
    panels = [axis for axis in contender_figure(rows).axes if axis.axison]
    assert [axis.get_title() for axis in panels] == [
        "pen15, N = 20",
        "pen15, N = 100",
        "pen15, N = 20, bounded",
        "pen15, stream: time per sample",
        "pen24, stream: factors kept, or full passes",
    ]
    labels = {label.get_text() for label in panels[-1].get_yticklabels()}
    assert labels == {f"a, N = {N}, compiled call" for N in (20, 100)}
    curves = [
        [line.get_xdata().tolist() for line in axis.get_lines()]
        for axis in horizon_figure(rows).axes
    ]
    assert curves == [[[20, 100]], [[20]]]


@pytest.mark.parametrize(
    ("time_s", "text"),
    [(2.5, "2.5 s"), (1e-3, "1 ms"), (46.04e-6, "46 µs"), (3e-10, "0.3 ns"), (1e-6, "1 µs")],
)
def test_times_come_with_a_fitting_unit(time_s: float, text: str) -> None:
    assert in_unit(time_s) == text
