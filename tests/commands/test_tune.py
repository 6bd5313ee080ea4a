"""``pen-mhe tune``: what it writes, what it refuses, and how it ends."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner, Result

import pen_mhe as pm
from commands.cli import app
from models.bundled import bundled_pens
from pen_mhe.tuning.search import Search
from recordings.formats.tables import recording_to_table, write_table

pytestmark = pytest.mark.usefixtures("interpreted")
KEY = "sensors.gyro.noise_density_mdeg_s_per_sqrt_hz"


@pytest.fixture
def words(tmp_path: Path) -> list[str]:
    """A command on nine seconds of a gyroscope, and a pen file of one's own."""
    pen = tmp_path / "mine.toml"
    pen.write_text(bundled_pens()["dpoint"].read_text("utf-8"), "utf-8")
    times = np.arange(0.0, 9.0, 0.05)
    rates = 0.01 * np.random.default_rng(0).standard_normal((len(times), 3))
    recording = pm.Recording.from_sensors("still", {"gyro": (times, rates)})
    write_table(recording_to_table(recording, pm.load_pen(pen)), tmp_path / "still.csv")
    return [
        *("tune", str(tmp_path / "still.csv"), "--pen", str(pen), "--sensors", "gyro"),
        *("--parameters", KEY, "--output", str(tmp_path / "new.toml")),
    ]


def run(words: list[str]) -> Result:
    return CliRunner().invoke(app, words, prog_name="pen-mhe")


def no_search(numbers: list[float]) -> Any:
    """Return a search that ends at once with some numbers."""

    def found(search: Search) -> None:
        search._value(np.array(numbers))

    return found


def test_it_writes_a_pen_file_and_says_what_changed(
    words: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Search, "run", no_search([1e-3]))
    monkeypatch.setattr(Search, "ranges", lambda search: [(5e-4, np.inf)])
    result = run(words)
    assert result.exit_code == 0, result.output
    assert "| key | before | after | as good within |" in result.stdout
    assert f"| {KEY} | 130 | 57.3 | above 28.6 |" in result.stdout
    assert f"{KEY} is not determined: above 28.6 loses less than 2 nats" in result.stdout
    assert "| innovations | log likelihood |" in result.stdout
    text = (tmp_path / "new.toml").read_text("utf-8")
    assert "noise_density_mdeg_s_per_sqrt_hz = 57.3" in text
    assert "# innovations set these numbers" in text
    assert f"#   {KEY} = 57.3" in text
    gyro = pm.load_pen(tmp_path / "new.toml").sensors["gyro"]
    assert gyro.noise_density_rad_s_per_sqrt_hz == pytest.approx(1e-3, rel=1e-3)  # type: ignore[attr-defined]


@pytest.mark.parametrize("output", ["mine.toml", "../{folder}/mine.toml"])
def test_the_pen_file_is_no_output(words: list[str], tmp_path: Path, output: str) -> None:
    before = (tmp_path / "mine.toml").read_text("utf-8")
    words[-1] = str(tmp_path / output.format(folder=tmp_path.name))
    result = run(words)
    assert result.exit_code == 2
    assert "is the pen file that is read" in result.stderr
    assert (tmp_path / "mine.toml").read_text("utf-8") == before


def test_nor_is_a_bundled_pen_or_another_kind_of_file(words: list[str]) -> None:
    for output in (bundled_pens()["reference"], Path("new.csv")):
        result = run([*words[:-1], str(output)])
        assert result.exit_code == 2
        assert "expected" in result.stderr


def test_objectives_and_parts_are_of_their_lists(words: list[str]) -> None:
    assert "innovations" in run([*words, "--objective", "flat"]).stderr
    assert "second-half" in run([*words, "--fit", "last"]).stderr


def test_an_interrupt_leaves_no_file_and_says_what_was_found(
    words: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken_off(search: Search) -> None:
        search._value(np.array([1e-3]))
        raise KeyboardInterrupt

    monkeypatch.setattr(Search, "run", broken_off)
    before = sorted(path.name for path in tmp_path.iterdir())
    result = run(words)
    assert result.exit_code == 130
    assert "interrupted after 1 evaluations; nothing is written; best so far" in result.stderr
    assert "sensors.gyro.noise_density_rad_s_per_sqrt_hz 0.001" in result.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == before
