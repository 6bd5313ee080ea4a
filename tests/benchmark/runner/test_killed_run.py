"""SIGKILL of a whole run half-way: its workers end, and the same command goes on."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pandas as pd
import pytest

from benchmark.runner.outcome_lines import NAME, outcome_journal
from benchmark.runner.tables import RESULTS, read_tables
from benchmark.tasks.results import TIMING_COLUMNS
from pen_mhe.rooms import ROOT
from tests.benchmark.runner.workload import processes_of, tasks, times_run

TASKS = 30
WITHIN_S = 30.0


def start(folder: Path, notes: Path, jobs: int, *scheduler: str) -> subprocess.Popen[str]:
    notes.mkdir(exist_ok=True)
    arguments = [str(folder), str(notes), str(jobs), str(TASKS), *scheduler]
    return subprocess.Popen(
        [sys.executable, "-m", "tests.benchmark.runner.driver", *arguments],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,  # a group of its own, all of which a terminal interrupts
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # also behind "&"
    )


def wait_for_some(run: subprocess.Popen[str], output: Path) -> None:
    """Wait until some tasks are finished."""
    until = time.monotonic() + WITHIN_S
    while not (output / NAME).exists() or (output / NAME).read_bytes().count(b"\n") < 6:
        assert time.monotonic() < until
        assert run.poll() is None
        time.sleep(0.01)


def finished(folder: Path) -> list[int]:
    """Seeds of the tasks that a journal has."""
    with outcome_journal(folder) as journal:
        return [task.seed for task in tasks(TASKS) if journal.has(task, "the same for all")]


def alive(process: int) -> bool:
    """Whether a process runs: one that has ended but nobody has asked for is dead too."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="looks for processes in /proc")
@pytest.mark.parametrize("jobs", [pytest.param(1, marks=pytest.mark.slow), 2])
def test_a_killed_run_goes_on_where_it_was(tmp_path: Path, jobs: int) -> None:
    output, notes = tmp_path / "killed", tmp_path / "notes"
    first = start(output, notes, jobs)
    try:
        wait_for_some(first, output)
    finally:
        first.send_signal(signal.SIGKILL)
        first.communicate()
    assert not (output / RESULTS).exists()

    workers = processes_of(notes) - {first.pid}
    assert len(workers) == (0 if jobs == 1 else 2)
    until = time.monotonic() + 5.0
    while any(map(alive, workers)):
        assert time.monotonic() < until
        time.sleep(0.05)

    kept = finished(output)
    assert 6 <= len(kept) < TASKS
    assert {seed: times_run(notes)[seed] for seed in kept} == dict.fromkeys(kept, 1)

    again = start(output, notes, jobs)
    printed, errors = again.communicate(timeout=WITHIN_S)
    assert (again.returncode, errors) == (0, "")
    assert printed == f"to run: {TASKS - len(kept)}\nfinished\n"
    assert finished(output) == list(range(TASKS))
    # What was in the journal did not run again; what was on its way may have.
    assert {seed: times_run(notes)[seed] for seed in kept} == dict.fromkeys(kept, 1)

    whole = start(tmp_path / "whole", tmp_path / "other notes", jobs)
    assert whole.communicate(timeout=WITHIN_S)[1] == ""
    continued, uninterrupted = read_tables(output), read_tables(tmp_path / "whole")
    assert len(continued.rows) == 2 * TASKS
    pd.testing.assert_frame_equal(
        continued.rows.drop(columns=list(TIMING_COLUMNS)),
        uninterrupted.rows.drop(columns=list(TIMING_COLUMNS)),
        check_exact=True,
    )
    assert len(continued.series) == 5
    pd.testing.assert_frame_equal(continued.series, uninterrupted.series, check_exact=True)


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="looks for processes in /proc")
@pytest.mark.parametrize("jobs", [pytest.param(1, marks=pytest.mark.slow), 2])
def test_an_interrupted_run_ends_at_once_and_goes_on(tmp_path: Path, jobs: int) -> None:
    output, notes = tmp_path / "interrupted", tmp_path / "notes"
    first = start(output, notes, jobs)
    try:
        wait_for_some(first, output)
        os.killpg(first.pid, signal.SIGINT)
        errors = first.communicate(timeout=10.0)[1]
    finally:
        first.kill()
    # Of the run, not of its workers: nobody here turns it into a sentence.
    assert errors.count("Traceback") <= 1 + errors.count("During handling")
    assert errors.endswith("KeyboardInterrupt\n")
    assert not any(map(alive, processes_of(notes) - {first.pid}))
    kept = finished(output)
    assert 6 <= len(kept) < TASKS
    # A task that has left its note is finished, but for one a process.
    assert len(times_run(notes)) <= len(kept) + jobs

    again = start(output, notes, jobs)
    printed, errors = again.communicate(timeout=WITHIN_S)
    assert (again.returncode, errors) == (0, "")
    assert printed == f"to run: {TASKS - len(kept)}\nfinished\n"
    assert {seed: times_run(notes)[seed] for seed in kept} == dict.fromkeys(kept, 1)


def test_no_worker_is_left_of_this_test() -> None:
    """The check above can fail: a process that runs is alive, one that was killed is not."""
    process = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"])
    try:
        assert alive(process.pid)
        os.kill(process.pid, signal.SIGKILL)
        until = time.monotonic() + 5.0
        while alive(process.pid):
            assert time.monotonic() < until
    finally:
        process.kill()
        process.wait()
