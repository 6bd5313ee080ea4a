"""Tasks on a running Dask cluster, whose workers have this package installed."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import islice
from typing import TYPE_CHECKING

from benchmark.runner.identity import code_identity
from benchmark.tasks.task import Outcome, Task, failed
from models.errors import InputError

if TYPE_CHECKING:
    from distributed import Client, Future

AHEAD = 4
"""Tasks per worker thread that are given out at a time."""

CONNECT_S = 10
LOST = "the cluster gave it up"


def run_on_cluster(
    function: Callable[[Task], Outcome], tasks: Iterable[Task], scheduler: str
) -> Iterator[tuple[Task, Outcome]]:
    """Run tasks on a cluster; yield each with its outcome, as they finish.

    Dask runs the tasks of a dead worker again elsewhere, and gives up those whose workers keep
    dying. They run once more, one at a time by themselves: one that kills its workers again is
    an outcome that says so, the others had only stood beside it.

    Parameters
    ----------
    scheduler : address of the scheduler: ``tcp://127.0.0.1:8786``

    Raises
    ------
    InputError
        If Dask is not installed, no scheduler answers at the address, there is no worker, or
        one has other code than this process.
    """
    try:
        from distributed import Client, as_completed
    except ImportError:
        raise InputError(
            "option --scheduler needs Dask, expected the extra: pip install 'pen-mhe[cluster]'"
        ) from None
    _check_scheduler(scheduler)
    with Client(scheduler, timeout=CONNECT_S) as client:
        waiting = iter(tasks)
        ahead = AHEAD * _checked_threads(client, scheduler)
        given, given_up = {}, []
        finished = as_completed()
        for task in islice(waiting, ahead):
            given[future := client.submit(function, task, key=task.key, pure=False)] = task
            finished.add(future)
        for future in _until_interrupted(finished, given):
            task = given.pop(future)
            if future.exception() is None:
                yield task, future.result()
            else:
                given_up.append(task)
            future.release()
            if (following := next(waiting, None)) is not None:
                future = client.submit(function, following, key=following.key, pure=False)
                given[future] = following
                finished.add(future)
        for task in given_up:
            alone = client.submit(function, task, key=f"{task.key}/alone", pure=False)
            died = alone.exception()
            yield task, alone.result() if died is None else failed(f"{LOST}: {died}")


def _until_interrupted(
    finished: Iterator[Future], given: Mapping[Future, Task]
) -> Iterator[Future]:
    """Yield futures as they finish; at an interrupt those that have, before it is raised."""
    try:
        yield from finished
    except KeyboardInterrupt:
        yield from [future for future in given if future.status == "finished"]
        raise


def _check_scheduler(scheduler: str) -> None:
    """Raise `InputError` unless a scheduler answers in time.

    `Client` by itself waits for ever where something else than Dask listens.
    """
    from distributed import Security
    from distributed.core import connect, send_recv

    async def kind() -> str:
        comm = await connect(scheduler, **Security().get_connection_args("client"))
        try:
            return str((await send_recv(comm, op="identity"))["type"])
        finally:
            comm.abort()

    try:
        found = asyncio.run(asyncio.wait_for(kind(), CONNECT_S))
    except (OSError, ValueError) as error:
        found = str(error) or f"no answer within {CONNECT_S} s"
    if found != "Scheduler":
        raise InputError(
            f"scheduler {scheduler}: {found}, expected the address of a running Dask scheduler"
        )


def _checked_threads(client: Client, scheduler: str) -> int:
    """Return the number of the workers' threads, once they are known to have this code."""
    threads: dict[str, int] = client.nthreads()
    if not threads:
        raise InputError(f"scheduler {scheduler} has no workers, expected at least one")
    try:
        identities = client.run(code_identity)
    except Exception as error:  # what a worker says that cannot find it has no type of its own
        raise InputError(
            f"scheduler {scheduler}: a worker lacks this package ({error}), "
            "expected the same installation"
        ) from None
    for worker, identity in identities.items():
        if identity != code_identity():
            raise InputError(
                f"scheduler {scheduler}: worker {worker} has other code or other libraries "
                "than this process, expected the same installation"
            )
    return sum(threads.values())
