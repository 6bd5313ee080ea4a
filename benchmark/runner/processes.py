"""Tasks in processes of this machine, a few ahead, whatever becomes of a process."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context

from benchmark.tasks.task import Outcome, Task, failed

AHEAD = 4
"""Tasks per process that are given out at a time: enough that none waits, few in memory."""

ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")

DIED = "its process died, and died again where the task ran by itself"

Function = Callable[[Task], Outcome]


def run_here(function: Function, tasks: Iterable[Task]) -> Iterator[tuple[Task, Outcome]]:
    """Run tasks in this process, one after the other."""
    for task in tasks:
        yield task, function(task)


def run_in_processes(
    function: Function, tasks: Iterable[Task], jobs: int
) -> Iterator[tuple[Task, Outcome]]:
    """Run tasks in processes; yield each with its outcome, as they finish.

    Where a process dies, the tasks that were given out run again, one at a time by
    themselves: the one that kills its process again is an outcome that says so, the others
    lose nothing.

    Parameters
    ----------
    function : of a module, so that another process finds it
    jobs : number of processes
    """
    waiting = iter(tasks)
    suspects: list[Task] = []
    more = True
    while more:
        more = False
        with _pool(jobs) as pool:
            for task, future in _in_flight(pool, function, waiting, jobs * AHEAD):
                if _died(future):
                    suspects.append(task)
                    more = True
                else:
                    yield task, future.result()
        yield from _one_by_one(function, suspects)
        suspects.clear()


def _in_flight(
    pool: ProcessPoolExecutor, function: Function, waiting: Iterator[Task], ahead: int
) -> Iterator[tuple[Task, Future[Outcome]]]:
    """Yield tasks as they finish; after a death only those that were given out."""
    given: dict[Future[Outcome], Task] = {}
    alive = True
    try:
        while True:
            while alive and len(given) < ahead and (task := next(waiting, None)) is not None:
                try:
                    given[pool.submit(function, task)] = task
                except BrokenProcessPool as error:
                    broken: Future[Outcome] = Future()
                    broken.set_exception(error)
                    given[broken] = task
                    alive = False
            if not given:
                return
            done, _ = wait(given, return_when=FIRST_COMPLETED)
            for future in done:
                alive = alive and not _died(future)
                yield given.pop(future), future
    finally:
        pool.shutdown(wait=False, cancel_futures=True)


def _one_by_one(function: Function, tasks: Sequence[Task]) -> Iterator[tuple[Task, Outcome]]:
    """Run each task as the only one of a process, which serves until a task kills it."""
    left = deque(tasks)
    while left:
        with _pool(1) as pool:
            alive = True
            while left and alive:
                task = left.popleft()
                future = pool.submit(function, task)
                alive = not _died(future)
                yield task, future.result() if alive else failed(DIED)


def _died(future: Future[Outcome]) -> bool:
    """Return whether the process of a task died; waits for the task."""
    return isinstance(future.exception(), BrokenProcessPool)


def _pool(jobs: int) -> ProcessPoolExecutor:
    for name in ONE_THREAD:  # read by BLAS when a process begins
        os.environ.setdefault(name, "1")
    return ProcessPoolExecutor(jobs, mp_context=get_context("spawn"), initializer=_begin)


def _begin() -> None:
    """Leave an interrupt to the parent, and end with it, however it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    assert parent is not None

    def end_with_parent() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=end_with_parent, daemon=True).start()
