"""Tasks in processes of this machine, whatever becomes of a process.

Each process has a lane of its own. A lane takes a row at a time (the seeds of one case,
configuration and estimator, which stand together in the list), so that a model is compiled
and an estimator built by the one process that needs it; at the end it helps the others.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from itertools import groupby
from multiprocessing import get_context

from benchmark.tasks.task import Outcome, Task, failed

AHEAD = 3
"""Tasks that a process is given at a time: enough that it never waits, few in memory."""

ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")

MOST_DEATHS = 2
DIED = f"its process died {MOST_DEATHS} times while it ran"

Function = Callable[[Task], Outcome]


def run_here(function: Function, tasks: Iterable[Task]) -> Iterator[tuple[Task, Outcome]]:
    """Run tasks in this process, one after the other."""
    for task in tasks:
        yield task, function(task)


def run_in_processes(
    function: Function, tasks: Iterable[Task], jobs: int
) -> Iterator[tuple[Task, Outcome]]:
    """Run tasks in processes; yield each with its outcome, as they finish.

    Where a process dies, what it was given runs again in another one. The task that ran when
    its process died, and again when the next one did, is an outcome that says so.

    Parameters
    ----------
    function : of a module, so that another process finds it
    jobs : number of processes
    """
    for name in ONE_THREAD:  # read by BLAS when a process begins
        os.environ.setdefault(name, "1")
    rows = (list(row) for _, row in groupby(tasks, key=_row))
    deaths: Counter[Task] = Counter()
    lanes = [_Lane(function) for _ in range(jobs)]
    try:
        while True:
            for lane in lanes:
                lane.fill(rows, lanes)
            running = {future: lane for lane in lanes for future in lane.given}
            if not running:
                return
            done, _ = wait(running, return_when=FIRST_COMPLETED)
            for lane in {running[future] for future in done}:
                yield from lane.finished()
                if (task := lane.killed_by()) is not None:
                    deaths[task] += 1
                    if deaths[task] == MOST_DEATHS:
                        yield task, failed(DIED)
                        lane.restart(without=task)
                    else:
                        lane.restart()
    finally:
        for lane in lanes:
            lane.close()


def _row(task: Task) -> tuple[str, ...]:
    return task.suite, task.case, task.sensors, task.estimator


class _Lane:
    """One process, what it was given, and what of its row it was not given yet."""

    def __init__(self, function: Function) -> None:
        self._function = function
        self._pool = _process()
        self._waiting: deque[Task] = deque()
        self.given: dict[Future[Outcome], Task] = {}

    def fill(self, rows: Iterator[list[Task]], lanes: Sequence[_Lane]) -> None:
        """Give the process tasks: of its row, of a new one, or of the longest of other lanes."""
        while len(self.given) < AHEAD:
            if not self._waiting:
                self._waiting.extend(next(rows, ()))
            longest = max(lanes, key=lambda lane: len(lane._waiting))
            if self._waiting:
                task = self._waiting.popleft()
            elif longest._waiting:
                task = longest._waiting.pop()
            else:
                return
            try:
                self.given[self._pool.submit(self._function, task)] = task
            except BrokenProcessPool as error:
                # Died just now: to be found by `killed_by`, like those given before.
                broken: Future[Outcome] = Future()
                broken.set_exception(error)
                self.given[broken] = task
                return

    def finished(self) -> Iterator[tuple[Task, Outcome]]:
        """Take out the tasks that are done; those whose process died stay."""
        for future in [future for future in self.given if future.done() and not _died(future)]:
            yield self.given.pop(future), future.result()

    def killed_by(self) -> Task | None:
        """Return the task that ran when the process died: the oldest; None where it lives."""
        if not any(future.done() and _died(future) for future in self.given):
            return None
        return next(iter(self.given.values()))

    def restart(self, without: Task | None = None) -> None:
        """Begin a new process with what the dead one was given, but for one task."""
        self.close()
        again = [task for task in self.given.values() if task != without]
        self._waiting.extendleft(reversed(again))
        self.given.clear()
        self._pool = _process()

    def close(self) -> None:
        """Give the process nothing more."""
        self._pool.shutdown(wait=False, cancel_futures=True)


def _died(future: Future[Outcome]) -> bool:
    return isinstance(future.exception(), BrokenProcessPool)


def _process() -> ProcessPoolExecutor:
    return ProcessPoolExecutor(1, mp_context=get_context("spawn"), initializer=_begin)


def _begin() -> None:
    """Leave an interrupt to the parent, and end with it, however it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    assert parent is not None

    def end_with_parent() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=end_with_parent, daemon=True).start()
