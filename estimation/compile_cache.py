"""The folder of compiled code: the user's own, and no library in it is loaded that is not whole.

A library ends with a checksum of what stands before it, which loaders do not look at: a truncated
one would kill the process that loads it.
"""

from __future__ import annotations

import atexit
import contextlib
import hashlib
import os
import shutil
import stat
import tempfile
import warnings
from functools import cache
from pathlib import Path

from estimation.output_file import placed

VARIABLE = "PEN_MHE_CACHE"
FORM = "library, SHA-256"
"""How a file of the cache is laid out; those of another layout are other files, never damaged."""
OTHERS = stat.S_IRWXG | stat.S_IRWXO
OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH
_digest = hashlib.sha256


def cache_directory() -> Path:
    """Return where compiled functions are kept: ``PEN_MHE_CACHE`` or the user's cache."""
    if own := os.environ.get(VARIABLE):
        return Path(own)
    root = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(root) / "pen-mhe"


def believed(folder: Path) -> Path:
    """Return a folder whose libraries may be loaded: `folder`, else one of this process alone.

    Nobody else may be able to put a library there. What others may only read is closed to them.
    """
    with contextlib.suppress(FileNotFoundError, NotADirectoryError):  # nothing to be loaded
        state = folder.stat()
        if hasattr(os, "geteuid"):  # Windows has neither owners nor modes
            if state.st_uid != os.geteuid():
                return _private(folder, "belongs to another user")
            if state.st_mode & OTHERS_WRITE:
                return _private(folder, "can be written by others")
            if state.st_mode & OTHERS:
                with contextlib.suppress(OSError):  # a medium that is only read
                    folder.chmod(stat.S_IMODE(state.st_mode) & ~OTHERS)
    return folder


@cache
def writable(folder: Path) -> Path:
    """Return a folder, made where it is missing; where it cannot be written, `private_folder`."""
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except OSError as error:
        return _private(folder, str(error.strerror))


@cache
def private_folder() -> Path:
    """Return a folder that is this process's alone, and gone with it."""
    own = Path(tempfile.mkdtemp(prefix="pen-mhe-"))
    atexit.register(shutil.rmtree, own, ignore_errors=True)
    return own


def write_sealed(library: bytes, target: Path) -> None:
    """Put a library in place with its checksum behind it; raises `OSError`."""
    with placed([target]) as (file,):  # two processes may build the same function
        file.write(library)
        file.write(_digest(library).digest())


def is_whole(path: Path) -> bool:
    """Return whether a library is there as `write_sealed` wrote it."""
    try:
        content = memoryview(path.read_bytes())
    except OSError:
        return False
    end = len(content) - _digest().digest_size
    return end > 0 and _digest(content[:end]).digest() == content[end:]


@cache
def _private(folder: Path, reason: str) -> Path:
    warnings.warn(
        f"cache {folder}: {reason}, so compiled functions are lost when this process "
        f"ends; {VARIABLE} names another folder",
        RuntimeWarning,
        stacklevel=2,
    )
    return private_folder()
