"""Ctrl-C and SIGKILL of every suite half-way: nothing finished is lost.

Quick tests interrupt and kill the benchmark's runner, in `tests.benchmark.runner.test_killed_run`.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from benchmark.runner.outcome_lines import NAME
from benchmark.runner.tables import RESULTS, SERIES
from benchmark.tasks.results import TIMING_COLUMNS
from commands.sentences import ExitCode
from pen_mhe.rooms import ROOT
from suites.table import NAMED, find_suite
from tests.suites import small_runs
from tests.suites.small_runs import SmallRun

DATA = os.environ.get("PEN_MHE_DATA", "")
SMALL = small_runs.small_suites(DATA)
WITHIN_S, ENDS_WITHIN_S = 200.0, 15.0
"""Longest wait for half of a run; and for the end of one that was interrupted."""

TIMES = ("s", "µs", "cores", "full passes")
"""Units of figures that no two runs of what is timed have alike."""
FIGURES = ["rmse", "bias", "max_error"]


def test_every_suite_has_a_small_run() -> None:
    assert set(SMALL) == set(NAMED)


def start(name: str, folder: Path) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", "tests.suites.small_runs", name, str(folder), DATA],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,  # a group of its own, all of which a terminal interrupts
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # also behind "&"
    )


def whole_lines(journal: Path) -> list[bytes]:
    data = journal.read_bytes() if journal.exists() else b""
    return [line for line in data.splitlines(keepends=True) if line.endswith(b"\n")]


def wait_for_some(process: subprocess.Popen[str], small: SmallRun, folder: Path) -> None:
    """Wait until some tasks are finished, but not all."""
    until = time.monotonic() + WITHIN_S
    while len(whole_lines(folder / NAME)) < min(3, small.tasks // 2):
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < until
        time.sleep(0.005)


def without_times(path: Path) -> pd.DataFrame:
    """Return a table with what follows from its tasks alone."""
    table = pd.read_parquet(path).drop(columns=list(TIMING_COLUMNS), errors="ignore")
    if path.name == RESULTS:
        timed = table["suite"].map(lambda name: find_suite(name).is_timed)
        table.loc[timed & table["unit"].isin(TIMES), FIGURES] = 0.0
        table.loc[timed, ["status", "reason"]] = ""  # whether the core was shared
    return table


def check_same(one: Path, other: Path) -> None:
    """The same results, times aside; to nine digits, since OSQP adapts its steps by the clock."""
    tables = [without_times(path) for path in (one, other)]
    is_exact = one.name != RESULTS or not find_suite(tables[0]["suite"].iloc[0]).is_timed
    pd.testing.assert_frame_equal(*tables, check_exact=is_exact, rtol=1e-9, atol=1e-12)


@pytest.fixture(scope="module")
def uninterrupted(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """Name → folder of a run that nothing ends early; each once."""
    found: dict[str, Path] = {}

    def run(name: str) -> Path:
        if name not in found:
            folder = tmp_path_factory.mktemp(name)
            process = start(name, folder)
            _, errors = process.communicate(timeout=WITHIN_S)
            assert process.returncode == 0, errors
            found[name] = folder
        return found[name]

    return run


@pytest.mark.slow
@pytest.mark.parametrize("ending", [signal.SIGINT, signal.SIGKILL], ids=lambda ending: ending.name)
@pytest.mark.parametrize("name", SMALL)
def test_nothing_finished_is_lost(
    name: str, ending: signal.Signals, tmp_path: Path, uninterrupted: Any
) -> None:
    small = SMALL[name]
    if small.reads_data and not DATA:
        pytest.skip("PEN_MHE_DATA is not set: no real recordings here")
    journal = tmp_path / NAME
    process = start(name, tmp_path)
    try:
        wait_for_some(process, small, tmp_path)
        if ending == signal.SIGINT:
            os.killpg(process.pid, ending)
            errors = process.communicate(timeout=ENDS_WITHIN_S)[1]
        else:
            process.kill()
            process.communicate(timeout=ENDS_WITHIN_S)
    finally:
        process.kill()
    kept = whole_lines(journal)
    assert 0 < len(kept) < small.tasks
    if ending == signal.SIGINT:
        assert errors == (
            f"pen-mhe: interrupted after {len(kept)} tasks, which are kept; the same command "
            "continues\n"
        )
        assert process.returncode == ExitCode.INTERRUPTED

    again = start(name, tmp_path)
    printed, errors = again.communicate(timeout=WITHIN_S)
    assert again.returncode == 0, errors
    said = f"{len(kept)} of {small.tasks} tasks are finished already"
    assert sum(line.startswith(said) for line in printed.splitlines()) == 1
    lines = whole_lines(journal)
    assert lines[: len(kept)] == kept
    tasks = Counter(json.dumps(json.loads(line)["task"]) for line in lines)
    assert set(tasks.values()) == {1}  # none ran again
    assert len(tasks) == small.tasks

    folder = uninterrupted(name)
    for written in (RESULTS, SERIES):
        check_same(tmp_path / written, folder / written)
