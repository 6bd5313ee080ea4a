"""The journal of a run: one line per finished task, written as it finishes.

A line is complete or, after a kill, the last one: that one is dropped. A task that stands
there twice counts as it was found last.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import IO, Any, Generic, Self, TypeVar

from filelock import FileLock, Timeout

from estimation.output_file import append_whole, one_sentence_for
from estimation.output_folder import make_folder, unmake
from models.errors import InputError
from models.limits import check_most, most
from models.regular_files import open_regular
from models.shown_text import LONGEST_VALUE, one_line

TaskT = TypeVar("TaskT")
ResultT = TypeVar("ResultT")


@dataclass(frozen=True)
class LineFormat(Generic[TaskT, ResultT]):
    """How a finished task is a line: an object of JSON that has its own key and ``identity``.

    Parameters
    ----------
    key : of a task, as one text
    encoded : a task and its result → the line's entries
    key_of : a line → the key of its task; raises `KeyError`, `TypeError` or `ValueError` for
        what is no such line
    decoded : a line → its result
    is_finished : a line → whether its task counts as finished for the next run
    """

    key: Callable[[TaskT], str]
    encoded: Callable[[TaskT, ResultT], Mapping[str, Any]]
    key_of: Callable[[Mapping[str, Any]], str]
    decoded: Callable[[Mapping[str, Any]], ResultT]
    is_finished: Callable[[Mapping[str, Any]], bool] = lambda line: True


class Journal(Generic[TaskT, ResultT]):
    """A journal, open for one run at a time.

    Used as a context manager. In memory it keeps where each task's line begins, not what
    the line says.

    Parameters
    ----------
    path : of the file; its folder is made where it is missing, see `estimation.output_folder`
    lines : what stands in a line

    Raises
    ------
    InputError
        On entering, if another run has it open, or something else than lines of this format
        stands there.
    """

    def __init__(self, path: Path, lines: LineFormat[TaskT, ResultT]) -> None:
        self.path = path
        self._lines = lines
        self._lock = FileLock(path.with_name(f"{path.name}.lock"))
        self._offsets: dict[tuple[str, str], int] = {}
        self._file: IO[bytes] | None = None
        self._made: list[Path] = []

    def __enter__(self) -> Self:
        if make_folder(self.path.parent):
            self._made = [Path(self._lock.lock_file), self.path.parent]
        try:
            self._lock.acquire(blocking=False)
        except Timeout:
            raise InputError(
                f"output {self.path.parent} is being written by another run, expected one at a time"
            ) from None
        try:
            if self.path.exists():  # a pipe or a device would be waited for
                open_regular(self.path, f"journal {self.path}", "a journal", "table_bytes").close()
            with one_sentence_for(self.path):
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
            if not os.fstat(self._file.fileno()).st_size:  # no task was finished
                unmake([self.path, *self._made])
            self._file.close()
        self._lock.release()

    def has(self, task: TaskT, identity: str) -> bool:
        """Return whether a task was finished, with figures, by the same code on the same files."""
        return (self._lines.key(task), identity) in self._offsets

    def append(self, task: TaskT, identity: str, result: ResultT) -> None:
        """Add a finished task, see `append_together`."""
        self.append_together([(task, identity, result)])

    def append_together(self, finished: Iterable[tuple[TaskT, str, ResultT]]) -> None:
        """Add finished tasks with their identities; the operating system has them all, or none.

        Raises `InputError` where the lines cannot be written: no part of them stays.
        """
        written: dict[tuple[str, str], bytes] = {}
        for task, identity, result in finished:
            line = {"identity": identity, **self._lines.encoded(task, result)}
            text = json.dumps(line, ensure_ascii=False).encode() + b"\n"
            written[self._lines.key(task), identity] = text
        offset = append_whole(self.path, self._open(), b"".join(written.values()))
        for key, text in written.items():
            self._offsets[key] = offset
            offset += len(text)

    def read(self, task: TaskT, identity: str) -> ResultT:
        """Return a finished task's result.

        Raises `KeyError` for one that is not there, `InputError` where its line is damaged.
        """
        file = self._open()
        offset = self._offsets[self._lines.key(task), identity]
        file.seek(offset)
        try:
            return self._lines.decoded(json.loads(file.readline()))
        except Exception as error:  # whatever a damaged line makes of itself
            raise InputError(
                f"journal {self.path}: the line at byte {offset} is damaged "
                f"({one_line(str(error), LONGEST_VALUE)}), "
                "expected one as it was written; without that line its task runs again"
            ) from error

    def _open(self) -> IO[bytes]:
        assert self._file is not None, "the journal is used as a context manager"
        return self._file

    def _index(self) -> None:
        """Find every line; cut off what a kill left of the last one."""
        file = self._open()
        end = 0
        for offset, line in _whole_lines(file, f"journal {self.path}"):
            self._note(offset, line)
            end = offset + len(line)
        file.truncate(end)

    def _note(self, offset: int, line: bytes) -> None:
        try:
            found = json.loads(line)
            key = self._lines.key_of(found), str(found["identity"])
            is_finished = self._lines.is_finished(found)
        except Exception as error:  # whatever another line makes of itself
            raise InputError(
                f"journal {self.path}: the line at byte {offset} is none of a journal, "
                "expected a file that only this command writes"
            ) from error
        if is_finished:
            self._offsets[key] = offset
        else:
            self._offsets.pop(key, None)


def _whole_lines(file: IO[bytes], where: str) -> Iterator[tuple[int, bytes]]:
    file.seek(0)
    offset, longest = 0, most("line_bytes")
    while (line := file.readline(longest + 1)).endswith(b"\n"):
        yield offset, line
        offset += len(line)
    check_most("line_bytes", len(line), f"{where}: the line at byte {offset}")
