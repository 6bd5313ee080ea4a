"""A Dask cluster of separate processes, started as the README says and ended whatever happens."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from pen_mhe.rooms import ROOT

STARTS_WITHIN_S = 60


@dataclass(frozen=True)
class Cluster:
    """Address of its scheduler, and the processes of its workers (or their nannies)."""

    address: str
    workers: tuple[subprocess.Popen[bytes], ...]


@contextmanager
def cluster(
    folder: Path, workers: int = 2, nannies: bool = False, path: Path = ROOT
) -> Iterator[Cluster]:
    """Start a scheduler and workers of one thread each.

    Parameters
    ----------
    nannies : start a worker again where it dies
    path : where the workers look for packages first
    """
    file = folder / "scheduler.json"
    where = ["--scheduler-file", str(file)]
    with ExitStack() as stack:

        def start(module: str, *options: str) -> subprocess.Popen[bytes]:
            log = stack.enter_context(open(folder / "cluster.log", "ab"))
            process = subprocess.Popen(
                [sys.executable, "-m", f"distributed.cli.{module}", *where, *options],
                env={**os.environ, "PYTHONPATH": str(path), "OMP_NUM_THREADS": "1"},
                stdout=log,
                stderr=log,
                cwd=folder,
                start_new_session=True,
            )
            stack.callback(_end, process)
            return process

        start("dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard")
        _wait_for(file)
        options = ["--nthreads", "1", "--no-dashboard", "--nanny" if nannies else "--no-nanny"]
        started = tuple(start("dask_worker", *options) for _ in range(workers))
        address = json.loads(file.read_text())["address"]
        if workers:
            from distributed import Client

            with Client(address, timeout=STARTS_WITHIN_S) as client:
                client.wait_for_workers(workers, timeout=STARTS_WITHIN_S)
        yield Cluster(address, started)


def _wait_for(file: Path) -> None:
    end = time.monotonic() + STARTS_WITHIN_S
    while time.monotonic() < end:
        try:
            json.loads(file.read_text())
            return
        except (OSError, ValueError):
            time.sleep(0.05)
    raise TimeoutError(f"no scheduler within {STARTS_WITHIN_S} s")


def _end(process: subprocess.Popen[bytes]) -> None:
    """End a process with all that it started."""
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()
