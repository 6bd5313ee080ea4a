"""Talking to a person: tables on a terminal, plain text in a pipe."""

from __future__ import annotations

import sys

from rich.console import Console
from rich.markdown import Markdown
from rich.table import Table

from models.escaped import in_markdown

console = Console(highlight=False, markup=False, soft_wrap=not sys.stdout.isatty())


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
        print("| " + " | ".join(map(in_markdown, line)) + " |")
