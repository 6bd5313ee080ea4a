"""Tasks on a running Dask cluster, whose workers have this package installed."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from itertools import islice
from typing import TYPE_CHECKING

from benchmark.runner.identity import code_identity
from benchmark.tasks.task import Outcome, Task, failed
from models.errors import InputError

if TYPE_CHECKING:
    from distributed import Client

AHEAD = 4
"""Tasks per worker thread that are given out at a time."""

CONNECT_S = 10
LOST = "the cluster gave it up"


def run_on_cluster(
    function: Callable[[Task], Outcome], tasks: Iterable[Task], scheduler: str
) -> Iterator[tuple[Task, Outcome]]:
    """Run tasks on a cluster; yield each with its outcome, as they finish.

    Dask runs the tasks of a dead worker again elsewhere; one whose workers keep dying is an
    outcome that says so.

    Parameters
    ----------
    scheduler : address of the scheduler: ``tcp://127.0.0.1:8786``

    Raises
    ------
    InputError
        If Dask is not installed, nothing answers at the address, there is no worker, or one
        has other code than this process.
    """
    try:
        from distributed import Client, as_completed
    except ImportError:
        raise InputError(
            "option --scheduler needs Dask, expected the extra: pip install 'pen-mhe[cluster]'"
        ) from None
    try:
        client = Client(scheduler, timeout=CONNECT_S)
    except (OSError, ValueError) as error:
        raise InputError(
            f"scheduler {scheduler}: {error}, expected the address of a running Dask scheduler"
        ) from None
    with client:
        waiting = iter(tasks)
        ahead = AHEAD * _checked_threads(client, scheduler)
        given = {}
        finished = as_completed()
        for task in islice(waiting, ahead):
            given[future := client.submit(function, task, key=task.key, pure=False)] = task
            finished.add(future)
        for future in finished:
            task = given.pop(future)
            died = future.exception()
            yield task, future.result() if died is None else failed(f"{LOST}: {died}")
            future.release()
            if (following := next(waiting, None)) is not None:
                future = client.submit(function, following, key=following.key, pure=False)
                given[future] = following
                finished.add(future)


def _checked_threads(client: Client, scheduler: str) -> int:
    """Return the number of the workers' threads, once they are known to have this code."""
    threads: dict[str, int] = client.nthreads()
    if not threads:
        raise InputError(f"scheduler {scheduler} has no workers, expected at least one")
    for worker, identity in client.run(code_identity).items():
        if identity != code_identity():
            raise InputError(
                f"scheduler {scheduler}: worker {worker} has other code or other libraries "
                "than this process, expected the same installation"
            )
    return sum(threads.values())
