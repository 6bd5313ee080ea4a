"""Others' packages: imported when they run, left out with a reason where they cannot be."""

from __future__ import annotations

import importlib
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.metadata import PackageNotFoundError, version
from types import ModuleType
from typing import Any


class ContenderAbsentError(Exception):
    """A contender cannot be built here; its message says why."""


@contextmanager
def in_silence() -> Iterator[None]:
    """Keep a peer's warnings to itself: they are about itself."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


def peer(module: str, package: str) -> tuple[Any, str]:
    """Import a peer only now, in silence; return the module and the package's version.

    Raises
    ------
    ContenderAbsentError
        If it cannot be imported.
    """
    try:
        with in_silence():
            found: ModuleType = importlib.import_module(module)
    except ImportError as error:
        raise ContenderAbsentError(f"{package} cannot be imported ({error})") from None
    return found, f"{package} {version(package)}"


def installed(package: str) -> str:
    """Return the version of a package, without importing it; empty where it is not there."""
    try:
        return version(package)
    except PackageNotFoundError:
        return ""
