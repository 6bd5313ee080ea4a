"""Independent tasks in processes, with progress."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from typing import TypeVar

from benchmark.console import progress

TaskT = TypeVar("TaskT")
ResultT = TypeVar("ResultT")


def finished(
    description: str, function: Callable[[TaskT], ResultT], tasks: Sequence[TaskT], jobs: int
) -> Iterator[tuple[TaskT, Future[ResultT]]]:
    """Yield each task with its finished future, in the order in which they finish.

    After a task that fails, what runs goes on and is yielded; what waits is not begun.

    Parameters
    ----------
    function : of a module, so that another process finds it
    """
    with (
        progress(description) as start,
        ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool,
    ):
        advance = start(len(tasks))
        futures = {pool.submit(function, task): task for task in tasks}
        for future in as_completed(futures):
            advance(1)
            if future.cancelled():
                continue
            if future.exception() is not None:
                pool.shutdown(wait=False, cancel_futures=True)
            yield futures[future], future
