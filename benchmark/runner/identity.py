"""What a result depends on besides its task: the code, its libraries, the files it read."""

from __future__ import annotations

import hashlib
import platform
from functools import cache
from importlib.metadata import version
from pathlib import Path

from benchmark.tasks.suite import Scope
from models.errors import InputError
from pen_mhe.rooms import ROOT, rooms

SHOWS_ONLY = ("commands/", "benchmark/report/", "benchmark/figures/", "benchmark/verdicts/")
"""Code that no result depends on."""

SUFFIXES = (".py", ".pyi", ".c", ".h", ".txt", ".toml")
LIBRARIES = ("casadi", "numpy", "scipy", "osqp", "pandas", "pyarrow", "pydantic", "pen-mhe")
NUMERICAL = ("casadi", "numpy", "scipy")
"""Libraries whose other versions may give other digits."""


def versions() -> dict[str, str]:
    """Return the versions of Python and of the libraries."""
    return {"python": platform.python_version(), **{name: version(name) for name in LIBRARIES}}


@cache
def code_identity(root: Path = ROOT) -> str:
    """Return a hash of the package's own code and data and of its numerical libraries.

    Parameters
    ----------
    root : the folder that the rooms stand in
    """
    digest = hashlib.sha256()
    for room in rooms(root):
        for path in sorted((root / room).rglob("*")):
            name = path.relative_to(root).as_posix()
            if path.suffix in SUFFIXES and not name.startswith(SHOWS_ONLY):
                digest.update(name.encode() + path.read_bytes())
    for name in NUMERICAL:
        digest.update(f"{name} {version(name)}".encode())
    return digest.hexdigest()[:16]


@cache
def folder_identity(folder: Path) -> str:
    """Return a hash of the files of a folder; raises `OSError` where one cannot be read."""
    digest = hashlib.sha256()
    for path in sorted(path for path in folder.rglob("*") if path.is_file()):
        digest.update(path.relative_to(folder).as_posix().encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def task_identity(recordings: str, scope: Scope) -> str:
    """Return what a finished task must have been run with to count as finished.

    Parameters
    ----------
    recordings : the folder within `Scope.data` that it reads; empty where it reads none

    Raises
    ------
    InputError
        If a file of the data cannot be read.
    """
    if not recordings or scope.data is None:
        return code_identity()
    try:
        return f"{code_identity()}-{folder_identity(Path(scope.data) / recordings)}"
    except OSError as error:
        raise InputError(f"data folder {scope.data}: {error}, expected readable files") from None
