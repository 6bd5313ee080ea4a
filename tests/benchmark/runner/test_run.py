"""A run in this process: what is done again, what is not, what becomes of errors."""

from __future__ import annotations

import os
from pathlib import Path
from types import SimpleNamespace

import pytest

from benchmark.runner import run as run_module
from benchmark.runner.run import Workers, run_alone, run_tasks
from benchmark.runner.single_thread import SINGLE_THREADED
from benchmark.runner.tables import read_tables
from benchmark.tasks.suite import Scope
from benchmark.tasks.task import FAILED, OK, Outcome, Quantity, Task, failed
from models.errors import InputError
from suites import execute as execute_module
from suites.execute import chosen_tasks, execute
from tests.benchmark.runner.workload import no_identity, process_id, tasks, threads

SCOPE = Scope()


class Runs:
    """A task function that counts, and breaks off where it is told to."""

    def __init__(self, broken: set[int] | None = None) -> None:
        self.seeds: list[int] = []
        self.broken = broken or set()

    def __call__(self, task: Task, scope: Scope) -> Outcome:
        self.seeds.append(task.seed)
        if task.seed in self.broken:
            return failed(f"seed {task.seed} broke")
        return Outcome("", (Quantity.single("a", "s", task.seed),), 1, 1.0, 0.0, 0.0)


def ran(folder: Path, function: Runs, n: int = 5, identity: str = "code") -> tuple[int, list[int]]:
    """Run; return the number announced, and the tasks that ran."""
    announced: list[int] = []
    done: list[int] = []

    def on_start(total: int) -> object:
        announced.append(total)
        return done.append

    number = run_tasks(
        tasks(n), SCOPE, Workers(1), folder, on_start, function, lambda task, scope: identity
    )  # type: ignore[arg-type]
    assert announced == [number] == [len(function.seeds)] == [sum(done)]
    return number, function.seeds


def test_finished_tasks_do_not_run_again(tmp_path: Path) -> None:
    assert ran(tmp_path, Runs(), 3) == (3, [0, 1, 2])
    assert ran(tmp_path, Runs(), 5) == (2, [3, 4])
    assert ran(tmp_path, Runs(), 5) == (0, [])
    assert sorted(read_tables(tmp_path).rows["seed"]) == [0, 1, 2, 3, 4]
    # Fewer are asked for: the tables have those.
    assert ran(tmp_path, Runs(), 2) == (0, [])
    assert sorted(read_tables(tmp_path).rows["seed"]) == [0, 1]


def test_other_code_runs_everything_again(tmp_path: Path) -> None:
    assert ran(tmp_path, Runs(), 3)[0] == 3
    assert ran(tmp_path, Runs(), 3, identity="other code")[0] == 3
    assert ran(tmp_path, Runs(), 3)[0] == 0


def test_a_failed_task_is_a_row_and_is_tried_again(tmp_path: Path) -> None:
    ran(tmp_path, Runs({1, 3}))
    rows = read_tables(tmp_path).rows.set_index("seed").sort_index()
    assert list(rows["status"]) == [OK, FAILED, OK, FAILED, OK]
    assert rows.loc[3, "reason"] == "seed 3 broke"
    assert ran(tmp_path, Runs({3})) == (2, [1, 3])
    rows = read_tables(tmp_path).rows.set_index("seed").sort_index()
    assert list(rows["status"]) == [OK, OK, OK, FAILED, OK]


@pytest.mark.parametrize(
    ("error", "reason"),
    [
        (KeyError("what"), "KeyError: 'what'"),
        (ValueError("two\n  lines"), "ValueError: two lines"),
        (ValueError("a file \udcff.csv"), "ValueError: a file ?.csv"),
        (MemoryError(), "MemoryError: "),
    ],
)
def test_whatever_breaks_off_is_a_reason(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: Exception, reason: str
) -> None:
    def run(task: Task, scope: Scope) -> Outcome:
        raise error

    monkeypatch.setattr(execute_module, "find_suite", lambda _: SimpleNamespace(run=run))
    run_tasks(
        tasks(1), SCOPE, Workers(1), tmp_path, lambda _: lambda _: None, execute, lambda *_: "code"
    )
    (row,) = read_tables(tmp_path).rows.to_dict("records")
    assert (row["status"], row["reason"]) == (FAILED, reason)


