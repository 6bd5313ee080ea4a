"""What is half made beside its place: locked while somebody works on it, else left by a kill.

Its name is ``.<name of the place>.<eight digits>.part``. Without locks (Windows) nothing is
taken for left over.
"""

from __future__ import annotations

import contextlib
import os
import re
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType

_locks: ModuleType | None
try:
    import fcntl as _locks
except ImportError:  # Windows
    _locks = None

HAS_LOCKS = _locks is not None
LONGEST_NAME = 220
"""Bytes of a place's name that are kept: file systems take 255, and the rest needs some."""


@contextlib.contextmanager
def half_made_file(place: Path) -> Iterator[tuple[Path, int]]:
    """Make a file beside a place; it is removed at the end unless it was moved.

    Yields
    ------
    Its path, and its descriptor, open for reading and writing. It holds the lock.
    """
    flags = os.O_RDWR | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)
    path, held = _claimed(place, lambda path: os.open(path, flags, 0o666))
    try:
        yield path, held
    finally:
        with contextlib.suppress(OSError):
            path.unlink()
        with contextlib.suppress(OSError):  # closed already where there are no locks
            os.close(held)


@contextlib.contextmanager
def half_made_folder(place: Path) -> Iterator[Path]:
    """Make a folder of one's own beside a place; it is removed at the end."""

    def make(path: Path) -> int:
        path.mkdir(mode=0o700)
        return os.open(path, os.O_RDONLY) if HAS_LOCKS else os.open(os.devnull, os.O_RDONLY)

    path, held = _claimed(place, make)
    try:
        yield path
    finally:
        shutil.rmtree(path, ignore_errors=True)
        os.close(held)


def await_others(place: Path) -> None:
    """Wait until nobody works beside a place any more; without locks, wait for nobody."""
    if _locks is None:
        return
    with contextlib.suppress(OSError):
        for path in _parts(place):
            with contextlib.suppress(OSError):  # gone by now, or somebody else's
                held = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
                try:
                    _locks.flock(held, _locks.LOCK_EX)
                finally:
                    os.close(held)


def remove_left_overs(place: Path) -> None:
    """Remove what killed runs have left beside a place; what another run works on stays."""
    with contextlib.suppress(OSError):
        for path in _parts(place):
            _remove_left_over(path)


def _parts(place: Path) -> list[Path]:
    """Return what is half made beside a place; raises `OSError` where its folder is not read."""
    pattern = re.compile(re.escape(_short(place.name)) + r"\.[0-9a-f]{8}\.part")
    return [place.with_name(name) for name in os.listdir(place.parent) if pattern.fullmatch(name)]


def _claimed(place: Path, make: Callable[[Path], int]) -> tuple[Path, int]:
    """Return what was made under a new name, and the descriptor that holds its lock."""
    remove_left_overs(place)
    while True:
        path = place.with_name(f"{_short(place.name)}.{os.urandom(4).hex()}.part")
        # Before it has its lock, or is open, another run may take it for left over.
        try:
            held = make(path)
        except FileNotFoundError:
            if not place.parent.is_dir():
                raise
            continue
        if _locks is None:
            return path, held
        _locks.flock(held, _locks.LOCK_EX)
        with contextlib.suppress(FileNotFoundError):
            if os.path.samestat(os.fstat(held), os.lstat(path)):
                return path, held
        os.close(held)


def _short(name: str) -> str:
    return "." + os.fsdecode(os.fsencode(name)[:LONGEST_NAME])


def _remove_left_over(path: Path) -> None:
    if _locks is None:
        return
    with contextlib.suppress(OSError):  # gone by now, locked, or somebody else's
        held = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
        try:
            _locks.flock(held, _locks.LOCK_EX | _locks.LOCK_NB)
            if path.is_dir():
                shutil.rmtree(path, ignore_errors=True)
            else:
                path.unlink()
        finally:
            os.close(held)
