"""Times are measured without threads: how a process is told, and how one knows that it was."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from types import MappingProxyType

SINGLE_THREADED: Mapping[str, str] = MappingProxyType(
    {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
)
"""Environment under which NumPy, SciPy and CasADi's solvers start no threads."""


def is_single_threaded() -> bool:
    """Return whether the environment had been set when NumPy was imported."""
    return all(os.environ.get(name) == value for name, value in SINGLE_THREADED.items())


@contextmanager
def single_threaded_children() -> Iterator[None]:
    """Let processes that begin within this block start no threads."""
    before = {name: os.environ.get(name) for name in SINGLE_THREADED}
    os.environ.update(SINGLE_THREADED)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
