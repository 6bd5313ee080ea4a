"""A Dask cluster of separate processes: the same rows, nothing lost, one sentence."""

from __future__ import annotations

import signal
import socket
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import pandas as pd
import pytest

import benchmark.runner.cluster as runner_cluster
from benchmark.runner import identity
from benchmark.runner.cluster import AHEAD, LOST, run_on_cluster
from benchmark.runner.run import Workers, run_tasks
from benchmark.runner.tables import read_tables
from benchmark.tasks.results import TIMING_COLUMNS, Results
from benchmark.tasks.suite import Scope
from benchmark.tasks.task import FAILED, OK, Outcome, Task
from models.errors import InputError
from suites.execute import execute
from tests.benchmark.runner.dask_cluster import Cluster, cluster
from tests.benchmark.runner.test_killed_run import (
    TASKS,
    WITHIN_S,
    finished,
    start,
    wait_for_some,
)
from tests.benchmark.runner.workload import (
    DEADLY,
    deadly,
    no_identity,
    pids,
    process_id,
    tasks,
    times_run,
)

pytest.importorskip("distributed", reason="the extra [cluster] is not installed")
identify = partial(process_id, scope=Scope())

REAL = [
    *(
        Task("pen", "start 10 deg", "accel+gyro", estimator, seed)
        for estimator in ("ekf", "mhe-rti")
        for seed in (0, 1)
    ),
    Task("pen", "compound: horizontal-turn-vertical", "accel+gyro", "ekf", 0),
    Task("pen", "principle: dot", "no such sensors", "ekf", 0),
]
"""Among them one with series and one that breaks off."""


