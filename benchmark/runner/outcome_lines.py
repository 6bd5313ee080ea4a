"""A suite's finished task as a line of its journal, every figure to the last bit."""

from __future__ import annotations

import base64
import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from benchmark.runner.journal import Journal, LineFormat
from benchmark.tasks.task import FAILED, Outcome, Quantity, Series, Task
from models.known_types import checked_fields

NAME = "journal.jsonl"


def outcome_journal(folder: Path) -> Journal[Task, Outcome]:
    """Return the journal of the suites in a folder."""
    return Journal(folder / NAME, OUTCOME_LINES)


def _encoded(task: Task, outcome: Outcome) -> dict[str, Any]:
    fields = {f.name: getattr(outcome, f.name) for f in dataclasses.fields(outcome)}
    fields["quantities"] = [dataclasses.astuple(quantity) for quantity in outcome.quantities]
    fields["series"] = [
        {f.name: _packed(getattr(series, f.name)) for f in dataclasses.fields(series)}
        for series in outcome.series
    ]
    return {"task": dataclasses.asdict(task), **fields}


def _decoded(line: Mapping[str, Any]) -> Outcome:
    fields = {f.name: line[f.name] for f in dataclasses.fields(Outcome)}
    fields["quantities"] = tuple(checked_fields(Quantity(*values)) for values in line["quantities"])
    fields["series"] = tuple(
        checked_fields(Series(**{name: _unpacked(value) for name, value in series.items()}))
        for series in line["series"]
    )
    return checked_fields(Outcome(**fields))


def _packed(value: Any) -> Any:
    if not isinstance(value, np.ndarray):
        return value
    data = np.ascontiguousarray(value, dtype="<f8").tobytes()
    return {"float64": base64.b64encode(data).decode("ascii")}


def _unpacked(value: Any) -> Any:
    if not isinstance(value, dict):
        return value
    return np.frombuffer(base64.b64decode(value["float64"]), dtype="<f8").astype(float)


OUTCOME_LINES = LineFormat[Task, Outcome](
    key=lambda task: task.key,
    encoded=_encoded,
    key_of=lambda line: Task(**line["task"]).key,
    decoded=_decoded,
    is_finished=lambda line: bool(line["status"] != FAILED),  # what broke off is tried again
)
