"""Tasks in processes of this machine, whatever becomes of a process.

Each process has a lane of its own. A lane takes a row at a time (tasks that need the same model,
or the same recordings, wherever they stand in the list), so that these are compiled, built and
simulated by the one process that needs them; at the end it helps the others.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections import Counter, deque
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from typing import Generic, TypeVar

from benchmark.runner.interrupts import deaf_children, not_swallowed

TaskT = TypeVar("TaskT", bound=Hashable)
ResultT = TypeVar("ResultT")

AHEAD = 3
"""Tasks that a process is given at a time: enough that it never waits, few in memory."""

ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")

MOST_DEATHS = 2
DIED = f"its process died {MOST_DEATHS} times while it ran"


def run_here(
    function: Callable[[TaskT], ResultT], tasks: Iterable[TaskT]
) -> Iterator[tuple[TaskT, ResultT]]:
    """Run tasks in this process, one after the other."""
    for task in tasks:
        with not_swallowed():
            result = function(task)
        yield task, result


def run_in_processes(
    function: Callable[[TaskT], ResultT],
    tasks: Iterable[TaskT],
    jobs: int,
    *,
    row: Callable[[TaskT], Hashable],
    died: Callable[[str], ResultT],
) -> Iterator[tuple[TaskT, ResultT]]:
    """Run tasks in processes; yield each with its result, as they finish.

    Where a process dies, what it was given runs again in another one. Of the task that ran when
    its process died, and again when the next one did, the result says so. At an interrupt what
    has finished is yielded before it is raised, and what runs is killed.

    Parameters
    ----------
    function : of a module, so that another process finds it
    jobs : number of processes
    row : what the tasks of one row have in common; rows begin in the order of their first tasks
    died : a sentence → the result of a task whose processes died
    """
    for name in ONE_THREAD:  # read by BLAS when a process begins
        os.environ.setdefault(name, "1")
    by_row: dict[Hashable, list[TaskT]] = {}
    for task in tasks:
        by_row.setdefault(row(task), []).append(task)
    rows = iter(by_row.values())
    lanes = [_Lane(function) for _ in range(jobs)]
    try:
        yield from _finished(lanes, rows, died)
    except BaseException:  # an interrupt, an error, or nobody who wants more
        for lane in lanes:
            lane.kill()
        raise
    finally:
        for lane in lanes:
            lane.close()


def _finished(
    lanes: Sequence[_Lane[TaskT, ResultT]],
    rows: Iterator[list[TaskT]],
    died: Callable[[str], ResultT],
) -> Iterator[tuple[TaskT, ResultT]]:
    """Give the lanes what there is to do; yield what they have done."""
    deaths: Counter[TaskT] = Counter()
    while True:
        for lane in lanes:
            lane.fill(rows, lanes)
        running = {future: lane for lane in lanes for future in lane.given}
        if not running:
            return
        try:
            done, _ = wait(running, return_when=FIRST_COMPLETED)
        except KeyboardInterrupt:
            for lane in lanes:
                yield from lane.finished()
            raise
        for lane in {running[future] for future in done}:
            yield from lane.finished()
            if (task := lane.killed_by()) is not None:
                deaths[task] += 1
                if deaths[task] == MOST_DEATHS:
                    yield task, died(DIED)
                    lane.restart(without=task)
                else:
                    lane.restart()


class _Lane(Generic[TaskT, ResultT]):
    """One process, what it was given, and what of its row it was not given yet."""

    def __init__(self, function: Callable[[TaskT], ResultT]) -> None:
        self._function = function
        self._pool = _process()
        self._waiting: deque[TaskT] = deque()
        self.given: dict[Future[ResultT], TaskT] = {}

    def fill(self, rows: Iterator[list[TaskT]], lanes: Sequence[_Lane[TaskT, ResultT]]) -> None:
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
                with deaf_children():
                    future = self._pool.submit(self._function, task)
                self.given[future] = task
            except BrokenProcessPool as error:
                # Died just now: to be found by `killed_by`, like those given before.
                broken: Future[ResultT] = Future()
                broken.set_exception(error)
                self.given[broken] = task
                return

    def finished(self) -> Iterator[tuple[TaskT, ResultT]]:
        """Take out the tasks that are done; those whose process died stay."""
        for future in [future for future in self.given if future.done() and not _died(future)]:
            yield self.given.pop(future), future.result()

    def killed_by(self) -> TaskT | None:
        """Return the task that ran when the process died: the oldest; None where it lives."""
        if not any(future.done() and _died(future) for future in self.given):
            return None
        return next(iter(self.given.values()))

    def restart(self, without: TaskT | None = None) -> None:
        """Begin a new process with what the dead one was given, but for one task."""
        self.close()
        again = [task for task in self.given.values() if task != without]
        self._waiting.extendleft(reversed(again))
        self.given.clear()
        self._pool = _process()

    def kill(self) -> None:
        """End the process, whatever it is doing."""
        # A pool has no public way before Python 3.14.
        for process in list((self._pool._processes or {}).values()):
            process.kill()

    def close(self) -> None:
        """Give the process nothing more."""
        self._pool.shutdown(wait=False, cancel_futures=True)


def _died(future: Future[ResultT]) -> bool:
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