def raced(folder: Path, monkeypatch: pytest.MonkeyPatch, estimators: str, broken: str = "") -> str:
    """Run a case of which some estimators measure times; return who ran, in order."""
    monkeypatch.setattr(run_module, "is_single_threaded", lambda: True)  # so in this process
    ran: list[str] = []

    def function(task: Task, scope: Scope) -> Outcome:
        ran.append(task.estimator)
        return failed("broke") if task.estimator in broken else Outcome("", (), 1, 1.0, 0.0, 0.0)

    asked = [Task("stub", "moves", "accel", name, 0) for name in estimators]
    number = run_tasks(
        asked,
        SCOPE,
        Workers(1),
        folder,
        lambda _: lambda _: None,
        function,
        lambda *_: "code",
        is_timed=lambda task: task.estimator.isupper(),
    )
    assert number == len(ran)
    return "".join(ran)


def test_what_measures_times_runs_when_the_others_are_finished(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert raced(tmp_path, monkeypatch, "AbCd") == "bdAC"
    assert raced(tmp_path, monkeypatch, "AbCd") == ""


def test_a_race_of_which_one_is_missing_runs_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is timed against each other is of one race."""
    assert raced(tmp_path, monkeypatch, "Ab") == "bA"
    assert raced(tmp_path, monkeypatch, "AbCd", broken="C") == "dAC"
    assert raced(tmp_path, monkeypatch, "AbCd") == "AC"
    assert raced(tmp_path, monkeypatch, "A") == ""


def test_what_measures_times_starts_no_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in SINGLE_THREADED:
        monkeypatch.delenv(name, raising=False)
    found = [*run_alone(threads, [tuple(tasks(2))])]
    assert [race for race, _ in found] == [tuple(tasks(2))]
    said = [outcome.reason for _, outcomes in found for outcome in outcomes]
    assert said == [repr(dict(SINGLE_THREADED))] * 2
    assert not any(name in os.environ for name in SINGLE_THREADED)


def test_what_shares_a_row_is_run_by_one_process(tmp_path: Path) -> None:
    """Tasks of two rows in turn: they need not stand together."""
    some = tasks(10)
    rows = {task: task.seed % 2 for task in some}
    run_tasks(
        some,
        SCOPE,
        Workers(2),
        tmp_path,
        lambda _: lambda _: None,
        process_id,
        no_identity,
        row=rows.__getitem__,
    )
    found = read_tables(tmp_path).rows.set_index("seed")["bias"]
    first, second = (set(found[[seed, seed + 2, seed + 4]]) for seed in (0, 1))
    assert len(first) == len(second) == len(first | second) - 1


def test_an_unknown_suite_is_a_failed_task() -> None:
    assert execute(Task("nowhere", "", "", "", 0), SCOPE).reason.startswith(
        "InputError: suite nowhere is unknown, expected one of"
    )


def test_chosen_suites_in_their_order() -> None:
    found = chosen_tasks(["tilt", "real", "pen"], Scope(seeds=1))
    assert list(dict.fromkeys(task.suite for task in found)) == ["tilt", "pen"]


def test_chosen_cases() -> None:
    all_of_it = chosen_tasks(["tilt"], Scope(seeds=1))
    case = all_of_it[0].case
    found = chosen_tasks(["tilt"], Scope(seeds=1, cases=(case,)))
    assert found == [task for task in all_of_it if task.case == case] != all_of_it
    with pytest.raises(InputError, match="case nowhere is unknown, expected one of"):
        chosen_tasks(["tilt"], Scope(seeds=1, cases=(case, "nowhere")))


def test_workers_in_words() -> None:
    assert (str(Workers(3)), str(Workers(3, "tcp://a:1"))) == ("3", "tcp://a:1")
