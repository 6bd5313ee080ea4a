"""What a command refuses leaves nothing, and nothing that it reads is written over."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from commands.cli import app
from models.bundled import bundled_pens
from tests.rooms_to_write import contents

pytestmark = pytest.mark.usefixtures("interpreted")

ROOT = Path(__file__).parents[2]
RECORDING = "time_s,accel_x_m_s2,accel_y_m_s2,accel_z_m_s2\n" + "".join(
    f"{k / 100},0.1,0.2,9.8\n" for k in range(50)
)


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder to work in, with a recording and a pen."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("PEN_MHE_DATA", raising=False)
    (tmp_path / "pen.csv").write_text(RECORDING)
    (tmp_path / "mine.toml").write_text(bundled_pens()["reference"].read_text("utf-8"), "utf-8")
    (tmp_path / "bad.toml").write_text("[sensors.accel]\nkind = 'thermometer'\n")
    (tmp_path / "bad.csv").write_text(RECORDING.replace("9.8", "nan"))
    return tmp_path


def refused(*words: str) -> str:
    """Call a command that is refused; return its sentence."""
    result: Any = CliRunner().invoke(app, words, prog_name="pen-mhe")
    assert result.exit_code == 2, result.output
    assert result.stdout == ""
    assert result.stderr.count("\n") == 1
    assert result.stderr.startswith("pen-mhe: ")
    return str(result.stderr).removeprefix("pen-mhe: ").rstrip()


ESTIMATE = ("estimate", "pen.csv", "--pen", "mine.toml")
TUNE = ("tune", "pen.csv", "--pen", "mine.toml")
STILL = ("calibrate", "still", "pen.csv", "--pen", "mine.toml")
OVER: dict[str, tuple[tuple[str, ...], str, str]] = {
    "estimate": (ESTIMATE, "--output", "pen.csv"),
    "estimate's pen": (ESTIMATE, "--output", "mine.toml"),
    "figure": ((*ESTIMATE, "--output", "new.csv"), "--figure", "pen.csv"),
    "tune": (TUNE, "--output", "mine.toml"),
    "tune's recording": (TUNE, "--output", "pen.csv"),
    "calibrate": (STILL, "--output", "mine.toml"),
    "calibrate's recording": (STILL, "--output", "pen.csv"),
    "simulate": (("simulate", "--pen", "mine.toml"), "--output", "mine.toml"),
}
"""Command → its words, the option for what is written, and what it reads."""
LINKS: dict[str, Callable[[Path, Path], object]] = {
    "itself": lambda link, read: None,
    "link": lambda link, read: link.symlink_to(read.name),
    "link to a link": lambda link, read: (
        link.with_name("between").symlink_to(read),
        link.symlink_to("between"),
    ),
    "hard link": lambda link, read: link.hardlink_to(read),
}


@pytest.mark.cover
@pytest.mark.parametrize("how", LINKS)
@pytest.mark.parametrize("case", OVER)
def test_what_is_read_is_not_written_over(case: str, how: str, here: Path) -> None:
    words, option, read = OVER[case]
    link = here / f"link{'.toml' if option == '--output' and 'csv' not in read else '.csv'}"
    LINKS[how](link, here / read)
    output = link.name if link.exists() else f"./{read}"
    before = contents(here)
    said = refused(*words, option, output)
    assert said.startswith(f"output {Path(output)} is the ")
    assert "itself, expected another file: it would be lost" in said
    assert contents(here) == before


def test_an_export_is_not_written_over_its_pen(here: Path) -> None:
    (here / "c").mkdir()
    (here / "c" / "README.md").symlink_to("../mine.toml")
    before = contents(here)
    said = refused("codegen", "--output", "c", "--pen", "mine.toml", "--sensors", "accel")
    assert said.startswith("output c/README.md is the pen file itself")
    assert contents(here) == before


def test_a_run_is_not_written_over_its_recording(here: Path) -> None:
    (here / "r").mkdir()
    os.link(here / "pen.csv", here / "r" / "series.parquet")
    before = contents(here)
    words = ("benchmark", "pen", "--pen", "mine.toml", "--recording", "pen.csv", "--output", "r")
    assert refused(*words).startswith("output r/series.parquet is the recording itself")
    assert contents(here) == before


def test_table_and_figure_are_two_files(here: Path) -> None:
    (here / "o.csv").touch()
    (here / "o.png").symlink_to("o.csv")
    said = refused(*ESTIMATE, "--output", "o.csv", "--figure", "o.png")
    assert said == "outputs o.csv and o.png are one file, expected two"


REFUSED: dict[str, tuple[str, ...]] = {
    "simulate, a pen": ("simulate", "--pen", "bad.toml", "--output", "o.csv"),
    "simulate, a motion": ("simulate", "--motion", "hand", "--output", "o.csv"),
    "simulate, a typo": ("simulate", "--output", "typo/o.csv"),
    "estimate, a pen": ("estimate", "pen.csv", "--pen", "bad.toml", "--output", "o.csv"),
    "estimate, a recording": ("estimate", "bad.csv", "--pen", "reference", "--output", "o.csv"),
    "estimate, a sensor": (*ESTIMATE, "--sensors", "radar", "--output", "o.csv"),
    "estimate, a typo": (*ESTIMATE, "--output", "typo/o.csv"),
    "estimate, a figure's typo": (*ESTIMATE, "--output", "o.csv", "--figure", "typo/o.png"),
    "tune, a recording": ("tune", "bad.csv", "--pen", "mine.toml", "--output", "new.toml"),
    "tune, a typo": (*TUNE, "--output", "typo/new.toml"),
    "calibrate, a recording": (*STILL[:2], "bad.csv", *STILL[3:], "--output", "new.toml"),
    "codegen, a pen": ("codegen", "--pen", "bad.toml", "--output", "c"),
    "codegen, a prefix": ("codegen", "--sensors", "accel", "--prefix", "1", "--output", "c"),
    "codegen, a typo": ("codegen", "--sensors", "accel", "--output", "typo/c"),
    "benchmark, a pen": ("benchmark", "pen", "--pen", "bad.toml", "--output", "r"),
    "benchmark, an estimator": ("benchmark", "pen", "--estimators", "ekv", "--output", "r"),
    "benchmark, a typo": ("benchmark", "pen", "--output", "typo/r"),
    "benchmark speed, a typo": ("benchmark", "speed", "--output", "typo/r"),
    "consistency, a pen": ("benchmark", "consistency", "--pen", "bad.toml", "--output", "r"),
    "benchmark real-time, a typo": ("benchmark", "real-time", "--output", "typo/r"),
    "report, no run": ("report", "typo", "--pictures", "figures"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_a_refused_run_leaves_nothing(case: str, here: Path) -> None:
    before = contents(here)
    said = refused(*REFUSED[case])
    assert ("typo" in said) == ("typo" in REFUSED[case][-1] or "typo" in REFUSED[case])
    assert contents(here) == before


def test_a_folder_is_made_in_one_that_is_there_and_in_results(here: Path) -> None:
    """Where commands write unless they are told otherwise, `results` is made too."""
    words = ("codegen", "--pen", "mine.toml", "--sensors", "accel", "--estimator", "ekf")
    for folder in ("c", "results/c"):
        assert CliRunner().invoke(app, [*words, "--output", folder]).exit_code == 0
        assert (here / folder / "pen.h").is_file()


def test_a_limit_of_the_shell_is_a_sentence(here: Path) -> None:
    """``ulimit -f``, from which the shell's signal would end a program without a word."""
    before = contents(here)
    code = "from commands.cli import app; app(prog_name='pen-mhe')"
    result = subprocess.run(
        [sys.executable, "-c", code, "simulate", "--duration", "0.5", "--output", "o.csv"],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096)),
        capture_output=True,
        text=True,
    )
    assert result.returncode == 2
    assert result.stderr == (
        "pen-mhe: output o.csv: File too large, expected a file that can be written\n"
    )
    assert contents(here) == before
