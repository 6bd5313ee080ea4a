"""How a command ends: its exit code, and what goes wrong as one line on the terminal."""

from __future__ import annotations

import errno
import re
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from enum import IntEnum
from types import MappingProxyType

import typer

from models.errors import InputError
from models.names import did_you_mean
from models.shown_text import one_line


class ExitCode(IntEnum):
    """What a command tells the shell."""

    DONE = 0
    FAULT = 1
    NOT_MEANT = 1
    REFUSED = 2
    INTERRUPTED = 130


EXIT_CODES: Mapping[ExitCode, str] = MappingProxyType(
    {
        ExitCode.DONE: "Done.",
        ExitCode.FAULT: "An answer that cannot be meant, the last line says why; or, with a "
        "traceback, a fault of pen-mhe itself.",
        ExitCode.REFUSED: "Input that is refused: one sentence on stderr says what was expected.",
        ExitCode.INTERRUPTED: "Interrupted (Ctrl-C): one sentence says what is kept.",
    }
)
"""Exit code → what it means, for the help."""

OF_THE_SYSTEM = frozenset(
    [
        *(errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO),
        *(errno.EACCES, errno.EPERM, errno.EROFS),
        *(errno.EISDIR, errno.ENAMETOOLONG, errno.ELOOP),
    ]
)
"""Errors with files that a person can mend: they are no faults of pen-mhe."""

INTERRUPTED = "interrupted; files that were written before are kept"


def one_line_warning(message: Warning | str, *_: object, **__: object) -> None:
    """Print a warning without the code that it came from; a `warnings.showwarning`."""
    say(str(message))


def say(sentence: str) -> None:
    """Print one sentence on stderr, or the lines of one; no terminal obeys what stands in it."""
    lines = [one_line(line) for line in sentence.split("\n")]
    print("pen-mhe: " + "\n".join(lines), file=sys.stderr)


@contextmanager
def one_sentence() -> Iterator[None]:
    """Turn bad input, limits of the system and Ctrl-C into their sentence and `ExitCode`."""
    try:
        yield
    except InputError as error:
        say(str(error))
        raise typer.Exit(ExitCode.REFUSED) from None
    except OSError as error:
        if error.errno not in OF_THE_SYSTEM:
            raise
        what = error.filename or "what is written"
        say(f"{what}: {error.strerror}, expected room and permission")
        raise typer.Exit(ExitCode.REFUSED) from None
    except KeyboardInterrupt as interrupt:
        say(str(interrupt) or INTERRUPTED)
        raise typer.Exit(ExitCode.INTERRUPTED) from None


def usage_sentence(message: str, command: str) -> str:
    """Return Typer's message on a wrong call as one sentence.

    Parameters
    ----------
    message : of Typer, in one line or several
    command : that was called, with the program's name
    """
    text = " ".join(message.split()).rstrip(".").replace("Value error, ", "")
    if choice := re.search("'([^']*)' is not one of (.*)", text):
        text += did_you_mean(choice[1], re.findall("'([^']*)'", choice[2]))
    text = re.sub(r" \(Possible options: (.*)\)", r"; did you mean \1?", text)
    return f"{text[:1].lower()}{text[1:]} (see {command} --help)"
