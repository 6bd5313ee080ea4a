"""A table that is read in parts is the table that is read whole, and is refused as that is."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from estimation.recording import Recording
from estimation.recording_parts import joined
from models.errors import InputError
from models.pen_config import PenConfig
from models.pen_file import load_pen
from recordings.formats.table_stream import table_stream
from recordings.formats.table_writer import TableWriter
from recordings.formats.tables import load_table, read_table, write_table
from recordings.read import read_recording
from recordings.recording_check import RecordingCheck, UnitCheck
from tests.recordings.swings import swinging

PEN = load_pen("reference")
SUFFIXES = (".csv", ".parquet")


@pytest.fixture(autouse=True)
def small_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("recordings.formats.table_stream.PART_ROWS", 4)


def table(rows: int = 11) -> pd.DataFrame:
    time_s = np.arange(rows) / 100
    accel = {f"accel_{axis}_m_s2": np.sqrt(time_s + 40 * i) for i, axis in enumerate("xyz")}
    camera = {f"camera_{axis}_mm": [1.0, *[np.nan] * (rows - 1)] for axis in "xyz"}
    turned = {f"camera_r{axis}_deg": [1.0, *[np.nan] * (rows - 1)] for axis in "xyz"}
    return pd.DataFrame({"time_s": time_s, **accel, **camera, **turned, "true_tip_x_m": time_s})


def parts_of(path: Path, pen: PenConfig = PEN) -> list[Recording]:
    """Read a table in parts, and check it as a whole."""
    with table_stream(path, pen) as stream:
        check, parts = RecordingCheck(stream.header, pen), []
        for part in stream.parts():
            check.take(part)
            parts.append(part)
        check.end()
        again = list(stream.parts())
    assert [len(part.time_s) for part in again] == [len(part.time_s) for part in parts]
    return parts


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_parts_are_the_whole(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"pen{suffix}"
    write_table(table(), path)
    parts, whole = parts_of(path), read_recording(path, PEN)
    assert [len(part.time_s) for part in parts] == [4, 4, 3]
    one = joined(parts)
    np.testing.assert_array_equal(one.time_s, whole.time_s)
    assert set(one.readings) == set(whole.readings)
    for sensor, readings in one.readings.items():
        np.testing.assert_array_equal(readings, whole.readings[sensor])
    truths = [part.truth.values for part in parts if part.truth is not None]
    assert whole.truth is not None
    np.testing.assert_array_equal(np.concatenate(truths), whole.truth.values)


def changed(row: int, column: str, value: object) -> Callable[[], pd.DataFrame]:
    def change() -> pd.DataFrame:
        found = table().astype(object)
        found.loc[row, column] = value
        return found

    return change


def in_g() -> pd.DataFrame:
    return table().rename(columns=lambda name: name.replace("m_s2", "g"))


def silent() -> pd.DataFrame:
    """A tip that touched nothing."""
    return table().assign(contact_z_m=np.nan, contact_arrival_s=np.nan)


BAD: dict[str, Callable[[], pd.DataFrame]] = {
    "text in row 10": changed(9, "accel_y_m_s2", "warm"),
    "time repeated across parts": changed(4, "time_s", 0.03),
    "time back within a part": changed(6, "time_s", 0.01),
    "no time": changed(8, "time_s", None),
    "a number beyond SI": lambda: in_g().replace({"accel_y_g": {in_g()["accel_y_g"][9]: 1e308}}),
    "unknown column": lambda: table().assign(accel_w=1.0),
    "an empty sensor": lambda: table().assign(camera_x_mm=np.nan).filter(regex="^(?!camera_[yzr])"),
    "two units": lambda: table().assign(accel_x_g=1.0),
    "an axis that is missing": lambda: table().drop(columns="accel_y_m_s2"),
    "no rows": lambda: table().iloc[:0],
    "one row": lambda: table().iloc[:1],
    "times in another unit": lambda: table().assign(time_s=lambda rows: 1e3 * rows["time_s"]),
    "all silent": lambda: table()[["time_s"]].assign(contact_z_m=np.nan),
    "text where it is silent": lambda: silent().assign(contact_z_m=[*[None] * 10, "no"]),
    "in another unit": lambda: table().assign(accel_x_m_s2=0, accel_y_m_s2=0, accel_z_m_s2=1.0),
}


@pytest.mark.parametrize("fault", BAD)
def test_what_is_refused_whole_is_refused_in_parts(tmp_path: Path, fault: str) -> None:
    """In the same words, which name the file and the row."""
    path = tmp_path / "pen.csv"
    BAD[fault]().to_csv(path, index=False)
    with pytest.raises(InputError) as whole:
        load_table(path, PEN)
    with pytest.raises(InputError) as in_parts:
        parts_of(path)
    assert str(in_parts.value) == str(whole.value)


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("readings", [0, 1])
def test_a_sensor_that_may_be_silent(tmp_path: Path, suffix: str, readings: int) -> None:
    """It is left out where it was, whole and in parts, and not where its last row has a reading."""
    path, heights = tmp_path / f"pen{suffix}", [*[np.nan] * (11 - readings), *[0.0] * readings]
    arrivals = [*[np.nan] * (11 - readings), *[1.0] * readings]
    write_table(silent().assign(contact_z_m=heights, contact_arrival_s=arrivals), path)
    whole, parts = load_table(path, PEN), parts_of(path)
    with table_stream(path, PEN) as stream:
        assert stream.notes == whole.notes
    assert whole.notes == (() if readings else ("contact has no reading, left out",))
    assert ("contact" in whole.recording.readings) == bool(readings)
    one = joined(parts)
    assert set(one.readings) == set(whole.recording.readings)
    assert set(one.arrivals) == set(whole.recording.arrivals)


def test_a_ragged_row_is_named_by_its_line(tmp_path: Path) -> None:
    path = tmp_path / "pen.csv"
    table().to_csv(path, index=False)
    lines = path.read_text().splitlines()
    lines[9] += ",5"
    path.write_text("\n".join(lines))
    with pytest.raises(InputError, match="line 10 of the file has 12 cells, expected 11"):
        parts_of(path)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_rows_in_parts_have_no_limit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, suffix: str
) -> None:
    path = tmp_path / f"pen{suffix}"
    write_table(table(), path)
    for limit in ("ROWS", "VALUES", "TABLE_BYTES"):
        monkeypatch.setenv(f"PEN_MHE_MOST_{limit}", "10")
    with pytest.raises(InputError, match="expected at most 10"):
        read_recording(path, PEN)
    assert len(parts_of(path)) == 3


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_parts_are_written_as_the_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, suffix: str
) -> None:
    monkeypatch.setattr("recordings.formats.table_writer.GROUP_ROWS", 6)
    whole, in_parts = tmp_path / f"whole{suffix}", tmp_path / f"parts{suffix}"
    write_table(table(), whole)
    with in_parts.open("wb") as file, TableWriter(file, suffix) as writer:
        for start in range(0, 11, 4):
            writer.write(table().iloc[start : start + 4])
    pd.testing.assert_frame_equal(read_table(in_parts), read_table(whole), check_exact=True)
    if suffix == ".csv":
        assert in_parts.read_bytes() == whole.read_bytes()


def test_units_are_voted_on(monkeypatch: pytest.MonkeyPatch) -> None:
    """A block alone may mislead; most of a recording does not."""
    monkeypatch.setattr("recordings.recording_check.BLOCK_ROWS", 300)
    time_s, rate, up = swinging(0)
    right = Recording("right", time_s, {"accel": 9.81 * up, "gyro": rate})
    wrong = Recording("wrong", time_s, {"accel": up, "gyro": rate})
    check = UnitCheck(PEN, {"accel": "m_s2", "gyro": "rad_s"})
    for part in (right, wrong, right):
        check.take(part)
    check.end()
    for _ in range(2):
        check.take(wrong)
    with pytest.raises(InputError, match="accel was read in m_s2 but looks like g"):
        check.end()
