"""Files that are opened to be read: regular ones, of bounded size.

A FIFO, a terminal or a device would be waited for, or never end.
"""

from __future__ import annotations

import os
import stat
from pathlib import Path
from typing import BinaryIO

from models.errors import InputError
from models.limits import check_most, most

_WITHOUT_WAITING = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)


def open_regular(path: Path, where: str, expected: str, limit: str | None) -> BinaryIO:
    """Open a regular file.

    Parameters
    ----------
    where : what it is, for messages: ``pen file my.toml``
    expected : what it should be: ``a readable TOML file``
    limit : of its size, one of `models.limits.LIMITS`; None where it is read in parts

    Raises
    ------
    InputError
        If it cannot be opened, is no regular file or is larger than the limit.
    """
    try:
        descriptor = os.open(path, os.O_RDONLY | _WITHOUT_WAITING)
    except (OSError, ValueError) as error:  # a name with a zero byte
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"{where}: {reason}, expected {expected}") from None
    found = os.fstat(descriptor)
    try:
        if not stat.S_ISREG(found.st_mode):
            is_folder = stat.S_ISDIR(found.st_mode)
            kind = "Is a directory" if is_folder else "is a device, a pipe or a socket"
            raise InputError(f"{where}: {kind}, expected {expected}")
        if limit is not None:
            check_most(limit, found.st_size, where)
    except InputError:
        os.close(descriptor)
        raise
    return open(descriptor, "rb")


def read_text(path: Path, where: str, expected: str, limit: str) -> str:
    """Return the text of a regular file in UTF-8; see `open_regular`.

    Raises
    ------
    InputError
        As `open_regular`, or if it is not UTF-8.
    """
    with open_regular(path, where, expected, limit) as file:
        data = file.read(most(limit) + 1)  # the system's own files may be longer than they say
    check_most(limit, len(data), where)
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError as error:
        raise InputError(
            f"{where}: is not UTF-8 (byte {error.start}), expected {expected}"
        ) from None
