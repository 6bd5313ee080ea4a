"""A table as it stands in a file, before anybody has said what its columns mean."""

from __future__ import annotations

from dataclasses import dataclass

import pandas as pd


@dataclass(frozen=True, eq=False)
class SourceTable:
    """Rows and columns of a file, a sheet or a topic.

    Parameters
    ----------
    name : of the file, sheet or topic: ``Gyroscope.csv``
    frame : its columns by their headers, those without a name as ``column 3``
    preamble : the lines before its header
    said : sentences on how it was read, where that was not plain
    repairs : sentences on what was left out of it: lines that are no rows
    about : what a file beside it says of the recording: ``platform=ios``
    has_header : whether its columns' names come from the file, or from who asked
    """

    name: str
    frame: pd.DataFrame
    preamble: str = ""
    said: tuple[str, ...] = ()
    repairs: tuple[str, ...] = ()
    has_header: bool = True
    about: str = ""
