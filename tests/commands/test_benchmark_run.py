"""The commands ``benchmark`` and ``report``: what they pass on, keep, and say."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from filelock import FileLock
from typer.testing import CliRunner

from benchmark.runner.outcome_lines import NAME as JOURNAL
from benchmark.runner.run import Workers
from benchmark.runner.tables import read_tables
from benchmark.tasks.suite import Scope
from benchmark.tasks.task import Outcome, Task
from commands import benchmark_run
from commands.cli import app
from suites.execute import chosen_tasks, execute, run_suites

SOME = [Task("pen", "start 0 deg", "accel", "ekf", seed) for seed in range(4)]


def call(*arguments: str) -> Any:
    return CliRunner().invoke(app, arguments)


def sentence(result: Any, exit_code: int = 2) -> str:
    assert result.exit_code == exit_code
    message = str(result.stderr).strip()
    assert message.startswith("pen-mhe: ")
    assert "\n" not in message
    return message.removeprefix("pen-mhe: ")


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """The suite pen has four tasks."""
    monkeypatch.delenv("PEN_MHE_DATA", raising=False)
    monkeypatch.setattr(
        benchmark_run, "chosen_tasks", lambda suites, scope: SOME if "pen" in suites else []
    )


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[tuple[Any, ...]]:
    """What the command asks for, which does not run."""
    monkeypatch.delenv("PEN_MHE_DATA", raising=False)
    calls: list[tuple[Any, ...]] = []
    monkeypatch.setattr(benchmark_run, "run_benchmark", lambda *given: calls.append(given[:4]))
    return calls


def test_all_suites_run_without_a_name(asked: list[tuple[Any, ...]], tmp_path: Path) -> None:
    assert call("benchmark").exit_code == 0
    arguments = ["--output", str(tmp_path), "--seeds", "3", "--jobs", "1", "--data", str(tmp_path)]
    assert call("benchmark", "real", "pen", "real", *arguments).exit_code == 0
    assert call("benchmark", "tilt", "--scheduler", "tcp://there:1").exit_code == 0
    everything = ["pen", "tilt", "gyro-free", "classics", "faults", "real"]
    assert asked == [
        (everything, Path("results"), Scope(5, None), Workers(2, None)),
        (["real", "pen"], tmp_path, Scope(3, str(tmp_path)), Workers(1, None)),
        (["tilt"], Path("results"), Scope(5, None), Workers(2, "tcp://there:1")),
    ]


def test_estimators_restrict_the_tasks_of_any_suite(asked: list[tuple[Any, ...]]) -> None:
    assert call("benchmark", "tilt", "--estimators", "ekf, mhe").exit_code == 0
    assert asked[0][2] == Scope(5, None, ("ekf", "mhe"))
    for name in ("pen", "tilt", "gyro-free"):
        every = chosen_tasks([name], Scope(1))
        some = chosen_tasks([name], Scope(1, estimators=("mhe", "ekf")))
        assert some == [task for task in every if task.estimator in ("ekf", "mhe")]
        assert {task.estimator for task in some} == {"ekf", "mhe"}


def test_an_estimator_that_no_suite_runs_is_refused(tmp_path: Path) -> None:
    said = sentence(
        call("benchmark", "pen", "--estimators", "ekf,mhe-rtj", "--output", str(tmp_path / "new"))
    )
    assert said.startswith("estimator mhe-rtj is unknown, expected one of ekf, mhe, ")
    assert said.endswith("did you mean mhe-rti?")
    assert not (tmp_path / "new").exists()


def test_the_data_folder_comes_from_its_variable(
    asked: list[tuple[Any, ...]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PEN_MHE_DATA", str(tmp_path))
    assert call("benchmark", "real").exit_code == 0
    assert asked[0][2] == Scope(5, str(tmp_path))


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (
            ("sped",),
            "suite sped is unknown, expected one of pen, tilt, gyro-free, classics, faults, real",
        ),
        (("pen", "stroke"), "suite stroke is unknown, expected one of pen, tilt"),
        (("pen", "--motion", "turn"), "--motion and --recording are of --pen, expected a pen"),
        (
            ("tilt", "--pen", "dpoint"),
            "--pen with suites tilt, expected suite pen or consistency alone",
        ),
        (("--pen", "dpoint"), "expected suite pen or consistency alone"),
        (("pen", "consistency", "--pen", "dpoint"), "--pen with suites pen, consistency, expected"),
        (
            ("consistency", "--pen", "dpoint", "--motion", "turn"),
            "--motion is not read by suite consistency, expected --pen alone",
        ),
        (
            ("pen", "--pen", "dpoint", "--motion", "turn", "--recording", "r.csv"),
            "--motion beside --recording, expected one of them",
        ),
        (("pen", "--data", "no/where"), "data folder no/where does not exist, expected a folder"),
    ],
)
def test_a_bad_call_begins_nothing(
    asked: list[tuple[Any, ...]], arguments: tuple[str, ...], expected: str
) -> None:
    assert expected in sentence(call("benchmark", *arguments))
    assert asked == []


@pytest.mark.parametrize(("suite", "answers"), [("pen", "own-pen"), ("consistency",) * 2])
def test_a_pen_of_ones_own_is_asked_by_the_suite_that_can(
    asked: list[tuple[Any, ...]], suite: str, answers: str
) -> None:
    assert call("benchmark", suite, "--pen", "reference").exit_code == 0
    ((suites, _, scope, _),) = asked
    assert (suites, scope.pen) == ([answers], "reference")


@pytest.mark.usefixtures("few")
def test_a_run_writes_what_its_report_is_drawn_from(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    result = call("benchmark", "pen", "real", "--output", str(tmp_path / "new"), "--jobs", "1")
    assert result.exit_code == 0, result.stderr
    assert result.stdout.startswith("suite real: left out, it needs recordings")
    assert f"report: {tmp_path / 'new' / 'report.html'}" in result.stdout
    assert {path.name for path in (tmp_path / "new").iterdir()} >= {
        "results.parquet", "series.parquet", "run.json", "report.html", "report.md", JOURNAL,
    }  # fmt: skip
    run = json.loads((tmp_path / "new" / "run.json").read_text())
    assert (run["suites"], run["seeds"]) == (["pen", "real"], 5)
    (session,) = run["sessions"]
    assert (session["tasks"], session["finished"], session["jobs"]) == (4, True, "1")

    page = (tmp_path / "new" / "report.html").read_text()
    (tmp_path / "new" / "report.html").unlink()
    again = call("report", str(tmp_path / "new"))
    assert again.exit_code == 0, again.stderr
    assert (tmp_path / "new" / "report.html").read_text() == page

    monkeypatch.setattr(benchmark_run, "show_report", lambda folder: None)
    once_more = call("benchmark", "pen", "--output", str(tmp_path / "new"), "--jobs", "1")
    assert "4 of 4 tasks are finished already" in once_more.stdout


def interrupted_at(seed: int, task: Task, scope: Scope) -> Outcome:
    """A task during which somebody presses Ctrl-C."""
    if task.seed == seed:
        raise KeyboardInterrupt
    return execute(task, scope)


@pytest.mark.usefixtures("few")
def test_an_interrupted_run_says_so_and_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(benchmark_run, "show_report", lambda folder: None)
    function = partial(interrupted_at, 2)
    monkeypatch.setattr(benchmark_run, "run_suites", partial(run_suites, function=function))
    arguments = ("benchmark", "pen", "--output", str(tmp_path), "--jobs", "1")
    assert sentence(call(*arguments), exit_code=130) == (
        "interrupted after 2 tasks, which are kept; the same command continues"
    )
    assert (tmp_path / JOURNAL).read_bytes().count(b"\n") == 2
    assert not (tmp_path / "results.parquet").exists()

    monkeypatch.setattr(benchmark_run, "run_suites", run_suites)
    again = call(*arguments)
    assert again.exit_code == 0, again.stderr
    assert "2 of 4 tasks are finished already" in again.stdout
    assert list(read_tables(tmp_path).rows["seed"].unique()) == [0, 1, 2, 3]
    sessions = json.loads((tmp_path / "run.json").read_text())["sessions"]
    assert [(one["tasks"], one["finished"]) for one in sessions] == [(2, False), (2, True)]


@pytest.mark.usefixtures("few")
def test_a_folder_that_is_not_free_stays_as_it_is(tmp_path: Path) -> None:
    (tmp_path / "run.json").write_text("{}")
    lock = FileLock(tmp_path / f"{JOURNAL}.lock")
    with lock:
        message = sentence(call("benchmark", "pen", "--output", str(tmp_path)))
    assert message == (f"output {tmp_path} is being written by another run, expected one at a time")
    assert (tmp_path / "run.json").read_text() == "{}"


@pytest.mark.usefixtures("few")
def test_an_output_that_is_no_folder_gets_a_sentence(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    for output in (tmp_path / "file", tmp_path / "file" / "below"):
        message = sentence(call("benchmark", "pen", "--output", str(output)))
        assert message.startswith(f"output {output}: ")
        assert message.endswith("expected a folder that can be written")


@pytest.mark.usefixtures("few")
def test_nothing_to_run_is_said(tmp_path: Path) -> None:
    result = call("benchmark", "real", "--output", str(tmp_path / "new"))
    assert sentence(result) == "suites real have no tasks, expected some"
    assert result.stdout.startswith("suite real: left out, it needs recordings")
    assert not (tmp_path / "new").exists()


def test_a_report_of_no_run_gets_a_sentence(tmp_path: Path) -> None:
    assert "results.parquet does not exist, expected the folder of a finished" in sentence(
        call("report", str(tmp_path))
    )
    assert "does not exist" in sentence(call("report", str(tmp_path / "nowhere")))
