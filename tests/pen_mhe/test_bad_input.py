"""A bad recording gets one sentence: the file, the column or row, what was expected."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow
import pyarrow.parquet
import pytest

from recordings.read import read_written
from tests.pen_mhe.bad_input import (
    ACCEL,
    GYRO,
    Case,
    cell,
    check_sentence,
    csv,
    estimate,
    longer,
    parquet,
    table,
    text,
)

pytestmark = pytest.mark.usefixtures("interpreted")
QUICK = ("--estimator", "ekf")
STRICT = ("--strict",)
NOT_FINITE = "is not a finite number, expected one"


def doubled_parquet(folder: Path) -> Path:
    names = ["time_s", *ACCEL, ACCEL[0]]
    written = pyarrow.table([table()[name].to_numpy() for name in names], names=names)
    pyarrow.parquet.write_table(written, folder / "pen.parquet")
    return folder / "pen.parquet"


FILES = {
    "missing recording": Case(
        (
            "pen.csv does not exist",
            "expected a folder of tables, a D-POINT folder, .txt or .tsv, .json, .csv, .parquet",
        ),
        lambda folder: folder / "pen.csv",
    ),
    "unknown suffix": Case(
        ("pen.doc: suffix .doc is unknown", "expected .txt or .tsv, .json, .csv, .parquet"),
        text(lambda rows: rows, "pen.doc"),
    ),
    "no workbook": Case(
        ("pen.xls: cannot be read", "expected an Excel workbook"),
        text(lambda rows: rows, "pen.xls"),
    ),
    "zero bytes": Case(
        ("pen.csv is empty (zero bytes)", "expected a header and samples"), text(lambda _: "")
    ),
    "zero bytes, Parquet": Case(
        ("pen.parquet is empty (zero bytes)", "expected a header and samples"),
        text(lambda _: "", "pen.parquet"),
    ),
    "header only": Case(
        ("pen.csv is empty below its header", "expected at least one sample"),
        csv(lambda rows: rows.iloc[:0]),
    ),
    "single sample": Case(
        ("pen.csv has a single sample", "expected at least two"), csv(lambda rows: rows.iloc[:1])
    ),
    "no Parquet": Case(
        ("pen.parquet: cannot be read", "expected a parquet table"),
        text(lambda _: "no", "pen.parquet"),
    ),
    "a single column": Case(
        ("pen.csv: a single column, expected several", "commas"),
        csv(lambda rows: rows[[ACCEL[0]]]),
    ),
    "one row too long": Case(
        ("pen.csv: line 5 of the file has 39 cells, expected 38",), longer(4, 4), options=STRICT
    ),
    "all rows too long": Case(
        ("pen.csv: row 1 has more cells than the header, expected as many",), longer(1, 10**6)
    ),
}

COLUMNS = {
    "unknown unit in a header": Case(
        ("unknown column accel_x_furlong", "expected accel_x_m_s2 or accel_x_g or accel_x_mg"),
        csv(lambda rows: rows.rename(columns={ACCEL[0]: "accel_x_furlong"})),
    ),
    "missing axis": Case(
        ("pen.csv: column accel_y is missing", "expected every axis of accel"),
        csv(lambda rows: rows.drop(columns=ACCEL[1])),
    ),
    "no time": Case(
        ("pen.csv: expected exactly one column of time_s, time_ms, time_us", "found none"),
        csv(lambda rows: rows.drop(columns="time_s")),
    ),
    "two times": Case(
        ("pen.csv: columns time_s and time_ms both give time", "expected one"),
        csv(lambda rows: rows.assign(time_ms=rows["time_s"] * 1e3)),
    ),
    "a reading in two units": Case(
        ("pen.csv: columns accel_x_m_s2 and accel_x_g both give accel_x", "expected one"),
        csv(lambda rows: rows.assign(accel_x_g=1.0)),
    ),
    "a column twice": Case(
        ("pen.csv: column accel_x_m_s2 appears twice", "expected it once"),
        text(lambda rows: rows.replace(ACCEL[1], ACCEL[0])),
    ),
    "a column twice, Parquet": Case(
        ("pen.parquet: column accel_x_m_s2 appears twice", "expected it once"), doubled_parquet
    ),
    "no sensor": Case(
        ("pen.csv: no sensor's columns", "expected time_s, accel_x_m_s2"),
        csv(lambda rows: rows[["time_s", "true_tip_x_m"]]),
    ),
    "a sensor without a reading": Case(
        ("pen.csv: the columns of gyro are empty", "expected a reading or no such columns"),
        csv(lambda rows: rows.assign(**dict.fromkeys(GYRO, np.nan))),
    ),
    "misspelt truth": Case(
        ("pen.csv: unknown column true_tipx_m", "expected one of true_tip_x_m, true_tip_y_m",
         "true_attitude_z, true_accel_bias_x_m_s2"),
        csv(lambda rows: rows.rename(columns={"true_tip_x_m": "true_tipx_m"})),
    ),
    "truth in two units": Case(
        ("pen.csv: columns true_tip_x_m and true_tip_x_mm both give true_tip_x_m",),
        csv(lambda rows: rows.assign(true_tip_x_mm=1.0)),
    ),
}  # fmt: skip

CELLS = {
    "NaN": Case(("pen.csv: column accel_y_m_s2, row 3: 'NaN'", NOT_FINITE, "has an empty cell"),
                cell(3, ACCEL[1], "NaN"), options=STRICT),
    "nan": Case(("pen.csv: column gyro_x_rad_s, row 1: 'nan'", NOT_FINITE),
                cell(1, GYRO[0], "nan"), options=STRICT),
    "infinite": Case(("pen.csv: column gyro_z_rad_s, row 300: '-inf'", NOT_FINITE),
                     cell(300, GYRO[2], "-inf")),
    "a word": Case(("pen.csv: column accel_x_m_s2, row 2: 'much'", NOT_FINITE),
                   cell(2, ACCEL[0], "much")),
    "NaN in the truth": Case(("pen.csv: column true_tip_x_m, row 2: 'nan'", NOT_FINITE),
                             cell(2, "true_tip_x_m", "nan"), options=STRICT),
    "NaN as time": Case(("pen.csv: column time_s, row 4: 'nan'", NOT_FINITE),
                        cell(4, "time_s", "nan"), options=STRICT),
    "infinite time": Case(("pen.csv: column time_s, row 4: 'inf'", NOT_FINITE),
                          cell(4, "time_s", "inf"), options=STRICT),
    "empty time": Case(("pen.csv: column time_s is empty in row 4", "expected a time"),
                       cell(4, "time_s", ""), options=STRICT),
    "repeated time": Case(
        ("pen.csv: column time_s: time of row 4 (0.02 s) does not follow the one before (0.02 s)",
         "expected increasing times"), cell(4, "time_s", "0.02"), options=STRICT),
    "backward time": Case(
        ("pen.csv: column time_s: time of row 4 (0.01 s) does not follow the one before (0.02 s)",
         "expected increasing times"), cell(4, "time_s", "0.01"), options=STRICT),
    "infinite, Parquet": Case(
        ("pen.parquet: column accel_x_m_s2, row 1: 'inf'", NOT_FINITE),
        parquet(lambda rows: rows.assign(accel_x_m_s2=np.inf))),
    "a date, Parquet": Case(
        ("pen.parquet: column time_s holds datetime64", "expected numbers"),
        parquet(lambda rows: rows.assign(time_s=pd.to_datetime(rows["time_s"], unit="s"))),
        options=STRICT),
}  # fmt: skip

CASES = {
    f"{group}: {name}": case
    for group, cases in (("file", FILES), ("columns", COLUMNS), ("cell", CELLS))
    for name, case in cases.items()
}


@pytest.mark.parametrize("name", CASES)
def test_one_sentence_for_a_bad_recording(name: str, tmp_path: Path) -> None:
    check_sentence(CASES[name], tmp_path)


def test_the_recording_of_the_cases_is_good(tmp_path: Path) -> None:
    result = estimate(Case((), options=QUICK), tmp_path)
    assert result.exit_code == 0, result.stderr


READ = {
    "semicolons": ("cells separated by semicolons", text(lambda rows: rows.replace(",", ";"))),
    "unknown column": ("not needed, ignored: speed", csv(lambda rows: rows.assign(speed=1.0))),
    "a column without a name": (
        "not needed, ignored: column 1",
        text(lambda _: table().to_csv()),
    ),
    "a cell that says so": ("accel: 1 of 601 rows without", cell(3, ACCEL[1], "NaN")),
    "no time": ("repaired: pen.csv: 1 row without a time left out", cell(4, "time_s", "nan")),
    "repeated time": ("repaired: pen.csv: 1 equal stamps", cell(4, "time_s", "0.02")),
    "a row too long": ("repaired: pen.csv: 1 line left out, no row of 38 cells", longer(4, 4)),
}


@pytest.mark.parametrize("name", READ)
def test_what_is_read_and_said(name: str, tmp_path: Path) -> None:
    said, writer = READ[name]
    assert said in "\n".join(read_written(writer(tmp_path), "reference").sentences())


def test_an_empty_cell_is_no_mistake(tmp_path: Path) -> None:
    """A partial reading: some axes of a sensor in a row."""
    result = estimate(Case((), cell(3, ACCEL[1], ""), options=QUICK), tmp_path)
    assert result.exit_code == 0, result.stderr
