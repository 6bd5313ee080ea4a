"""A table of this project's own that does not fit as it stands: read whole, it may be mended."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from models.errors import InputError, UnforeseenError


class UnfitTableError(InputError):
    """A table whose columns are a recording's, and whose header or rows are not."""


@contextmanager
def unfit() -> Iterator[None]:
    """Raise `UnfitTableError`, in the same words, for an `InputError` within."""
    try:
        yield
    except (UnfitTableError, UnforeseenError):
        raise
    except InputError as error:
        raise UnfitTableError(str(error)) from error
