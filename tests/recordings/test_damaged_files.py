"""Files that once ended in a traceback, or in minutes: each is one sentence now, at once."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from estimation.recording import Recording
from models.errors import InputError, UnforeseenError
from models.pen_file import load_pen
from recordings.formats.dpoint import CAMERA_FILE, STYLUS_FILE
from recordings.formats.imu_array import FILE, read_imu_array
from recordings.formats.tables import read_table
from recordings.plausible_units import check_units
from recordings.read import read_recording

PEN = load_pen("reference")
HEADER = "time_s,accel_x_m_s2,accel_y_m_s2,accel_z_m_s2"
ROWS = [f"{k / 100},0,0,9.81" for k in range(5)]


def refused(call: Callable[[], object], said: str) -> None:
    with pytest.raises(InputError, match=said) as caught:
        call()
    assert not isinstance(caught.value, UnforeseenError)
    assert str(caught.value).isprintable()


@pytest.mark.parametrize(
    ("cell", "said"),
    [
        ("1" * 180, ""),
        ("-" + "9" * 19, ""),
        ("1" * 5000, "line 7 of the file: 5000 bytes of a cell"),
        ("\x1b[31mred", r"row 6: '\\x1b\[31mred' is not a finite number"),
        ("0\x00", "holds a zero byte"),
    ],
)
def test_a_cell(tmp_path: Path, cell: str, said: str) -> None:
    path = tmp_path / "pen.csv"
    path.write_text("\n".join([HEADER, *ROWS, f"0.05,{cell},0,9.81"]))
    if said:
        refused(lambda: read_recording(path, PEN), said)
    else:
        read_recording(path, PEN)


def test_a_whole_number_beyond_a_float(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "pen.csv"
    path.write_text("\n".join([HEADER, *ROWS, f"0.05,{'1' * 400},0,9.81"]))
    monkeypatch.setenv("PEN_MHE_MOST_CELL_BYTES", "500")
    refused(lambda: read_recording(path, PEN), "row 6: '1+…? is not a finite number")


def test_cells_are_measured_across_pieces(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("recordings.formats.cell_limits.PIECE", 7)
    path = tmp_path / "pen.csv"
    path.write_text("\n".join([HEADER, *ROWS, f"0.05,{'1' * 200},0,9.81"]))
    read_recording(path, PEN)
    path.write_text("\n".join([HEADER, *ROWS, f"0.05,{'1' * 201},0,9.81"]))
    refused(lambda: read_recording(path, PEN), "line 7 of the file: 201 bytes of a cell")


def test_columns_take_time_as_they_are_many(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Twice the columns, twice the time, not four times."""
    monkeypatch.setenv("PEN_MHE_MOST_COLUMNS", "100000")

    def seconds(n: int) -> float:
        path = tmp_path / f"{n}.csv"
        path.write_text(",".join(f"c{i}" for i in range(n)) + "\n" + ",".join(["1"] * n) + "\n")
        start = time.process_time()
        assert read_table(path).shape == (1, n)
        return time.process_time() - start

    least = {n: min(seconds(n) for _ in range(3)) for n in (2000, 8000)}  # the rest is not reading
    assert least[8000] < 8 * least[2000] + 0.2


def test_too_many_columns_and_rows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "pen.csv"
    path.write_text(",".join(f"c{i}" for i in range(2001)) + "\n")
    refused(lambda: read_table(path), "2001 columns of a table, expected at most 2000")
    path.write_text(",".join(f"column_{i:0200}" for i in range(3000)))
    refused(lambda: read_table(path), "its first line is longer than 402000 bytes")
    table = pd.DataFrame({"time_s": [0.0, 1.0, 2.0, 3.0], "accel_x_m_s2": 0.0})
    table.to_csv(tmp_path / "long.csv", index=False)
    table.to_parquet(tmp_path / "long.parquet")
    for name, most in (("ROWS", "3"), ("VALUES", "7")):
        monkeypatch.setenv(f"PEN_MHE_MOST_{name}", most)
        for suffix in (".csv", ".parquet"):
            refused(lambda s=suffix: read_table(tmp_path / f"long{s}"), f"expected at most {most}")  # type: ignore[misc]
        monkeypatch.delenv(f"PEN_MHE_MOST_{name}")


