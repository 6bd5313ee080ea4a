"""The command that holds the commands: how they are helped with, and how they end."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import typer
from typer.core import TyperGroup

from commands.help_page import PageContext
from commands.later import LATER, load, while_completing
from commands.replaced import check_replaced
from commands.sentences import EXIT_CODES, INTERRUPTED, ExitCode, one_sentence, say, usage_sentence
from models.errors import InputError
from models.names import unknown

UsageError: Any = typer.BadParameter.__bases__[0]
"""Of every wrong call; Typer has no name for it outside."""


def _check_words(words: Sequence[str]) -> None:
    """Raise `InputError` for an empty word: as a path it would be the folder one is in."""
    for before, word in pairwise(("pen-mhe", *words)):
        if not word:
            raise InputError(f"the word behind {before} is empty, expected a name or a value")


class App(typer.Typer):
    """The program: Ctrl-C while its commands are built is said in a sentence, too."""

    def __call__(self, *args: Any, **extra: Any) -> Any:
        """Run the command that the words name, and leave Python with its `ExitCode`."""
        try:
            return super().__call__(*args, **extra)
        except KeyboardInterrupt:
            say(INTERRUPTED)
            sys.exit(ExitCode.INTERRUPTED)


class Siblings(TyperGroup):
    """Commands that belong together, as ``pen-mhe calibrate still``."""

    context_class = PageContext

    def get_short_help_str(self, limit: int = 0) -> str:
        """Return what the commands do, whole: `HelpPage` has lines enough."""
        return super().get_short_help_str(sys.maxsize)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return the command that was named, or say which one was meant."""
        typed, known = args[0], self.list_commands(ctx)
        if not (ctx.resilient_parsing or typed in known or typed.startswith("-")):
            raise unknown("command", typed, known)
        return super().resolve_command(ctx, args)


class Commands(Siblings):
    """Ends with an `ExitCode`, and with one sentence unless it is done."""

    def main(
        self,
        args: Any = None,
        prog_name: str | None = None,
        complete_var: str | None = None,
        standalone_mode: bool = True,
        windows_expand_args: bool = True,
        **extra: Any,
    ) -> Any:
        """Run a command; see `typer.core.TyperGroup.main`."""
        try:
            _check_words(sys.argv[1:] if args is None else args)
            code = super().main(args, prog_name, complete_var, False, windows_expand_args, **extra)
        except InputError as error:
            say(str(error))
            code = ExitCode.REFUSED
        except UsageError as error:
            if type(error).__name__ == "NoArgsIsHelpError":  # its message is the help page
                print(error.format_message(), file=sys.stderr)
            else:
                command = "pen-mhe" if error.ctx is None else error.ctx.command_path
                say(usage_sentence(error.format_message(), command))
            code = ExitCode.REFUSED
        if standalone_mode:
            sys.exit(int(code or ExitCode.DONE))
        return code

    def make_context(self, *args: Any, **extra: Any) -> Any:
        """Read the words before a command's name."""
        with one_sentence():
            return super().make_context(*args, **extra)

    def invoke(self, ctx: Any) -> Any:
        """Run the command that was named."""
        with one_sentence():
            return super().invoke(ctx)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return the command that was named, or say which one does its work now."""
        check_replaced(args[0])
        return super().resolve_command(ctx, args)

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the names of the commands, in the order of the help."""
        return [*LATER, *super().list_commands(ctx)]

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return a command, or what completes its words where a shell asks for that."""
        if cmd_name not in LATER:
            return super().get_command(ctx, cmd_name)
        return while_completing(cmd_name, ctx.args) if ctx.resilient_parsing else load(cmd_name)

    def format_epilog(self, ctx: Any, formatter: Any) -> None:
        """Write the exit codes below the commands."""
        with formatter.section("Exit codes"):
            formatter.write_dl([(str(int(code)), text) for code, text in EXIT_CODES.items()])
