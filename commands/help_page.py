"""Help pages: words stay whole at any width, long lists of names are filled in when printed."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from textwrap import wrap
from typing import Any

import typer
from typer.core import TyperCommand

from commands.lists import filled

FIRST_COLUMN = 26
"""Longer options stand on a line of their own; larger leaves the texts less room."""


PlainPage: Any = typer.Context.formatter_class


class HelpPage(PlainPage):
    """Typer's plain page, which would break a word at a hyphen or where a column ends."""

    def write_usage(self, prog: str, args: str = "", prefix: str | None = None) -> None:
        """Write the line of usage."""
        start = f"{prefix or 'Usage: '}{prog} "
        self._write(args, start, " " * min(len(start), FIRST_COLUMN))

    def write_text(self, text: str) -> None:
        """Write paragraphs."""
        indent = " " * self.current_indent
        for i, paragraph in enumerate(text.split("\n\n")):
            if i:
                self.write("\n")
            self._write(paragraph, indent, indent)

    def write_dl(
        self, rows: Sequence[tuple[str, str]], col_max: int = FIRST_COLUMN, col_spacing: int = 2
    ) -> None:
        """Write options or commands beside what they are."""
        width = min(max(len(first) for first, _ in rows), col_max) + col_spacing
        indent = " " * self.current_indent
        for first, second in rows:
            start = f"{indent}{first:{width}}"
            if len(first) > width - col_spacing:
                # Choices of one option are one word to Typer.
                self._write(first.replace("|", "| "), indent, f"{indent}  ", space="")
                start = f"{indent}{'':{width}}"
            # Older versions of Typer escape brackets for rich.
            text = filled(second).replace("\\[", "[")
            self._write(text, start, f"{indent}{'':{width}}")

    def _write(self, text: str, start: str, indent: str, space: str = " ") -> None:
        lines = wrap(
            text,
            self.width,
            initial_indent=start,
            subsequent_indent=indent,
            break_long_words=False,
            break_on_hyphens=False,
        )
        written = "\n".join(lines) or start.rstrip()
        self.write((written if space else written.replace("| ", "|")) + "\n")


class PageContext(typer.Context):
    """A command that is being called, with its help as `HelpPage`."""

    formatter_class: Any = HelpPage


class Command(TyperCommand):
    """A command with its help as `HelpPage`."""

    context_class = PageContext

    def get_short_help_str(self, limit: int = 0) -> str:
        """Return what the command does, whole: `HelpPage` has lines enough."""
        return super().get_short_help_str(sys.maxsize)
