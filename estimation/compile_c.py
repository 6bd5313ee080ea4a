"""One C source to one shared library, in a folder of its own that goes whatever happens."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from estimation.compile_cache import VARIABLE, write_sealed
from estimation.half_made import half_made_folder
from models.errors import InputError


@dataclass(frozen=True)
class CSource:
    """C99 of one shared library.

    Parameters
    ----------
    flags : the compiler's options in addition to `FLAGS`
    is_of_model : whether a model decides if it can be compiled
    """

    text: str
    flags: tuple[str, ...] = ()
    is_of_model: bool = False


class NotCompilableError(RuntimeError):
    """A generated function is no C that this machine can compile; the message says why."""


NO_ROOM = (
    *(os.strerror(number) for number in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)),
    *([str(signal.strsignal(signal.SIGXFSZ))] if hasattr(signal, "SIGXFSZ") else []),
)
"""What a compiler says that could not write its files."""


def build(compiler: Sequence[str], source: CSource, target: Path) -> None:
    """Compile C and put the library in place, sealed.

    Parameters
    ----------
    compiler : the program and its options for every source
    target : the library's path; its folder is made where it is missing

    Raises
    ------
    RuntimeError
        If the compiler rejects the code; the message is its own.
    InputError
        If there is no room for what is compiled.
    """
    try:
        target.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        with half_made_folder(target) as scratch:
            write_sealed(_library(compiler, source, scratch), target)
    except OSError as error:
        raise _no_room(target.parent, error.strerror or str(error)) from None


def _library(compiler: Sequence[str], source: CSource, scratch: Path) -> bytes:
    code, built = scratch / "generated.c", scratch / "built.so"
    code.write_text(source.text)
    arguments = [*compiler, *source.flags, str(code), "-o", str(built), "-lm"]
    environment = {**os.environ, "TMPDIR": str(scratch), "LC_ALL": "C"}
    result = subprocess.run(arguments, capture_output=True, text=True, env=environment)
    if result.returncode == 0:
        return built.read_bytes()
    said = result.stderr.strip()
    if reason := lack_of_room(said):
        raise _no_room(scratch.parent, reason)
    kind = NotCompilableError if source.is_of_model else RuntimeError
    raise kind(f"{compiler[0]} could not compile C: {said}")


def lack_of_room(said: str) -> str | None:
    """Return why a compiler could not write its files, from what it said; None where it could."""
    return next((reason for reason in NO_ROOM if reason in said), None)


def _no_room(folder: Path, reason: str) -> InputError:
    return InputError(
        f"cache {folder}: {reason}, expected room for compiled functions; "
        f"{VARIABLE} names another folder"
    )
