"""How far a long run has come: a bar on a terminal and in a notebook, nothing in a pipe."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from html import escape

EVERY_S = 0.2
"""A notebook's bar is drawn anew no more often."""


@contextmanager
def progress(description: str) -> Iterator[Callable[[int], Callable[[int], None]]]:
    """Show a progress bar on a terminal or in a notebook; nothing in a pipe.

    Yields a function that takes the number of steps and returns what to call as steps are made,
    with their number: the ``on_start`` of `pen_mhe.estimate`.
    """
    from rich.console import Console  # slow to import, and most runs are short

    stderr = Console(stderr=True)
    if stderr.is_jupyter:
        yield lambda total: _in_notebook(description, total)
        return
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeRemainingColumn,
    )

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


def _in_notebook(description: str, total: int) -> Callable[[int], None]:
    # rich draws in a notebook too, but by ipywidgets, of which a stored notebook keeps nothing.
    from IPython.display import display

    done, drawn_s = 0, time.monotonic()
    handle = display(_bar(description, 0, total), raw=True, display_id=True)

    def advance(steps: int) -> None:
        nonlocal done, drawn_s
        done += steps
        now_s = time.monotonic()
        if done >= total or now_s - drawn_s > EVERY_S:
            drawn_s = now_s
            handle.update(_bar(description, done, total), raw=True)

    return advance


def _bar(description: str, done: int, total: int) -> dict[str, str]:
    """Return a bar as what a notebook shows: HTML, and plain text."""
    text = f"{description}: {done} of {total}"
    return {
        "text/plain": text,
        "text/html": f'{escape(text)} <progress value="{done}" max="{total}"></progress>',
    }
