"""Talking to a person: progress on a terminal, one sentence for bad input."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import typer
from rich.console import Console
from rich.markdown import Markdown
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from models.errors import InputError

console = Console(highlight=False, soft_wrap=not sys.stdout.isatty())


@contextmanager
def progress(description: str) -> Iterator[Callable[[int], Callable[[int], None]]]:
    """Show a progress bar on a terminal; nothing in a pipe.

    Yields a function that takes the number of steps and returns what to call per step.
    """
    stderr = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    with Progress(
        *columns,
        TimeRemainingColumn(),
        console=stderr,
        disable=not stderr.is_terminal,
        transient=True,
    ) as bar:

        def start(total: int) -> Callable[[int], None]:
            task = bar.add_task(description, total=total)
            return lambda steps: bar.advance(task, steps)

        yield start


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


def print_markdown(text: str) -> None:
    """Print Markdown: set on a terminal, as it is in a pipe."""
    if console.is_terminal:
        console.print(Markdown(text))
    else:
        print(text)


def print_table(title: str, columns: list[str], rows: list[list[str]]) -> None:
    """Print a table: rich on a terminal, Markdown in a pipe."""
    if console.is_terminal:
        table = Table(title=title)
        for column in columns:
            table.add_column(column)
        for row in rows:
            table.add_row(*row)
        console.print(table)
        return
    print(f"{title}\n")
    for line in (columns, ["---"] * len(columns), *rows):
        print("| " + " | ".join(line) + " |")
