"""What goes wrong, as one line on the terminal."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager

import typer
from rich.console import Console

from models.errors import InputError


def one_line_warning(message: Warning | str, *_: object, **__: object) -> None:
    """Print a warning without the code that it came from; a `warnings.showwarning`."""
    print(f"pen-mhe: {message}", file=sys.stderr)


@contextmanager
def one_sentence() -> Iterator[None]:
    """Turn bad input into its sentence and exit status 2."""
    try:
        yield
    except InputError as error:
        Console(stderr=True, highlight=False, soft_wrap=True).print(
            f"pen-mhe: {error}", markup=False
        )
        raise typer.Exit(2) from None
