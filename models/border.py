"""The border of a reader: what is wrong with a file leaves it as one sentence.

Every reader does its work within `reading`, as a context or a decorator. What it foresees it
refuses itself, with the row or key. What nobody foresaw becomes an `UnforeseenError` whose cause
is the exception as it was raised: it hides nothing from who looks for a fault of ours.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from models.errors import InputError, UnforeseenError
from models.shown_text import LONGEST_VALUE, one_line


@contextmanager
def reading(where: object, expected: str) -> Iterator[None]:
    """Raise `InputError` for any exception within, except for Ctrl-C and the end of the process.

    Parameters
    ----------
    where : what is read: ``pen file my.toml``
    expected : what it should be: ``TOML``

    Raises
    ------
    InputError
        As it was raised within; or for a file that cannot be read, is nested too deeply or needs
        more memory than there is.
    UnforeseenError
        For anything else.
    """
    try:
        yield
    except InputError:
        raise
    except MemoryError as error:
        raise InputError(
            f"{where}: reading it needs more memory than there is, expected {expected}"
        ) from error
    except RecursionError as error:
        raise InputError(f"{where}: is nested too deeply, expected {expected}") from error
    except OSError as error:
        reason = error.strerror or one_line(str(error), LONGEST_VALUE)
        raise InputError(f"{where}: {reason}, expected {expected}") from error
    except Exception as error:
        reason = one_line(f"{type(error).__name__}: {error}", LONGEST_VALUE)
        raise UnforeseenError(f"{where}: cannot be read ({reason}), expected {expected}") from error
