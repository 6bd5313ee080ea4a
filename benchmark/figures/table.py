"""A table of the report as data, where a suite has more to say than figures show."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Table:
    """Rows of text.

    Parameters
    ----------
    title : what is to be read
    caption : sentences: how it was made, in which order it is
    head : names of the columns, with units
    rows : a text for each column
    """

    title: str
    caption: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]
