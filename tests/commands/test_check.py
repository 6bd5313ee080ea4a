"""``pen-mhe check``, and what ``estimate`` makes of its findings."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

import pen_mhe as pm
from commands.cli import app
from recordings.formats.tables import recording_to_table
from recordings.read import read_written

pytestmark = pytest.mark.usefixtures("interpreted")


ROWS = 90
"""Of those that are estimated."""


def called(*words: str) -> Any:
    return CliRunner().invoke(app, words, prog_name="pen-mhe")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording as it should be, and one with a gyroscope of the wrong sign."""
    here = tmp_path_factory.mktemp("recordings")
    sensors = ["accel", "gyro"]
    right = pm.simulate("reference", sensors, motion="handwriting", duration_s=8.0, seed=3)
    table = recording_to_table(right.select(sensors), pm.load_pen("reference"))
    table = table[[column for column in table if not column.startswith("true_")]]
    table.to_csv(here / "right.csv", index=False)
    short = table.head(ROWS).copy()
    short.to_csv(here / "short.csv", index=False)
    stuck = [column for column in table if column.startswith("accel")]
    short.loc[20:, stuck] = short.loc[20, stuck].to_numpy()
    short.to_csv(here / "stuck.csv", index=False)
    flipped = table.copy()
    flipped[[column for column in table if column.startswith("gyro")]] *= -1
    flipped.to_csv(here / "flipped.csv", index=False)
    renamed = {f"gyro_{a}_rad_s": f"w{a}" for a in "xyz"}
    flipped.rename(columns=renamed).to_csv(here / "other.csv", index=False)
    return here


@pytest.mark.parametrize("pen", [(), ("--pen", "reference")])
def test_nothing_is_wrong(folder: Path, pen: tuple[str, ...]) -> None:
    result = called("check", str(folder / "right.csv"), *pen)
    assert result.exit_code == 0, result.output
    assert "accel: 801 readings" in result.stdout
    assert result.stdout.rstrip().splitlines()[-1].startswith("nothing is wrong that shows")


def test_a_flipped_sign_ends_with_one_and_its_remedy_mends_it(folder: Path, tmp_path: Path) -> None:
    found = tmp_path / "found.csv"
    words = ("check", str(folder / "flipped.csv"), "--pen", "reference")
    result = called(*words, "--table", str(found))
    assert result.exit_code == 1
    assert "NOT MEANT, handedness: gyro" in result.stdout
    assert result.stdout.rstrip().endswith("cannot be meant: handedness")
    table = pd.read_csv(found)
    assert table["check"].tolist() == ["handedness"]
    columns = table["remedy"][0].split('"')[1]
    assert columns == "gyro=-gyro_x,-gyro_y,-gyro_z"
    assert called(*words, "--columns", columns).exit_code == 0


def test_the_remedy_has_the_names_of_the_file(folder: Path) -> None:
    columns = "gyro=wx,wy,wz"
    result = called("check", str(folder / "other.csv"), "--columns", columns)
    assert result.exit_code == 1
    assert '--columns "gyro=-wx,-wy,-wz"' in result.stdout
    mended = called("check", str(folder / "other.csv"), "--columns", "gyro=-wx,-wy,-wz")
    assert mended.exit_code == 0


def test_a_minus_turns_a_sign_and_nothing_else(folder: Path) -> None:
    plain = read_written(folder / "flipped.csv", "reference").recording
    turned = read_written(
        folder / "flipped.csv", "reference", columns="gyro=gyro_x,-gyro_y,gyro_z"
    ).recording
    np.testing.assert_array_equal(turned.readings["gyro"], plain.readings["gyro"] * [1, -1, 1])
    np.testing.assert_array_equal(turned.readings["accel"], plain.readings["accel"])
    np.testing.assert_array_equal(turned.time_s, plain.time_s)


def test_estimate_says_it_writes_all_the_same_and_ends_with_one(
    folder: Path, tmp_path: Path
) -> None:
    output = tmp_path / "out.csv"
    words = ("--pen", "reference", "--estimator", "ekf", "--output", str(output), "--no-watch")
    result = called("estimate", str(folder / "stuck.csv"), *words)
    assert result.exit_code == 1
    assert "NOT MEANT, stuck: accel, 0.2 s to 0.89 s" in result.stdout
    assert result.stdout.rstrip().splitlines()[-1] == (
        "trust: this answer cannot be meant (stuck: accel); mend that first"
    )
    assert len(pd.read_csv(output)) == ROWS
    right = called("estimate", str(folder / "short.csv"), *words)
    assert right.exit_code == 0, right.output
    assert right.stdout.rstrip().splitlines()[-1].startswith("trust: ")


def test_a_run_keeps_what_was_found(folder: Path) -> None:
    run = pm.estimate(str(folder / "stuck.csv"), "reference", estimator="ekf", watch=False)
    assert [finding.check for finding in run.findings] == ["stuck"]
    assert not run.summary().trust.is_meant


def test_reading_says_what_is_wrong(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pm.read_recording(folder / "right.csv", "reference")
    assert capsys.readouterr().err == ""
    pm.read_recording(folder / "flipped.csv", "reference")
    assert "its sign is flipped, on all three axes" in capsys.readouterr().err
