"""Numbers that stand for no reading, as a column of a spreadsheet needs one: -999, 9999."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd

from recordings.foreign.column_names import meaning
from recordings.foreign.source_table import SourceTable
from recordings.foreign.told import counted

PLACEHOLDERS = (999.0, 9999.0, 99999.0)
"""Either sign; none is a range's end, which -32768 is."""
_BEYOND = 5.0
"""How far beyond all other readings of its column one lies."""


def without_placeholders(table: SourceTable) -> SourceTable:
    """Return a table with empty cells where a number that cannot be a reading stands for none."""
    found: dict[str, pd.Series] = {}
    n, values = 0, set[float]()
    for header in map(str, table.frame.columns):
        cells = table.frame[header]
        if pd.api.types.is_numeric_dtype(cells) and meaning(header, table.name) is not None:
            largest = max(cells.max(), -cells.min())
            if largest in PLACEHOLDERS:
                sizes = np.abs(cells.to_numpy(dtype=float, na_value=np.nan))
                is_one = np.isin(sizes, PLACEHOLDERS)
                if np.nanmax(np.where(is_one, 0.0, sizes)) * _BEYOND < sizes[is_one].min():
                    values |= set(cells[is_one])
                    found[header], n = cells.mask(is_one), n + int(is_one.sum())
    if not found:
        return table
    which = " and ".join(f"{value:g}" for value in sorted(values))
    repair = f"{counted(n, 'cell')} of {which} taken for no reading"
    return replace(table, frame=table.frame.assign(**found), repairs=(*table.repairs, repair))
