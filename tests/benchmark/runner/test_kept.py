"""Results of any tasks are kept: what is finished is not run again, whatever ended the command."""

from __future__ import annotations

import json
import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from filelock import FileLock

from benchmark.runner.kept import Jobs, journal_path, kept_results
from benchmark.runner.processes import AHEAD
from models.errors import InputError, Interrupted

NAME = "squares"


@dataclass(frozen=True)
class SquareTask:
    number: int
    notes: Path

    def note(self) -> None:
        (self.notes / f"{self.number}-{os.getpid()}-{time.monotonic_ns()}").touch()


@dataclass(frozen=True, eq=False)
class Square:
    number: int
    values: np.ndarray


def square(task: SquareTask) -> Square:
    task.note()
    return Square(task.number, np.full(2, task.number**2.0))


def square_but(broken: int, task: SquareTask) -> Square:
    """At one number break off, at later ones take their time once it has.

    A process takes its time to begin: until then the other one would have done everything.
    """
    mark = task.notes.parent / "broken"
    if task.number == broken:
        mark.touch()
        raise LookupError(f"nothing at {broken}")
    until = time.monotonic() + 30.0
    while task.number > broken and not mark.exists() and time.monotonic() < until:
        time.sleep(0.01)
    time.sleep(0.2)
    return square(task)


def note_and_sleep(task: SquareTask) -> Square:
    found = square(task)
    time.sleep(100.0)
    return found


def square_or_die(task: SquareTask) -> Square:
    if task.number == 1:
        os.kill(os.getpid(), signal.SIGKILL)
    return square(task)


def interrupt_at(number: int, task: SquareTask) -> Square:
    if task.number == number:
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(1.0)
    return square(task)


def interrupt_that_is_swallowed(number: int, task: SquareTask) -> Square:
    """As a solver does it that returns as if it had failed."""
    try:
        return interrupt_at(number, task)
    except KeyboardInterrupt:
        return Square(-1, np.zeros(0))


def interrupt_that_becomes_an_error(number: int, task: SquareTask) -> Square:
    try:
        return interrupt_at(number, task)
    except KeyboardInterrupt:
        raise RuntimeError("the solver broke off") from None


