"""The journal of a run: one line per finished task, written as it finishes.

A line is complete or, after a kill, the last one: that one is dropped. A task that stands
there twice counts as it was found last.
"""

from __future__ import annotations

import base64
import dataclasses
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import TracebackType
from typing import IO, Any, Self

import numpy as np
from filelock import FileLock, Timeout

from benchmark.tasks.task import FAILED, Outcome, Quantity, Series, Task
from models.errors import InputError

NAME = "journal.jsonl"


class Journal:
    """The journal in a folder, open for one run at a time.

    Used as a context manager. In memory it keeps where each task's line begins, not what
    the line says.

    Parameters
    ----------
    folder : made where it is missing

    Raises
    ------
    InputError
        On entering, if another run has it open.
    """

    def __init__(self, folder: Path) -> None:
        self.path = folder / NAME
        self._lock = FileLock(folder / f"{NAME}.lock")
        self._offsets: dict[tuple[str, str], int] = {}
        self._file: IO[bytes] | None = None

    def __enter__(self) -> Self:
        self.path.parent.mkdir(parents=True, exist_ok=True)
        try:
            self._lock.acquire(blocking=False)
        except Timeout:
            raise InputError(
                f"output {self.path.parent} is being written by another run, expected one at a time"
            ) from None
        try:
            self._file = open(self.path, "a+b")  # closed in __exit__
            self._index()
        except BaseException:
            self.__exit__(None, None, None)
            raise
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._file is not None:
            self._file.close()
        self._lock.release()

    def has(self, task: Task, identity: str) -> bool:
        """Return whether a task was finished, with figures, by the same code on the same files."""
        return (task.key, identity) in self._offsets

    def append(self, task: Task, identity: str, outcome: Outcome) -> None:
        """Add a finished task; it is with the operating system when this returns."""
        line = {"identity": identity, "task": dataclasses.asdict(task), **_encoded(outcome)}
        file = self._open()
        file.seek(0, 2)
        offset = file.tell()
        file.write(json.dumps(line, ensure_ascii=False).encode() + b"\n")
        file.flush()
        self._offsets[task.key, identity] = offset

    def read(self, task: Task, identity: str) -> Outcome:
        """Return a finished task's outcome; raises `KeyError` for one that is not there."""
        file = self._open()
        file.seek(self._offsets[task.key, identity])
        return _decoded(json.loads(file.readline()))

    def _open(self) -> IO[bytes]:
        assert self._file is not None, "the journal is used as a context manager"
        return self._file

    def _index(self) -> None:
        """Find every line; cut off what a kill left of the last one."""
        file = self._open()
        end = 0
        for offset, line in _lines(file):
            if not line.endswith(b"\n"):
                break
            self._note(offset, line)
            end = offset + len(line)
        file.truncate(end)

    def _note(self, offset: int, line: bytes) -> None:
        try:
            found = json.loads(line)
            key = Task(**found["task"]).key, str(found["identity"])
            status = found["status"]
        except (ValueError, KeyError, TypeError):
            raise InputError(
                f"journal {self.path}: the line at byte {offset} is none of a journal, "
                "expected a file that only this command writes"
            ) from None
        # A task that broke off is tried again by the next run.
        if status == FAILED:
            self._offsets.pop(key, None)
        else:
            self._offsets[key] = offset


def _lines(file: IO[bytes]) -> Iterator[tuple[int, bytes]]:
    file.seek(0)
    offset = 0
    while line := file.readline():
        yield offset, line
        offset += len(line)


def _encoded(outcome: Outcome) -> dict[str, Any]:
    fields = {f.name: getattr(outcome, f.name) for f in dataclasses.fields(outcome)}
    fields["quantities"] = [dataclasses.astuple(quantity) for quantity in outcome.quantities]
    fields["series"] = [
        {f.name: _packed(getattr(series, f.name)) for f in dataclasses.fields(series)}
        for series in outcome.series
    ]
    return fields


def _decoded(line: Mapping[str, Any]) -> Outcome:
    fields = {f.name: line[f.name] for f in dataclasses.fields(Outcome)}
    fields["quantities"] = tuple(Quantity(*values) for values in line["quantities"])
    fields["series"] = tuple(
        Series(**{name: _unpacked(value) for name, value in series.items()})
        for series in line["series"]
    )
    return Outcome(**fields)


def _packed(value: Any) -> Any:
    if not isinstance(value, np.ndarray):
        return value
    data = np.ascontiguousarray(value, dtype="<f8").tobytes()
    return {"float64": base64.b64encode(data).decode("ascii")}


def _unpacked(value: Any) -> Any:
    if not isinstance(value, dict):
        return value
    return np.frombuffer(base64.b64decode(value["float64"]), dtype="<f8").astype(float)
