"""``pen-mhe estimate`` does not write over the recording that it reads."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

from commands.cli import app

pytestmark = pytest.mark.usefixtures("interpreted")


@pytest.mark.parametrize("option", ["--output", "--figure"])
def test_the_recording_is_no_output(tmp_path: Path, option: str) -> None:
    recording = tmp_path / ("pen.csv" if option == "--output" else "pen.png")
    recording.write_text("mine")
    paths = {"--output": str(tmp_path / "out.csv"), option: str(tmp_path / "." / recording.name)}
    words = [word for pair in paths.items() for word in pair]
    result = CliRunner().invoke(app, ["estimate", str(recording), "--pen", "reference", *words])
    assert result.exit_code == 2
    assert "is the recording itself, expected another file" in result.stderr
    assert recording.read_text() == "mine"


def test_nor_is_a_file_of_a_recording_that_is_a_folder(tmp_path: Path) -> None:
    (tmp_path / "stylus.csv").write_text("mine")
    words = ["--pen", "dpoint", "--output", str(tmp_path / "stylus.csv")]
    result = CliRunner().invoke(app, ["estimate", str(tmp_path), *words])
    assert result.exit_code == 2
    assert (tmp_path / "stylus.csv").read_text() == "mine"
