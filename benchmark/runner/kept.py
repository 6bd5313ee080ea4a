"""Independent tasks of any kind, whose results outlast whatever ends the command."""

from __future__ import annotations

import base64
import pickle
import traceback
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field
from functools import partial
from itertools import takewhile
from pathlib import Path
from typing import Any, Generic, TypeVar

from benchmark.console import console
from benchmark.runner.identity import code_identity
from benchmark.runner.interrupts import interrupted, undisturbed
from benchmark.runner.journal import Journal, LineFormat
from benchmark.runner.processes import run_here, run_in_processes
from benchmark.runner.single_thread import is_single_threaded, single_threaded_children
from estimation.progress_bar import progress
from models.known_types import unpickled
from pen_mhe.rooms import rooms

TaskT = TypeVar("TaskT", bound=Hashable)
ResultT = TypeVar("ResultT")


def journal_path(name: str, folder: Path) -> Path:
    """Return the file that keeps what a study of that name has found."""
    return folder / f"journal-{name}.jsonl"


@dataclass(frozen=True)
class Jobs(Generic[TaskT]):
    """Who runs the tasks of a study.

    Parameters
    ----------
    processes : more share the tasks; 1 runs them one after the other
    row : what neighbouring tasks have in common for which something is built: they stay with
        the process that built it
    single_threaded : whether times are measured, so that NumPy and solvers must start no
        threads: one process runs the tasks, this one where its environment says so already
    """

    processes: int = 1
    row: Callable[[TaskT], Hashable] = field(default=lambda task: task)
    single_threaded: bool = False


def kept_results(
    name: str,
    function: Callable[[TaskT], ResultT],
    tasks: Sequence[TaskT],
    folder: Path,
    *,
    jobs: Jobs[TaskT],
    identity: Callable[[TaskT], str] = lambda task: code_identity(),
) -> list[ResultT]:
    """Run the tasks that a folder's journal has not; return the results of all, in their order.

    Every result is in the journal as soon as it is there. After a task that fails, what runs is
    finished and kept, and what waits is not begun.

    Parameters
    ----------
    name : of the study: of its journal, and of its progress on a terminal
    function : of a module, so that another process finds it; its result can be pickled
    tasks : no two of them equal; each is known again by its `repr`
    folder : of the journal; made where it is missing
    identity : what a finished task must have been run with to count as finished

    Raises
    ------
    InputError
        If another run has the journal open; or, with what to do, after an interrupt.
    Exception
        What a task raised.
    """
    made_with, path = {task: identity(task) for task in tasks}, journal_path(name, folder)
    with Journal(path, result_lines(function)) as journal, progress(name) as start:
        todo = [task for task in tasks if not journal.has(task, made_with[task])]
        if len(todo) < len(tasks):
            console.print(
                f"{len(tasks) - len(todo)} of {len(tasks)} tasks are finished already; "
                f"without {journal.path} they run again"
            )
        advance, done, broken = start(len(todo)), 0, list[Exception]()
        try:
            for task, attempt in _attempts(function, todo, jobs, lambda: not broken):
                if attempt.error is not None:
                    broken.append(attempt.error)
                    continue
                with undisturbed():
                    journal.append(task, made_with[task], attempt.result)
                    done += 1
                    advance(1)
        except KeyboardInterrupt:
            raise interrupted(done) from None
        if broken:
            raise broken[0]
        return [journal.read(task, made_with[task]) for task in tasks]


@dataclass(frozen=True)
class Attempt:
    """What became of a task: a result, or why there is none."""

    result: Any = None
    error: Exception | None = None


def _attempts(
    function: Callable[[TaskT], Any],
    tasks: Sequence[TaskT],
    jobs: Jobs[TaskT],
    goes_on: Callable[[], bool],
) -> Iterator[tuple[TaskT, Attempt]]:
    attempt = partial(attempted, function)
    if jobs.processes == 1 and (is_single_threaded() or not jobs.single_threaded):
        yield from run_here(attempt, takewhile(lambda _: goes_on(), tasks))
        return
    with single_threaded_children() if jobs.single_threaded else nullcontext():
        yield from run_in_processes(
            attempt,
            tasks,
            jobs.processes,
            row=jobs.row,
            died=lambda reason: Attempt(error=RuntimeError(reason)),
            goes_on=goes_on,
        )


def attempted(function: Callable[[TaskT], Any], task: TaskT) -> Attempt:
    """Run a task in whatever process this is."""
    try:
        return Attempt(function(task))
    except Exception as error:  # whatever it is, it is raised at the end
        error.add_note(f"raised by the task {task!r}:\n{traceback.format_exc()}")
        return Attempt(error=error)


def _encoded(task: object, result: object) -> dict[str, str]:
    return {"task": repr(task), "pickle": base64.b64encode(pickle.dumps(result)).decode("ascii")}


def result_lines(function: Callable[..., object]) -> LineFormat[Any, Any]:
    """Return how results of a function are lines.

    They are pickled: they are read by the code that wrote them, or not at all. What a line names
    must be a class of the house, or of the package that the function is from.
    """
    whole = function.func if isinstance(function, partial) else function
    packages = {*rooms(), whole.__module__.split(".")[0]}

    def decoded(line: Mapping[str, Any]) -> Any:
        return unpickled(base64.b64decode(line["pickle"]), packages)

    return LineFormat(
        key=repr, encoded=_encoded, key_of=lambda line: str(line["task"]), decoded=decoded
    )
