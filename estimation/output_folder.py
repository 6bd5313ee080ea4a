"""Folders for results: only the last folder of a path is made, so that a typo makes no tree."""

from __future__ import annotations

import contextlib
import errno
import os
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

from models.errors import InputError

RESULTS = Path("results")
"""Where commands write unless they are told otherwise: made together with a folder in it."""


def check_folder(folder: Path) -> None:
    """Refuse a folder that cannot be made or written, before the work that would be lost.

    Makes nothing.

    Raises
    ------
    InputError
        If there is none and it cannot be made, or it cannot be written to.
    """
    with _one_sentence(folder):
        if folder.exists():
            if not folder.is_dir():
                raise OSError(errno.ENOTDIR, os.strerror(errno.ENOTDIR))
            writable = folder
        else:
            is_new = folder.parent == RESULTS and not RESULTS.exists()
            writable = RESULTS.parent if is_new else folder.parent
        with tempfile.TemporaryFile(dir=writable):
            pass


def make_folder(folder: Path) -> bool:
    """Make a folder where there is none; raises `InputError` as `check_folder` does.

    Returns
    -------
    Whether there was none.
    """
    with _one_sentence(folder):
        if folder.parent == RESULTS:
            RESULTS.mkdir(exist_ok=True)
        is_new = not folder.exists()
        folder.mkdir(exist_ok=True)
    return is_new


def unmake(made: Sequence[Path]) -> None:
    """Remove files of a run that came to nothing, and folders where nothing else is in them."""
    for path in made:
        with contextlib.suppress(OSError):
            path.rmdir() if path.is_dir() else path.unlink()


@contextlib.contextmanager
def _one_sentence(folder: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        reason = error.strerror or str(error)
        if error.errno == errno.ENOENT:
            reason = f"there is no folder {folder.parent} to make it in"
        raise InputError(
            f"output {folder}: {reason}, expected a folder that can be written"
        ) from None
