"""``pen-mhe estimate --truth`` in a terminal."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

import pen_mhe as pm
from commands.cli import app
from recordings.formats.tables import recording_to_table, write_table

pytestmark = pytest.mark.usefixtures("interpreted")
SENSORS = ["accel", "gyro", "camera"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a recording without its truth, and the truth on a clock of its own."""
    found = tmp_path_factory.mktemp("truth")
    pen = pm.load_pen("reference")
    recording = pm.simulate(pen, SENSORS, motion="turn", duration_s=0.6, seed=1)
    truth = recording.truth
    assert truth is not None
    elevation = np.degrees(truth.values[:, truth.names.index("elevation_rad")])
    angles = pd.DataFrame({"time_s": truth.time_s - 7.0, "elevation_deg": elevation})
    write_table(angles[angles.time_s < -6.6], found / "angles.csv")
    table = recording_to_table(recording, pen)
    table = table[[c for c in table if not c.startswith("true_")]]
    write_table(table, found / "recording.csv")
    return found


def _estimate(folder: Path, *words: str) -> tuple[int, str]:
    given = ["estimate", str(folder / "recording.csv"), "--pen", "reference", "--estimator", "ekf"]
    given += ["--output", str(folder / "table.csv"), *words]
    result = CliRunner().invoke(app, given)
    return result.exit_code, " ".join((result.stdout + result.stderr).split())


def test_a_truth_gives_errors_columns_and_a_line_in_the_figure(folder: Path) -> None:
    angles = str(folder / "angles.csv")
    figure = folder / "figure.png"
    code, said = _estimate(
        folder, "--truth", angles, "--truth-offset", "7", "--figure", str(figure)
    )
    assert code == 0, said
    assert "its clock + 7.000000 s, as said" in said
    assert "error against it (RMS, median, largest): elevation_deg" in said
    assert "NEES of them together" in said
    table = pd.read_csv(folder / "table.csv")
    assert list(table)[-2:] == ["elevation_rad_true", "elevation_rad_error"]
    assert 0.5 < table.elevation_rad_error.notna().mean() < 0.8
    assert figure.stat().st_size > 10_000


def test_a_clock_that_is_not_seen_is_said_and_the_estimate_is_written(folder: Path) -> None:
    code, said = _estimate(folder, "--truth", str(folder / "angles.csv"))
    assert code == 0, said
    assert "the offset of its clock is not seen" in said
    assert "--truth-offset S says it; no errors against it" in said
    assert not [c for c in pd.read_csv(folder / "table.csv") if c.endswith("_error")]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--truth", "{}/none.csv"), "none.csv does not exist"),
        (("--truth-offset", "1"), "offset of the truth given without a truth"),
        (("--truth", "{}/angles.csv", "--truth-frame", "sideways"), "sideways"),
        (("--truth", "{}/table.csv"), "is the truth itself"),
    ],
)
def test_what_makes_no_sense_is_one_sentence(
    folder: Path, words: tuple[str, ...], said: str
) -> None:
    (folder / "table.csv").touch()
    code, told = _estimate(folder, *(word.format(folder) for word in words))
    assert code == 2, told
    assert said in told
