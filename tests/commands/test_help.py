"""Help pages at the width of a terminal: whole words, all names, and how a command ends."""

from __future__ import annotations

import re
from contextlib import redirect_stdout
from io import StringIO
from typing import Any

import pytest
import typer
from typer.testing import CliRunner

from commands.cli import app
from commands.lists import LISTS, filled
from commands.sentences import EXIT_CODES, ExitCode

GROUP: Any = typer.main.get_command(app)
COMMANDS = GROUP.list_commands(GROUP.make_context("pen-mhe", ["observe"]))


def page(*arguments: str, columns: int = 80) -> str:
    """A help page on a terminal of a width; Typer's runner knows only one."""
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(StringIO()) as printed:
        patch.setenv("COLUMNS", str(columns))
        assert GROUP.main([*arguments, "--help"], "pen-mhe", standalone_mode=False) == 0
    return printed.getvalue()


def words_of(command: str) -> set[str]:
    """All words that the help of a command is made of, before it is laid out."""
    found = GROUP.get_command(GROUP.make_context("pen-mhe", ["observe"]), command)
    texts = [found.help or ""]
    for parameter in found.params:
        more = "..." if parameter.nargs == -1 else ""
        names = [f"{name}{more}" for name in parameter.opts]
        texts += [parameter.help or "", *names, *parameter.secondary_opts]
    return {word for text in texts for word in filled(text).split()}


@pytest.mark.parametrize("columns", [80, 79, 60])
@pytest.mark.parametrize("command", COMMANDS)
def test_no_word_is_broken(command: str, columns: int) -> None:
    printed = page(command, columns=columns)
    assert max(map(len, printed.splitlines())) <= columns
    assert words_of(command) - {"/"} <= set(printed.split())
    assert "…" not in printed.replace("(…_std)", "").replace("true_…", "")


@pytest.mark.parametrize("columns", [80, 79])
def test_the_first_page_says_what_every_command_does_and_how_it_ends(columns: int) -> None:
    printed = page(columns=columns)
    assert max(map(len, printed.splitlines())) <= columns
    text = " ".join(printed.split())
    for command in COMMANDS:
        sentence = " ".join(page(command).split("\n\n")[1].split())
        assert f" {command} {sentence}" in text
    for code, meaning in EXIT_CODES.items():
        assert f" {int(code)} {meaning}" in text
    assert set(EXIT_CODES) == set(ExitCode)


def test_names_stand_in_the_help_of_the_commands_that_take_them() -> None:
    for command, key in (
        ("simulate", "motions"),
        ("observe", "pens"),
        ("benchmark", "suites"),
        ("benchmark", "suites_by_name"),
        ("codegen", "exportable"),
    ):
        assert ", ".join(LISTS[key]()) in " ".join(page(command).split())


def test_no_list_stays_open() -> None:
    for command in COMMANDS:
        assert not re.search(r"\{(?!recording|folder)\w+\}", page(command))


def test_without_arguments_there_is_the_help() -> None:
    result = CliRunner().invoke(app, [], prog_name="pen-mhe")
    assert result.exit_code == 2
    assert result.stderr.split() == page().split()  # the runner's lines are two wider