@pytest.fixture(scope="module")
def running(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    with cluster(tmp_path_factory.mktemp("cluster")) as started:
        yield started


def tables_of(workers: Workers, folder: Path) -> Results:
    """The tables of `REAL`, run as the command does."""
    ran = run_tasks(
        REAL, Scope(seeds=2), workers, folder, lambda _: lambda _: None, execute, no_identity
    )
    assert ran == len(REAL)
    return read_tables(folder)


def test_serial_processes_and_cluster_give_the_same_rows(tmp_path: Path, running: Cluster) -> None:
    serial = tables_of(Workers(1), tmp_path / "serial")
    assert (serial.rows["status"] == FAILED).sum() == 1
    assert serial.rows.loc[serial.rows["status"] == FAILED, "reason"].item() == (
        "KeyError: 'no such sensors'"
    )
    assert serial.rows["case"].nunique() == 3
    assert len(serial.series) > 4 * 1000
    for name, workers in (("jobs", Workers(2)), ("cluster", Workers(2, running.address))):
        other = tables_of(workers, tmp_path / name)
        pd.testing.assert_frame_equal(
            other.rows.drop(columns=list(TIMING_COLUMNS)),
            serial.rows.drop(columns=list(TIMING_COLUMNS)),
            check_exact=True,
        )
        pd.testing.assert_frame_equal(other.series, serial.series, check_exact=True)
        assert (other.rows["step_time_p99_s"].dropna() > 0).all()


def test_both_workers_work_and_few_tasks_are_given_out(running: Cluster) -> None:
    taken: list[Task] = []

    def taking() -> Iterator[Task]:
        for task in tasks(30):
            taken.append(task)
            yield task

    found: dict[Task, Outcome] = {}
    most = 0
    for task, outcome in run_on_cluster(identify, taking(), running.address):
        most = max(most, len(taken) - len(found))
        found[task] = outcome
    assert sorted(found) == sorted(tasks(30))
    assert pids(list(found.values())) == {worker.pid for worker in running.workers}
    assert most == 2 * AHEAD


def test_a_killed_worker_loses_nothing(tmp_path: Path) -> None:
    with cluster(tmp_path) as started:
        found: list[tuple[Task, Outcome]] = []
        for pair in run_on_cluster(identify, tasks(30), started.address):
            found.append(pair)
            if len(found) == 5:
                started.workers[0].kill()
    assert sorted(task for task, _ in found) == sorted(tasks(30))
    assert {outcome.status for _, outcome in found} == {OK}
    # The last ones can only have run on the worker that is left.
    assert pids([outcome for _, outcome in found[-10:]]) == {started.workers[1].pid}


def test_an_interrupted_run_ends_and_goes_on(tmp_path: Path, running: Cluster) -> None:
    output, notes = tmp_path / "interrupted", tmp_path / "notes"
    first = start(output, notes, 2, running.address)
    try:
        wait_for_some(first, output)
        first.send_signal(signal.SIGINT)
        errors = first.communicate(timeout=20.0)[1]
    finally:
        first.kill()
    assert errors.endswith("KeyboardInterrupt\n")
    kept = finished(output)
    assert 6 <= len(kept) < TASKS
    again = start(output, notes, 2, running.address)
    printed, errors = again.communicate(timeout=WITHIN_S)
    assert again.returncode == 0, errors
    assert printed == f"to run: {TASKS - len(kept)}\nfinished\n"
    assert finished(output) == list(range(TASKS))
    assert {seed: times_run(notes)[seed] for seed in kept} == dict.fromkeys(kept, 1)


@pytest.mark.slow
@pytest.mark.parametrize("place", [0, 3])
def test_the_task_that_kills_its_workers_is_the_one_that_fails(tmp_path: Path, place: int) -> None:
    """Also the first of all, with which Dask gives up a neighbour."""
    some = tasks(30)
    some.insert(place, some.pop(DEADLY))
    with cluster(tmp_path, nannies=True) as started:
        found = list(run_on_cluster(partial(deadly, scope=Scope()), some, started.address))
    assert sorted(task for task, _ in found) == sorted(some)
    broken = {task.seed: outcome for task, outcome in found if outcome.status != OK}
    assert set(broken) == {DEADLY}
    assert broken[DEADLY].status == FAILED
    assert broken[DEADLY].reason.startswith(LOST)


def refused(address: str) -> str:
    with pytest.raises(InputError) as found:
        list(run_on_cluster(identify, tasks(1), address))
    sentence = str(found.value)
    assert sentence.startswith(f"scheduler {address}")
    assert "\n" not in sentence
    return sentence.removeprefix(f"scheduler {address}")


def test_no_scheduler_there(monkeypatch: pytest.MonkeyPatch, running: Cluster) -> None:
    expected = ", expected the address of a running Dask scheduler"
    assert refused("nonsense") == f": missing port number in address 'nonsense'{expected}"
    assert refused("tcp://127.0.0.1:abc").endswith(expected)
    assert refused("smoke://127.0.0.1:1").endswith(expected)
    from distributed import Client

    with Client(running.address) as client:
        worker = next(iter(client.nthreads()))
    assert refused(worker) == f": Worker{expected}"
    monkeypatch.setattr(runner_cluster, "CONNECT_S", 1)
    no_answer = f": no answer within 1 s{expected}"
    with socket.create_server(("127.0.0.1", 0)) as silent:
        address = f"tcp://127.0.0.1:{silent.getsockname()[1]}"
        assert refused(address) == no_answer
    assert refused(address) == no_answer  # nobody listens there any more


def test_a_scheduler_without_workers(tmp_path: Path) -> None:
    with cluster(tmp_path, workers=0) as started:
        assert refused(started.address) == " has no workers, expected at least one"


def test_workers_with_other_code(monkeypatch: pytest.MonkeyPatch, running: Cluster) -> None:
    identity.code_identity.cache_clear()
    monkeypatch.setattr(identity, "NUMERICAL", ())
    try:
        sentence = refused(running.address)
    finally:
        identity.code_identity.cache_clear()
    assert "has other code or other libraries than this process, expected the same" in sentence


def test_workers_without_this_package(tmp_path: Path) -> None:
    shadow = tmp_path / "benchmark"
    shadow.mkdir()
    (shadow / "__init__.py").touch()
    with cluster(tmp_path, path=tmp_path) as started:
        sentence = refused(started.address)
    assert sentence.startswith(": a worker lacks this package (")
    assert "No module named 'benchmark.runner'" in sentence
    assert sentence.endswith("expected the same installation")


def test_without_dask_the_sentence_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "distributed", None)
    with pytest.raises(InputError, match=r"expected the extra: pip install 'pen-mhe\[cluster\]'"):
        list(run_on_cluster(identify, tasks(1), "tcp://127.0.0.1:1"))
