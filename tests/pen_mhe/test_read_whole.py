"""What ``pen-mhe estimate`` cannot read in parts it reads whole, and says what it made of it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest

from models.errors import InputError
from models.pen_file import load_pen
from pen_mhe.estimate_file import estimate_file
from pen_mhe.estimate_run import estimate_recording
from recordings.formats.tables import read_table, recording_to_table, write_table
from recordings.read import in_parts, read_written
from recordings.simulate_pen import simulate
from recordings.unfit import UnfitTableError

pytestmark = pytest.mark.usefixtures("interpreted")
PEN = load_pen("reference")


@pytest.fixture(autouse=True)
def small_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("recordings.formats.table_stream.PART_ROWS", 16)


@pytest.fixture(scope="module")
def recorded() -> pd.DataFrame:
    recording = simulate(PEN, ("accel", "gyro"), motion="handwriting", duration_s=0.3)
    return recording_to_table(recording, PEN)


def of_a_logger(table: pd.DataFrame) -> pd.DataFrame:
    names = {f"accel_{axis}_m_s2": f"a{axis} [m/s²]" for axis in "xyz"}
    names |= {f"gyro_{axis}_rad_s": f"g{axis} [rad/s]" for axis in "xyz"}
    table = table[["time_s", *names]].dropna()
    return table.rename(columns={**names, "time_s": "Time (s)"}).assign(battery=80)


def with_a_stamp_twice(table: pd.DataFrame) -> pd.DataFrame:
    found = table.copy()
    found.loc[20, "time_s"] = found.loc[19, "time_s"]
    return found


def silent(table: pd.DataFrame) -> pd.DataFrame:
    return table.assign(contact_z_m=None)


CASES: dict[str, tuple[Callable[[pd.DataFrame], pd.DataFrame], bool, str]] = {
    "of a logger": (of_a_logger, False, "battery"),
    "a stamp twice": (with_a_stamp_twice, True, "repaired: "),
    "a silent contact": (silent, True, "contact has no reading, left out"),
}
"""What is done to a table → that, whether it is opened in parts, and what is said of it."""


@pytest.mark.parametrize("case", CASES)
def test_it_is_the_run_of_the_whole(tmp_path: Path, recorded: pd.DataFrame, case: str) -> None:
    change, is_opened, said = CASES[case]
    path, output = tmp_path / "pen.csv", tmp_path / "estimate.csv"
    change(recorded).to_csv(path, index=False)
    assert (in_parts(path, PEN) is not None) == is_opened
    summary = estimate_file(path, PEN, output, estimator="ekf")
    whole = estimate_recording(read_written(path, PEN), PEN, estimator="ekf")
    expected = tmp_path / "whole.csv"
    write_table(whole.to_pandas(), expected)
    found, table = (read_table(each).drop(columns="step_time_s") for each in (output, expected))
    pd.testing.assert_frame_equal(found, table, check_exact=True)
    assert any(said in note for note in summary.notes)
    assert summary.notes == whole.notes
    sentences = summary.sentences()
    assert tuple(sentences[: len(summary.notes)]) == summary.notes


def test_strict_mends_nothing(tmp_path: Path, recorded: pd.DataFrame) -> None:
    path, output = tmp_path / "pen.csv", tmp_path / "estimate.csv"
    with_a_stamp_twice(recorded).to_csv(path, index=False)
    with pytest.raises(UnfitTableError, match=r"row 21 .* does not follow the one before"):
        estimate_file(path, PEN, output, estimator="ekf", strict=True)
    assert not output.exists()


def test_what_cannot_be_mended_is_refused_as_it_stands(
    tmp_path: Path, recorded: pd.DataFrame
) -> None:
    path, table = tmp_path / "pen.csv", recorded.astype(object)
    table.loc[20, "gyro_y_rad_s"] = "warm"
    table.to_csv(path, index=False)
    with pytest.raises(InputError, match="gyro_y_rad_s, row 21: 'warm' is not a finite number"):
        estimate_file(path, PEN, tmp_path / "estimate.csv", estimator="ekf")


def test_columns_asked_for_are_read_whole(tmp_path: Path, recorded: pd.DataFrame) -> None:
    path, output = tmp_path / "pen.csv", tmp_path / "estimate.csv"
    names = ["accel_x_m_s2", "accel_y_m_s2", "accel_z_m_s2"]
    swapped = {name: f"own {k}" for k, name in enumerate(names)}
    recorded.rename(columns=swapped).to_csv(path, index=False)
    columns = {"accel": tuple(swapped.values())}
    assert in_parts(path, PEN, columns=columns) is None
    summary = estimate_file(
        path, PEN, output, estimator="ekf", columns=columns, units={"accel": "m_s2"}
    )
    assert summary.samples == len(read_table(output))
    assert any(note.startswith("accel from own 0, own 1, own 2") for note in summary.notes)


def test_a_table_that_pandas_numbered_is_read_in_parts(
    tmp_path: Path, recorded: pd.DataFrame
) -> None:
    recorded.set_index(recorded.index[::-1]).to_parquet(tmp_path / "pen.parquet")
    assert in_parts(tmp_path / "pen.parquet", PEN) is not None
