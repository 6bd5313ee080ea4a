"""What a run has written and somebody has altered since: refused in a sentence."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from benchmark.runner.about import NAME as RUN
from benchmark.runner.about import read_about
from benchmark.runner.journal import Journal
from benchmark.runner.outcome_lines import NAME, outcome_journal
from benchmark.runner.tables import RESULTS, SERIES, read_tables
from benchmark.tasks.task import Task
from models.errors import InputError
from tests.fuzz.seeds import IDENTITY, OUTCOME, TASK, results_tables


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("samples", "3"), ("samples", 2.5), ("samples", 10**30), ("model", 5), ("reason", None),
        ("solved_fraction", [1]), ("quantities", [["tip"]]), ("quantities", 5),
        ("quantities", [["tip", "mm", "wide", 0, 0, True, None]]),
        ("series", [{"quantity": "tip", "unit": "mm", "time_s": 1, "estimate": 2}]),
        ("series", [{"unit": {"float64": "!"}}]),
    ],
)  # fmt: skip
def test_an_altered_line_of_a_suite(tmp_path: Path, field: str, value: Any) -> None:
    with outcome_journal(tmp_path) as journal:
        journal.append(TASK, IDENTITY, OUTCOME)
    line = json.loads((tmp_path / NAME).read_text())
    (tmp_path / NAME).write_text(json.dumps({**line, field: value}) + "\n")
    with outcome_journal(tmp_path) as journal, pytest.raises(InputError, match="is damaged"):
        journal.read(TASK, IDENTITY)


@pytest.mark.parametrize(
    "line",
    ["[" * 5000, "9" * 5000, "5", "{}", '{"task": 1, "identity": 1, "status": "ok"}', "\x00"],
)
def test_a_line_of_something_else(tmp_path: Path, line: str) -> None:
    (tmp_path / NAME).write_text(line + "\n")
    with pytest.raises(InputError, match="the line at byte 0 is none of a journal"):
        outcome_journal(tmp_path).__enter__()


def test_a_line_without_an_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PEN_MHE_MOST_LINE_BYTES", "100")
    (tmp_path / NAME).write_text("x" * 101)
    with pytest.raises(InputError, match="line at byte 0: 101 bytes of a line of a journal"):
        outcome_journal(tmp_path).__enter__()
    assert (tmp_path / NAME).stat().st_size == 101


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('{"suites": 5}', "key suites: 5, expected list of str"),
        ('{"sessions": ["x"]}', r"key sessions: \['x'\], expected list of dict"),
        ('{"seeds": ' + "9" * 5000 + "}", "a number at byte 10 has 300 digits"),
        ('{"a":' * 500, "500 tables or lists within each other"),
        ("[]", "holds no object, expected the folder of a run"),
    ],
)
def test_an_altered_run(tmp_path: Path, text: str, said: str) -> None:
    (tmp_path / RUN).write_text(text)
    with pytest.raises(InputError, match=said):
        read_about(tmp_path)


@pytest.mark.parametrize(
    ("column", "value", "said"),
    [
        ("rmse", "wide", "column rmse has .*string, expected double"),
        ("seed", None, "column seed has empty cells"),
        ("seed", 0.5, "column seed has double, expected int64"),
        ("suite", [["pen"]], "column suite has list"),
        ("observable", "perhaps", "column observable has .*string, expected bool"),
    ],
)
def test_altered_results(tmp_path: Path, column: str, value: Any, said: str) -> None:
    for name, data in results_tables().items():
        (tmp_path / name).write_bytes(data)
    rows = pd.read_parquet(tmp_path / RESULTS)
    assert len(read_tables(tmp_path).rows) == len(rows)
    rows[column] = value * len(rows) if isinstance(value, list) else value
    rows.to_parquet(tmp_path / RESULTS)
    with pytest.raises(InputError, match=said):
        read_tables(tmp_path)
    (tmp_path / RESULTS).write_bytes(results_tables()[RESULTS])
    (tmp_path / SERIES).write_bytes(b"PAR1" * 10)
    with pytest.raises(InputError, match=r"series\.parquet: cannot be read"):
        read_tables(tmp_path)


def test_a_journal_that_is_a_pipe(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / NAME)
    journal: Journal[Task, Any] = outcome_journal(tmp_path)
    with pytest.raises(InputError, match="is a device, a pipe or a socket"):
        journal.__enter__()
