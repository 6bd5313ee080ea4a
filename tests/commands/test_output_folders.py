"""Commands that fill a folder refuse one that cannot be written before they work."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

from commands.cli import app

COMMANDS = (*(("benchmark", "pen"), ("benchmark", "speed"), ("benchmark", "real-time")),)


@pytest.mark.parametrize("command", COMMANDS, ids=" ".join)
def test_a_file_stands_in_the_way(command: tuple[str, ...], tmp_path: Path) -> None:
    taken = tmp_path / "taken"
    taken.write_text("mine")
    result = CliRunner().invoke(app, [*command, "--output", str(taken)])
    said = result.stderr
    assert result.exit_code == 2
    assert said.startswith(f"pen-mhe: output {taken}: ")
    assert said.endswith("expected a folder that can be written\n")
    assert said.count("\n") == 1
    assert taken.read_text() == "mine"
