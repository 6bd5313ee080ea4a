"""Commands of earlier versions say what does their work now."""

from __future__ import annotations

import pytest
from typer.testing import CliRunner

from commands.cli import app
from commands.replaced import REPLACED
from commands.sentences import ExitCode


@pytest.mark.parametrize("command", REPLACED)
def test_a_command_that_is_gone_names_the_one_that_replaces_it(command: str) -> None:
    result = CliRunner().invoke(app, [command, "--output", "somewhere"])
    assert result.exit_code == ExitCode.REFUSED == 2
    assert result.stderr == f"pen-mhe: command {command} is gone, expected {REPLACED[command]}\n"
    words = REPLACED[command].split()
    assert words[0] == "pen-mhe"
    helped = CliRunner().invoke(app, [words[1], "--help"])
    assert helped.exit_code == 0
    assert all(word in helped.stdout for word in words[2:])


def test_real_time_is_a_suite() -> None:
    assert REPLACED["real-time"] == "pen-mhe benchmark real-time"
