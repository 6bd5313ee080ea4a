"""A text is looked through once, in pieces, before it is read: a cell without an end, or more rows
than anybody records, are found at the cost of a look.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from models.errors import InputError
from models.limits import check_most, most

PIECE = 1 << 18
"""Bytes that are looked through at once."""
WHOLE = ("rows", "values")
"""Limits of a table that is kept whole."""


def check_cells(
    file: BinaryIO,
    columns: int,
    where: str,
    *,
    limits: Sequence[str] = WHOLE,
    delimiters: bytes = b",",
    start: int = 0,
) -> bool:
    """Return whether a cell may begin with a blank.

    Parameters
    ----------
    limits : of the rows; none where they are not kept
    delimiters : each separates cells
    start : of the text in the file

    Raises
    ------
    InputError
        If a text has a cell, or rows, beyond the limits, or a zero byte.
    """
    longest, rows, since, is_blank = most("cell_bytes"), 0, 0, False
    file.seek(start)
    while piece := file.read(PIECE):
        if b"\0" in piece:
            raise InputError(f"{where}: holds a zero byte, expected text")
        is_blank = is_blank or _begins_blank(piece, delimiters + b"\r\n")
        gaps, ends = _gaps(piece, since, b"\n")
        lines = len(ends)
        if int(gaps.max()) > longest:  # lines with more than a cell may have: look at their cells
            gaps, ends = _gaps(piece, since, delimiters + b"\r\n")
            if (length := int(gaps.max())) > longest:
                begin = int(ends[gaps.argmax() - 1]) + 1 if gaps.argmax() else 0
                line = rows + 1 + piece.count(b"\n", 0, begin)
                check_most("cell_bytes", length, f"{where}: line {line} of the file")
        last = max(piece.rfind(mark) for mark in (delimiters[:1], delimiters[-1:], b"\n", b"\r"))
        since = len(piece) - 1 - last if last >= 0 else since + len(piece)
        rows += lines
        for limit in limits:
            check_most(limit, rows * (columns if limit == "values" else 1), where)
    file.seek(start)
    return is_blank


def _begins_blank(piece: bytes, marks: bytes) -> bool:
    """Whether a blank stands behind a mark, or first."""
    if b" " not in piece:
        return False
    found = np.frombuffer(piece, dtype=np.uint8)
    before = found[np.flatnonzero(found[1:] == ord(" "))]
    return piece.startswith(b" ") or bool(np.isin(before, list(marks)).any())


def _gaps(piece: bytes, since: int, marks: bytes) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return how many bytes stand between marks, and where these are.

    Parameters
    ----------
    since : bytes since the last one, in front of the piece
    """
    found = np.frombuffer(piece, dtype=np.uint8)
    is_mark = found == marks[0]
    for mark in marks[1:]:
        is_mark |= found == mark
    ends = np.flatnonzero(is_mark)
    return np.diff(ends, prepend=-1 - since, append=len(piece)) - 1, ends
