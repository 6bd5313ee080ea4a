"""From the journal to ``results.parquet`` and ``series.parquet``, a few tasks at a time."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack
from dataclasses import asdict
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from benchmark.tasks.results import RESULT_COLUMNS, SERIES_COLUMNS, TASK_COLUMNS, Results
from benchmark.tasks.task import Outcome, Quantity, Task
from estimation.output_file import whole_files
from models.errors import InputError
from models.version import version_metadata
from recordings.formats.arrow import read_arrow, with_types

RESULTS, SERIES = "results.parquet", "series.parquet"
TASKS_AT_A_TIME = 500
PAIR = b"written_together"
"""Metadata that both tables have: a kill between the two leaves one of an earlier run."""

_WORDS = ("suite", "case", "model", "sensors", "estimator", "quantity", "unit", "status", "reason")
_TYPES: dict[str, pa.DataType] = {
    **dict.fromkeys(_WORDS, pa.string()),
    **dict.fromkeys(("seed", "samples"), pa.int64()),
    "observable": pa.bool_(),
}
"""Column → type; any other one is a float."""

NO_QUANTITY = Quantity("", "", np.nan, np.nan, np.nan, False)
"""Stands in the row of a task that has no figures."""


def write_tables(tasks: Iterable[Task], read: Callable[[Task], Outcome], folder: Path) -> None:
    """Write both tables, in the order of the tasks; whole files appear, or none.

    Parameters
    ----------
    read : a task's outcome
    """
    paths = {RESULTS: RESULT_COLUMNS, SERIES: SERIES_COLUMNS}
    with whole_files([folder / name for name in paths]) as files, ExitStack() as stack:
        writers = {
            name: stack.enter_context(pq.ParquetWriter(file, _schema(columns)))
            for file, (name, columns) in zip(files, paths.items(), strict=True)
        }
        waiting, said = iter(tasks), hashlib.sha256()
        while some := [(task, read(task)) for task in islice(waiting, TASKS_AT_A_TIME)]:
            rows = [row for task, outcome in some for row in result_rows(task, outcome)]
            said.update(repr(rows).encode())
            writers[RESULTS].write_table(pa.Table.from_pylist(rows, _schema(RESULT_COLUMNS)))
            for task, outcome in some:
                for table in _series_tables(task, outcome):
                    writers[SERIES].write_table(table)
        for writer in writers.values():
            writer.add_key_value_metadata({PAIR: said.hexdigest()})


def result_rows(task: Task, outcome: Outcome) -> Iterator[dict[str, Any]]:
    """Yield a task's rows: one per quantity, one without figures where it has none."""
    for quantity in outcome.quantities or (NO_QUANTITY,):
        yield {
            **asdict(task),
            "model": outcome.model,
            "quantity": quantity.name,
            **{name: value for name, value in asdict(quantity).items() if name != "name"},
            "samples": outcome.samples,
            "solved_fraction": outcome.solved_fraction,
            "step_time_median_s": outcome.step_time_median_s,
            "step_time_p99_s": outcome.step_time_p99_s,
            "status": outcome.status,
            "reason": outcome.reason,
        }


def _series_tables(task: Task, outcome: Outcome) -> Iterator[pa.Table]:
    for series in outcome.series:
        n = len(series.time_s)
        one = {**asdict(task), "quantity": series.quantity, "unit": series.unit}
        missing = np.full(n, np.nan)
        columns: dict[str, Any] = {name: [value] * n for name, value in one.items()}
        columns |= {"time_s": series.time_s, "estimate": series.estimate}
        columns["std"] = missing if series.std is None else series.std
        columns["truth"] = missing if series.truth is None else series.truth
        yield pa.table(columns, _schema(SERIES_COLUMNS))


def _schema(columns: Iterable[str]) -> pa.Schema:
    fields = [(name, _TYPES.get(name, pa.float64())) for name in columns]
    return pa.schema(fields, metadata=version_metadata())


def read_tables(folder: Path) -> Results:
    """Read what `write_tables` wrote.

    Raises
    ------
    InputError
        If a file is missing, lacks a column or is of another run; the message names it.
    """
    tables, pair = [], set()
    for name, columns in ((RESULTS, RESULT_COLUMNS), (SERIES, SERIES_COLUMNS)):
        path = folder / name
        if not path.is_file():
            raise InputError(
                f"{path} does not exist, expected the folder of a finished `pen-mhe benchmark`"
            )
        arrow = read_arrow(path, str(path), "a Parquet file of a run")
        pair.add((pq.read_metadata(path).metadata or {}).get(PAIR))
        table = with_types(arrow, _schema(columns), str(path), filled=TASK_COLUMNS).to_pandas()
        # Few words many times: to choose rows by is ten times as fast so.
        tables.append(table.astype(dict.fromkeys(set(_WORDS) & set(columns), "category")))
    if len(pair) > 1:
        raise InputError(f"{folder}: tables of two runs, expected `pen-mhe benchmark` again")
    return Results(*tables)
