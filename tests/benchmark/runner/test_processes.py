"""Processes of this machine: every task once, whatever becomes of a process."""

from __future__ import annotations

import os
import signal
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from typing import Any

import pytest

from benchmark.runner import processes
from benchmark.runner.processes import AHEAD, DIED, run_here, run_in_processes
from benchmark.tasks.suite import Scope
from benchmark.tasks.task import FAILED, OK, Outcome, Task, failed
from tests.benchmark.runner.workload import DEADLY, deadly, pids, process_id, tasks

LANES: dict[str, Any] = {"row": lambda task: task.case, "died": failed}
identify = partial(process_id, scope=Scope())


def test_here_is_one_after_the_other() -> None:
    ran = []

    def note(task: Task) -> Outcome:
        ran.append(task)
        return Outcome("", (), 1, 1.0, 0.0, 0.0)

    found = run_here(note, tasks(4))
    assert ran == []
    for n, (task, _) in enumerate(found):
        assert ran == tasks(4)[: n + 1]
        assert task == ran[-1]


def test_two_processes_share_the_tasks_and_few_are_given_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    given = 0

    class Counted(ProcessPoolExecutor):
        def submit(self, *args: Any, **kwargs: Any) -> Any:
            nonlocal given
            given += 1
            return super().submit(*args, **kwargs)

    monkeypatch.setattr(processes, "ProcessPoolExecutor", Counted)
    found, most = [], 0
    for task, outcome in run_in_processes(identify, tasks(40), 2, **LANES):
        most = max(most, given - len(found))
        found.append((task, outcome))
    assert sorted(task for task, _ in found) == sorted(tasks(40))
    ran_by = pids([outcome for _, outcome in found])
    assert len(ran_by) == 2
    assert os.getpid() not in ran_by
    assert given == 40
    assert most == 2 * AHEAD


def test_a_row_stays_with_its_process_until_another_helps() -> None:
    """Which builds its estimator once."""
    by_row = sorted(tasks(20))  # two cases of ten seeds each
    found = dict(run_in_processes(identify, by_row, 2, **LANES))
    first, second = (pids([found[t] for t in by_row[i : i + AHEAD]]) for i in (0, 10))
    assert len(first) == len(second) == 1
    assert first != second


def test_a_killed_process_loses_nothing() -> None:
    found: list[tuple[Task, Outcome]] = []
    for pair in run_in_processes(identify, tasks(30), 2, **LANES):
        found.append(pair)
        if len(found) == 5:
            os.kill(min(pids([pair[1]])), signal.SIGKILL)
    assert sorted(task for task, _ in found) == sorted(tasks(30))
    assert {outcome.status for _, outcome in found} == {OK}
    assert len(pids([outcome for _, outcome in found])) > 2


def test_the_task_that_kills_its_process_is_the_one_that_fails() -> None:
    found = list(run_in_processes(partial(deadly, scope=Scope()), tasks(12), 2, **LANES))
    assert sorted(task for task, _ in found) == sorted(tasks(12))
    broken = {task.seed: outcome for task, outcome in found if outcome.status != OK}
    assert set(broken) == {DEADLY}
    assert (broken[DEADLY].status, broken[DEADLY].reason) == (FAILED, DIED)


def test_processes_have_one_thread_each_unless_told_otherwise(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """What BLAS reads when a process begins."""
    monkeypatch.delenv("OMP_NUM_THREADS", raising=False)
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "3")
    found = dict(run_in_processes(_threads, tasks(1), 2, **LANES))
    assert found[tasks(1)[0]].reason == "1 3"


def _threads(task: Task) -> Outcome:
    told = f"{os.environ['OMP_NUM_THREADS']} {os.environ['OPENBLAS_NUM_THREADS']}"
    return Outcome("", (), 1, 1.0, 0.0, 0.0, OK, told)
