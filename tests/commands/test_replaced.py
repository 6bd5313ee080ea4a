"""Commands that are gone say what does their work now."""

from __future__ import annotations

import pytest
from typer.testing import CliRunner

from commands.cli import app
from commands.replaced import REPLACED
from suites.table import NAMED


@pytest.mark.parametrize("command", REPLACED)
@pytest.mark.parametrize("more", [(), ("--runs", "4"), ("--help",)], ids=str)
def test_a_command_that_is_gone_names_what_replaces_it(command: str, more: tuple[str, ...]) -> None:
    result = CliRunner().invoke(app, [command, *more])
    assert result.exit_code == 2
    assert result.stdout == ""
    assert result.stderr == f"pen-mhe: command {command} is gone, expected {REPLACED[command]}\n"


@pytest.mark.parametrize("sentence", REPLACED.values())
def test_what_replaces_it_is_a_suite(sentence: str) -> None:
    program, command, suite, *_ = sentence.strip("`").split()
    assert (program, command) == ("pen-mhe", "benchmark")
    assert suite in NAMED
