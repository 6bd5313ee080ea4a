"""Files that appear whole: written beside their place, flushed, then put there.

Whatever ends a run, the old file is there or the new one. A link is followed, and an existing
file's owner and mode are kept. Several files of one result are all flushed before the first of
them is put in place. What is no file, as ``/dev/stdout`` or a FIFO, is written as it is.
"""

from __future__ import annotations

import contextlib
import errno
import os
import stat
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import IO

from estimation.half_made import HAS_LOCKS, half_made_file
from models.errors import InputError

_EFFECTIVE = os.access in os.supports_effective_ids


@contextmanager
def whole_file(path: str | Path) -> Iterator[IO[bytes]]:
    """Open a file that is put in place when the block is done; an exception leaves the old one.

    Raises
    ------
    InputError
        For any error of the system, within the block too.
    """
    with whole_files([path]) as (file,):
        yield file


@contextmanager
def whole_files(paths: Sequence[str | Path]) -> Iterator[list[IO[bytes]]]:
    """Open the files of one result, all in one folder; see `whole_file`."""
    with one_sentence_for(*paths), placed(paths) as files:
        yield files


def write_whole(path: str | Path, content: str | bytes) -> None:
    """Write a file whole, a text as UTF-8; see `whole_file`."""
    with whole_file(path) as file:
        file.write(_bytes(content))


def write_whole_files(folder: Path, contents: Mapping[str, str | bytes]) -> None:
    """Write the files of one result by name; see `whole_file`."""
    with whole_files([folder / name for name in contents]) as files:
        for file, content in zip(files, contents.values(), strict=True):
            file.write(_bytes(content))


def append_whole(path: str | Path, file: IO[bytes], content: bytes) -> int:
    """Append to an open file, or leave it as it was; return where what was added begins.

    Raises
    ------
    InputError
        For any error of the system.
    """
    held = file.fileno()
    start = os.fstat(held).st_size
    with one_sentence_for(path):
        try:
            while content:
                content = content[os.write(held, content) :]
        except BaseException:
            os.ftruncate(held, start)
            raise
        finally:
            file.seek(0, os.SEEK_END)  # what it has read ahead is old
    return start


def check_file(path: str | Path) -> None:
    """Refuse a file that cannot be written, before the work that would be lost; makes nothing.

    Raises
    ------
    InputError
        If its folder does not exist, or it cannot be written there.
    """
    with one_sentence_for(path), ExitStack() as stack:
        _check_writable(path, _state(path))
        if not _is_direct(_state(path)):
            stack.enter_context(half_made_file(Path(os.path.realpath(path))))


@contextmanager
def one_sentence_for(*paths: str | Path) -> Iterator[None]:
    """Turn an error of the system into the sentence of a file, or of the folder of several.

    Raises
    ------
    InputError
        For any error of the system within the block.
    """
    try:
        yield
    except OSError as error:
        one = len(paths) == 1
        where = Path(paths[0]) if one else Path(paths[0]).parent
        reason = error.strerror or str(error)
        if error.errno == errno.ENOENT and not Path(paths[0]).parent.exists():
            reason = f"there is no folder {Path(paths[0]).parent}"
        raise InputError(
            f"output {where}: {reason}, expected a {'file' if one else 'folder'} "
            "that can be written"
        ) from None


@contextmanager
def placed(paths: Sequence[str | Path]) -> Iterator[list[IO[bytes]]]:
    """Do what `whole_files` does, but let the system's own errors out."""
    with ExitStack() as stack:
        parts = [stack.enter_context(_part(path)) for path in paths]
        yield [part.file for part in parts]
        for part in parts:
            part.flush()
        for part in parts:
            part.put_in_place()
        for folder in {part.place.parent for part in parts if part.path is not None}:
            _flush_folder(folder)


class PartFile:
    """A file that is being written.

    Parameters
    ----------
    file : to write to
    place : where it belongs
    path : where it is; None where it is written as it is
    """

    def __init__(self, file: IO[bytes], place: Path, path: Path | None) -> None:
        self.file, self.place, self.path = file, place, path

    def flush(self) -> None:
        """Bring what was written to the disk."""
        self.file.flush()
        if self.path is not None:
            os.fsync(self.file.fileno())

    def put_in_place(self) -> None:
        """Let it take the place of the old one."""
        if self.path is None:
            return
        if not HAS_LOCKS:  # Windows moves no open file
            self.file.close()
        os.replace(self.path, self.place)


@contextmanager
def _part(path: str | Path) -> Iterator[PartFile]:
    before = _state(path)
    _check_writable(path, before)
    if _is_direct(before):
        with open(path, "wb") as file:
            yield PartFile(file, Path(path), None)
        return
    place = Path(os.path.realpath(path))
    with half_made_file(place) as (beside, held):
        if before is not None and hasattr(os, "fchown"):
            with contextlib.suppress(OSError):
                os.fchown(held, before.st_uid, before.st_gid)
            os.fchmod(held, stat.S_IMODE(before.st_mode))
        with _forgiving(os.fdopen(held, "wb", closefd=not HAS_LOCKS)) as file:
            yield PartFile(file, place, beside)


@contextmanager
def _forgiving(file: IO[bytes]) -> Iterator[IO[bytes]]:
    """Close a file; where a full disk did not take it, that was said before."""
    try:
        yield file
    finally:
        with contextlib.suppress(OSError, ValueError):
            file.close()


def _state(path: str | Path) -> os.stat_result | None:
    try:
        return os.stat(path)
    except FileNotFoundError:
        return None


def _check_writable(path: str | Path, state: os.stat_result | None) -> None:
    """Raise what opening it for writing would: to put another in place asks the folder only."""
    if state is None:
        return
    number = errno.EISDIR if stat.S_ISDIR(state.st_mode) else errno.EACCES
    if number == errno.EISDIR or not os.access(path, os.W_OK, effective_ids=_EFFECTIVE):
        raise OSError(number, os.strerror(number))


def _is_direct(state: os.stat_result | None) -> bool:
    """Return whether something is written as it is: no file, or where this process prints."""
    if state is None:
        return False
    return not stat.S_ISREG(state.st_mode) or any(
        os.path.samestat(state, printed) for printed in _printed()
    )


def _printed() -> Iterator[os.stat_result]:
    for stream in (sys.__stdout__, sys.__stderr__):
        with contextlib.suppress(AttributeError, OSError, ValueError):  # closed, or none
            yield os.fstat(stream.fileno())  # type: ignore[union-attr]


def _flush_folder(folder: Path) -> None:
    with contextlib.suppress(OSError):  # not every system can
        held = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(held)
        finally:
            os.close(held)


def _bytes(content: str | bytes) -> bytes:
    return content.encode("utf-8") if isinstance(content, str) else content
