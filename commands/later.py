"""Commands whose options are slow to find, and what completes their words without finding them.

The options of ``estimate`` are the settings of all estimators, those of ``tune`` the objectives:
their modules import them. A shell
that completes the value of ``--pen`` or ``--sensors`` gets a stand-in that has these only.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from types import MappingProxyType
from typing import Annotated, Any

import typer

from commands.help_page import Command
from commands.lists import complete_sensors, completing

LATER: Mapping[str, str] = MappingProxyType(
    {"estimate": "commands.estimate", "tune": "commands.tune"}
)
"""Command → module that has it as a function of its name."""

QUICK = ("--pen", "--sensors")
"""Options that the stand-in has."""


def load(name: str) -> Any:
    """Return a command of `LATER`."""
    return _built(getattr(import_module(LATER[name]), name), name)


def while_completing(name: str, words: list[str]) -> Any:
    """Return what completes a word of a command.

    Parameters
    ----------
    words : between the command's name and the word
    """
    if words and words[-1] not in QUICK:
        return load(name)
    return _built(_quick, name, _StandIn, ignore_unknown_options=True, allow_extra_args=True)


def _quick(
    pen: Annotated[str | None, typer.Option(autocompletion=completing("pens"))] = None,
    sensors: Annotated[str | None, typer.Option(autocompletion=complete_sensors)] = None,
) -> None:
    pass


class _StandIn(Command):
    """Completes values; for the names of options it asks the command."""

    def shell_complete(self, ctx: Any, incomplete: str) -> Any:
        if not incomplete.startswith("-"):
            return []  # the shell then completes a file
        return load(ctx.info_name).shell_complete(ctx, incomplete)


def _built(
    function: Callable[..., Any], name: str, kind: type[Command] = Command, **settings: Any
) -> Any:
    alone = typer.Typer(add_completion=False, rich_markup_mode=None)
    alone.command(name, cls=kind, context_settings=settings)(function)
    return typer.main.get_command(alone)