@pytest.fixture(autouse=True)
def heard() -> Iterator[None]:
    """Interrupts come, also where pytest itself runs behind "&" in a script."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture
def run(tmp_path: Path) -> Callable[..., list[Any]]:
    """Run squares of a few numbers."""
    (tmp_path / "notes").mkdir()

    def ran(function: Any, numbers: Any, jobs: int = 1, identity: str = "code") -> list[Any]:
        tasks = [SquareTask(number, tmp_path / "notes") for number in numbers]
        return kept_results(
            NAME, function, tasks, tmp_path, jobs=Jobs(jobs), identity=lambda _: identity
        )

    return ran


def ran_numbers(folder: Path) -> list[int]:
    return sorted(int(path.name.split("-")[0]) for path in (folder / "notes").iterdir())


def kept_numbers(folder: Path) -> list[int]:
    lines = journal_path(NAME, folder).read_text().splitlines()
    return sorted(int(json.loads(line)["task"].split("number=")[1].split(",")[0]) for line in lines)


@pytest.mark.parametrize("jobs", [1, 2])
def test_results_are_in_order_and_no_task_runs_twice(
    run: Any, tmp_path: Path, jobs: int, capsys: pytest.CaptureFixture[str]
) -> None:
    run(square, [2, 0], jobs)
    assert capsys.readouterr().out == ""
    found = run(square, range(6), jobs)
    assert [result.number for result in found] == list(range(6))
    assert [result.values.tolist() for result in found] == [[n**2] * 2 for n in range(6)]
    assert ran_numbers(tmp_path) == kept_numbers(tmp_path) == list(range(6))
    assert capsys.readouterr().out == (
        f"2 of 6 tasks are finished already; without {journal_path(NAME, tmp_path)} they run "
        "again\n"
    )
    assert run(square, [3], jobs)[0].values.tolist() == [9.0, 9.0]
    run(square, [3], jobs, "other code")
    assert ran_numbers(tmp_path) == [0, 1, 2, 3, 3, 4, 5]


def test_after_a_failure_what_runs_is_kept_and_nothing_begun(run: Any, tmp_path: Path) -> None:
    with pytest.raises(LookupError, match="nothing at 1") as raised:
        run(partial(square_but, 1), range(12), 2)
    assert "SquareTask(number=1" in raised.value.__notes__[0]
    assert "square_but" in raised.value.__notes__[0]
    kept = kept_numbers(tmp_path)
    assert 0 in kept
    assert ran_numbers(tmp_path) == kept
    # What a process had been given: it may be on its way when the failure is told.
    assert len(kept) <= 2 * AHEAD
    assert [result.number for result in run(square, range(12), 2)] == list(range(12))


def test_after_a_failure_here_nothing_is_begun(run: Any, tmp_path: Path) -> None:
    with pytest.raises(LookupError, match="nothing at 2"):
        run(partial(square_but, 2), range(5))
    assert kept_numbers(tmp_path) == [0, 1]


def test_a_task_that_kills_its_processes_is_an_error(run: Any, tmp_path: Path) -> None:
    with pytest.raises(RuntimeError, match="its process died 2 times"):
        run(square_or_die, range(3), 2)
    assert 1 not in kept_numbers(tmp_path)


@pytest.mark.parametrize(
    "function", [interrupt_at, interrupt_that_is_swallowed, interrupt_that_becomes_an_error]
)
def test_an_interrupt_here_keeps_what_is_finished(run: Any, tmp_path: Path, function: Any) -> None:
    began = time.monotonic()
    with pytest.raises(Interrupted) as raised:
        run(partial(function, 2), range(5))
    assert str(raised.value) == (
        "interrupted after 2 tasks, which are kept; the same command continues"
    )
    assert time.monotonic() - began < 0.9
    assert kept_numbers(tmp_path) == [0, 1]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    run(square, range(5))
    assert ran_numbers(tmp_path) == kept_numbers(tmp_path) == list(range(5))


def test_an_interrupt_waits_for_the_line_that_is_written(
    run: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    dumps = json.dumps

    def interrupted(*arguments: Any, **options: Any) -> str:
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(0.01)
        return dumps(*arguments, **options)

    monkeypatch.setattr(json, "dumps", interrupted)
    with pytest.raises(Interrupted, match="interrupted after 1 tasks"):
        run(square, range(3))
    assert kept_numbers(tmp_path) == [0]


def test_an_interrupt_ends_what_still_runs(run: Any, tmp_path: Path) -> None:
    """Instead of waiting for it, now or when this process ends."""

    def interrupt_soon() -> None:
        until = time.monotonic() + 30.0
        while len(ran_numbers(tmp_path)) < 2 and time.monotonic() < until:
            time.sleep(0.01)
        os.kill(os.getpid(), signal.SIGINT)

    waiting = threading.Thread(target=interrupt_soon)
    waiting.start()
    with pytest.raises(Interrupted, match="interrupted after 0 tasks"):
        run(note_and_sleep, range(6), 2)
    waiting.join()
    until = time.monotonic() + 10.0
    while multiprocessing.active_children():
        assert time.monotonic() < until
        time.sleep(0.01)
    assert len(ran_numbers(tmp_path)) == 2


def test_what_is_ignored_stays_ignored(run: Any, tmp_path: Path) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    found = run(partial(interrupt_at, 1), range(3))
    assert [result.number for result in found] == [0, 1, 2]
    assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN


def test_a_journal_in_use_is_refused(run: Any, tmp_path: Path) -> None:
    path = journal_path(NAME, tmp_path)
    with FileLock(f"{path}.lock"), pytest.raises(InputError, match="is being written by another"):
        run(square, range(3))
    assert not path.exists()
