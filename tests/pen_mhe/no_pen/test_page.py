"""Every command and every example of the page on recordings without a pen file runs."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from typer.testing import CliRunner

from commands.cli import app

PAGE = (Path(__file__).parents[3] / "docs" / "no_pen.md").read_text("utf-8")


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)


@pytest.mark.slow
def test_the_page_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    example, from_python = blocks("python")
    exec(compile(example, "example", "exec"), {})
    commands = [line for block in blocks("sh") for line in block.splitlines()]
    printed = []
    for command in commands:
        words = shlex.split(command)
        if words[0] == "pen-mhe":
            result = CliRunner().invoke(app, words[1:])
            assert result.exit_code == 0, result.output
            printed.append(result.output)
    assert len(printed) == 2
    assert (tmp_path / "estimate.png").stat().st_size > 10_000
    for line in blocks("text")[0].splitlines():
        assert line in printed[0], line
    exec(compile(from_python, "from python", "exec"), {})
