"""The tables: columns, types, order; what has no figures; what is no table."""

from __future__ import annotations

import math
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from benchmark.runner import tables
from benchmark.runner.tables import RESULTS, SERIES, read_tables, write_tables
from benchmark.tasks.results import RESULT_COLUMNS, SERIES_COLUMNS
from benchmark.tasks.task import FAILED, Outcome, Quantity, Series, Task, failed
from models.errors import InputError

TIME_S = np.array([0.0, 0.5, 1.0])
GOOD = Outcome(
    "a model",
    (
        Quantity("tip", "mm", 1.5, -0.5, 2.5, True, 0.5),
        Quantity("settling", "s", math.inf, math.inf, math.inf, False),
    ),
    3,
    0.75,
    1e-3,
    2e-3,
    "mirror",
    "in the mirror",
    (
        Series("tip", "mm", TIME_S, TIME_S + 1, TIME_S + 2, TIME_S + 3),
        Series("rates", "deg/s", TIME_S, -TIME_S),
    ),
)
OUTCOMES = {
    Task("pen", "b", "accel", "ekf", 1): GOOD,
    Task("pen", "a", "accel", "ekf", 0): failed("KeyError: 'what'"),
}


def test_both_tables_say_with_which_version_they_were_written(tmp_path: Path) -> None:
    write_tables(OUTCOMES, OUTCOMES.__getitem__, tmp_path)
    for name in (RESULTS, SERIES):
        metadata = pq.read_schema(tmp_path / name).metadata
        assert metadata[b"pen_mhe_version"] == version("pen-mhe").encode()


def test_a_row_per_quantity_in_the_order_of_the_tasks(tmp_path: Path) -> None:
    write_tables(OUTCOMES, OUTCOMES.__getitem__, tmp_path)
    rows = read_tables(tmp_path).rows
    assert tuple(rows.columns) == RESULT_COLUMNS
    assert list(rows["case"]) == ["b", "b", "a"]
    assert list(rows["quantity"]) == ["tip", "settling", ""]
    tip = rows.iloc[0].to_dict()
    assert tip == {
        "suite": "pen", "case": "b", "model": "a model", "sensors": "accel", "estimator": "ekf",
        "seed": 1, "quantity": "tip", "unit": "mm", "rmse": 1.5, "bias": -0.5, "max_error": 2.5,
        "observable": True, "claimed": 0.5, "samples": 3, "solved_fraction": 0.75,
        "step_time_median_s": 1e-3, "step_time_p99_s": 2e-3, "status": "mirror",
        "reason": "in the mirror",
    }  # fmt: skip
    assert rows.iloc[1]["rmse"] == math.inf
    assert not rows.iloc[1]["observable"]
    assert np.isnan(rows.iloc[1]["claimed"])  # claims none


def test_a_failed_task_is_a_row_with_its_reason(tmp_path: Path) -> None:
    write_tables(OUTCOMES, OUTCOMES.__getitem__, tmp_path)
    row = read_tables(tmp_path).rows.iloc[2]
    assert (row["status"], row["reason"], row["samples"]) == (FAILED, "KeyError: 'what'", 0)
    assert np.isnan([row["rmse"], row["bias"], row["max_error"], row["step_time_p99_s"]]).all()
    assert (row["solved_fraction"], row["observable"]) == (0.0, False)


def test_types_are_the_same_whatever_the_rows_say(tmp_path: Path) -> None:
    schemas = []
    for name, outcomes in (("some", OUTCOMES), ("none", {})):
        (tmp_path / name).mkdir()
        write_tables(outcomes, outcomes.__getitem__, tmp_path / name)
        schemas.append(tuple(pq.read_schema(tmp_path / name / file) for file in (RESULTS, SERIES)))
        assert not list((tmp_path / name).glob("*.part"))
    assert schemas[0] == schemas[1]
    of = {field.name: field.type for schema in schemas[0] for field in schema}
    assert {name for name in of if of[name] == pa.int64()} == {"seed", "samples"}
    assert {name for name in of if of[name] == pa.bool_()} == {"observable"}
    assert {name for name in of if of[name] == pa.string()} == {
        *("suite", "case", "model", "sensors", "estimator"),
        *("quantity", "unit", "status", "reason"),
    }


def test_a_series_has_nan_where_there_is_none(tmp_path: Path) -> None:
    write_tables(OUTCOMES, OUTCOMES.__getitem__, tmp_path)
    series = read_tables(tmp_path).series
    assert tuple(series.columns) == SERIES_COLUMNS
    tip, rates = series[series["quantity"] == "tip"], series[series["quantity"] == "rates"]
    assert np.array_equal(
        tip[["time_s", "estimate", "std", "truth"]],
        np.column_stack([TIME_S, TIME_S + 1, TIME_S + 2, TIME_S + 3]),
    )
    assert np.array_equal(rates["estimate"], -TIME_S)
    assert rates[["std", "truth"]].isna().all(axis=None)
    assert set(series["seed"]) == {1}


def test_more_tasks_than_are_written_at_a_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tables, "TASKS_AT_A_TIME", 3)
    some = [Task("pen", "b", "accel", "ekf", seed) for seed in range(8)]

    def read(task: Task) -> Outcome:
        return Outcome("", (Quantity.single("seed", "", task.seed),), 1, 1.0, 0.0, 0.0)

    write_tables(iter(some), read, tmp_path)
    assert list(read_tables(tmp_path).rows["bias"]) == list(range(8))
    assert pq.ParquetFile(tmp_path / RESULTS).num_row_groups == 3


def test_a_table_that_breaks_off_leaves_the_old_one(tmp_path: Path) -> None:
    write_tables(OUTCOMES, OUTCOMES.__getitem__, tmp_path)
    before = (tmp_path / RESULTS).read_bytes()
    with pytest.raises(KeyError):
        write_tables([*OUTCOMES, Task("pen", "c", "", "", 0)], OUTCOMES.__getitem__, tmp_path)
    assert (tmp_path / RESULTS).read_bytes() == before


def test_what_is_no_table_gets_a_sentence(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"results\.parquet does not exist, expected the folder"):
        read_tables(tmp_path)
    write_tables(OUTCOMES, OUTCOMES.__getitem__, tmp_path)
    (tmp_path / SERIES).unlink()
    with pytest.raises(InputError, match=r"series\.parquet does not exist, expected the folder"):
        read_tables(tmp_path)
    (tmp_path / SERIES).write_text("time_s,estimate\n")
    with pytest.raises(InputError, match=r"series\.parquet: .*, expected a Parquet file") as found:
        read_tables(tmp_path)
    assert "\n" not in str(found.value)
    pd.DataFrame({"suite": ["pen"]}).to_parquet(tmp_path / SERIES)
    with pytest.raises(InputError, match=r"series\.parquet has no column case, expected suite, "):
        read_tables(tmp_path)


def test_tables_of_two_runs_are_not_read_together(tmp_path: Path) -> None:
    """As a kill between putting the one and the other in place leaves them."""
    for name, tasks in (("one", OUTCOMES), ("other", {})):
        (tmp_path / name).mkdir()
        write_tables(tasks, OUTCOMES.get, tmp_path / name)  # type: ignore[arg-type]
    (tmp_path / "one" / SERIES).replace(tmp_path / "other" / SERIES)
    with pytest.raises(InputError, match="other: tables of two runs, expected"):
        read_tables(tmp_path / "other")