@pytest.mark.parametrize(
    "damage", [b"{", b"[]", b'{"index_columns": 5}', b"\xff", b'{"columns": []}']
)
def test_what_pandas_says_in_parquet_may_be_damaged(tmp_path: Path, damage: bytes) -> None:
    path = tmp_path / "pen.parquet"
    names = HEADER.split(",")
    rows = np.array([[float(cell) for cell in row.split(",")] for row in ROWS])
    table = pa.table(dict(zip(names, rows.T, strict=True)), metadata={b"pandas": damage})
    pq.write_table(table, path)
    np.testing.assert_array_equal(read_recording(path, PEN).readings["accel"], rows[:, 1:])


def test_an_index_of_pandas_is_no_column(tmp_path: Path) -> None:
    frame = pd.DataFrame({name: [0.0, 1.0, 9.81] for name in HEADER.split(",")}, index=[7, 8, 9])
    frame.to_parquet(tmp_path / "pen.parquet")
    assert list(read_table(tmp_path / "pen.parquet").columns) == HEADER.split(",")


def test_texts_of_parquet_that_are_none(tmp_path: Path) -> None:
    path = tmp_path / "pen.parquet"
    column = pa.array([b"\xff\xfe"], pa.binary()).view(pa.string())
    pq.write_table(pa.table({"time_s": column, "accel_x_m_s2": column}), path)
    refused(lambda: read_table(path), "cannot be read, expected a parquet table")
    nested = pa.table({"time_s": [[0.0]], "accel_x_m_s2": [{"a": 1}]})
    pq.write_table(nested, path)
    refused(lambda: read_recording(path, PEN), "is not a finite number|missing")


def dpoint(folder: Path, **changes: Any) -> Path:
    """A D-POINT folder whose rows have changed entries."""
    data = {"accel": [0.0, 0.0, 9.8], "gyro": [0.0, 0.0, 0.0], "pressure": 0.0, **changes}
    stylus = [{"t": 8 * k + 5, "data": {"t": 8 * k, **data}} for k in range(3)]
    pose = {"position": [[0.0], [0.0], [0.5]], "orientation_mat": np.eye(3).tolist()}
    (folder / STYLUS_FILE).write_text(json.dumps(stylus))
    (folder / CAMERA_FILE).write_text(json.dumps([{"t": 6, "data": pose}]))
    return folder


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"accel": 1.0}, r"data\.accel has shape \(\), expected \(3,\)"),
        ({"accel": [[1.0], [2.0], [3.0]]}, r"data\.accel has shape \(3, 1\)"),
        ({"gyro": [1.0, [2.0], 3.0]}, r"row 1 has no number under data\.gyro"),
        ({"pressure": [1.0]}, r"data\.pressure has shape \(1,\), expected \(\)"),
        ({"pressure": 10**299}, "a number at byte .* has 300 digits or more"),
        ({"pressure": [[[[[[]]]]]] * 2}, "row 1|shape"),
    ],
)
def test_shapes_of_dpoint(tmp_path: Path, changes: dict[str, Any], said: str) -> None:
    folder = dpoint(tmp_path, **changes)
    refused(lambda: read_recording(folder, "dpoint"), said)


def test_a_deep_file_of_dpoint(tmp_path: Path) -> None:
    folder = dpoint(tmp_path)
    (folder / STYLUS_FILE).write_text("[" * 10**5)
    refused(lambda: read_recording(folder, "dpoint"), "100000 tables or lists within each other")


def test_an_archive_of_arrays(tmp_path: Path) -> None:
    counts = np.zeros((4, 2, 3), dtype=np.int16)
    arrays: dict[str, Any] = {
        "t": np.arange(4.0),
        "acc": counts,
        "gyr": counts,
        "pos_m": np.zeros((2, 3)),
    }
    path = tmp_path / FILE
    np.savez(path, **arrays)
    read_imu_array(tmp_path)
    np.savez(path, **{**arrays, "acc": np.array([{}, 1], dtype=object)})
    refused(lambda: read_imu_array(tmp_path), "key acc: its header does not fit")
    np.savez(path, **{**arrays, "acc": counts.astype(str)})
    refused(lambda: read_imu_array(tmp_path), "key acc has <U.*, expected numbers")
    data = path.read_bytes()
    for end in (0, 10, len(data) // 2, len(data) - 4):
        path.write_bytes(data[:end])
        refused(lambda: read_imu_array(tmp_path), "is no archive of arrays")


def test_one_sample_in_a_window_of_units() -> None:
    """Times so large that a second is nothing to them."""
    time_s = 1e17 + 64.0 * np.arange(20)
    readings = {"accel": np.tile([0.0, 0.0, 9.81], (20, 1)), "gyro": np.full((20, 3), 0.1)}
    check_units(Recording("r", time_s, readings), PEN)
