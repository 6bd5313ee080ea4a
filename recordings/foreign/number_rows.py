"""Tables with a row for each number, as Teleplot, InfluxDB and MQTT's loggers write them.

One column names the quantity (``ax``), or two do (``acc`` and ``x``), another has its value, and
one its stamp. They become a row for each instant: of the numbers with one stamp, or, where each
number has a stamp of its own, of those up to where a name comes again.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from models.limits import check_most
from models.shown_text import short
from recordings.foreign.column_names import meaning
from recordings.foreign.header_units import spelt_words, words_of
from recordings.foreign.source_table import SourceTable
from recordings.foreign.stamps import stamp_headers

MOST_NAMES = 64
_VALUES = spelt_words("value val v reading data")
_SHARED = 0.9
"""Part of the stamps that numbers of one instant have in common, if they have one stamp."""
_LEAST_AXES = 3
_Names = Mapping[str, tuple[str, str]]
"""Name → kind and label of those that are readings."""


def unpivoted(table: SourceTable) -> list[SourceTable] | None:
    """Return a table for each sensor of one with a row for each number; None for any other.

    Raises
    ------
    InputError
        If it has more values than `models.limits.LIMITS` allows.
    """
    headers = [str(header) for header in table.frame.columns]
    if sum(meaning(header) is not None for header in headers) >= _LEAST_AXES:
        return None
    value = _value_header(table.frame, headers)
    names = None if value is None else _names(table.frame, headers)
    if value is None or names is None:
        return None
    stamps = [h for h in stamp_headers(headers) if h != value]
    stamp = max(stamps, key=lambda header: table.frame[header].nunique(), default=None)
    columns = [names.rename("name"), table.frame[value].rename("value")]
    columns += [] if stamp is None else [table.frame[stamp].rename("stamp")]
    numbers = pd.concat(columns, axis=1)
    if stamp is not None:
        numbers = numbers[numbers["stamp"].notna()]
    check_most("values", len(numbers) * names.nunique(), f"recording {table.name}")
    parts: list[tuple[list[str], pd.DataFrame]] = []
    known = _readings(names)
    for label in dict.fromkeys(label for _, label in known.values()):
        of_label = [name for name, (_, one) in known.items() if one == label]
        for some, share in _together(numbers, of_label, known):
            frame = _rows(numbers[numbers["name"].isin(some)], some, share=share)
            parts.append((some, frame.rename(columns={"stamp": stamp})))
    return [
        replace(
            table,
            name=table.name if len(parts) == 1 else f"{table.name} ({short(some[0])}, …)",
            frame=frame,
            said=(*table.said, f"a row for each number: {', '.join(map(short, some))}"),
            has_header=True,
        )
        for some, frame in parts
    ]


def _value_header(frame: pd.DataFrame, headers: Sequence[str]) -> str | None:
    """Return the column of values: by its name, else the only one of numbers that are no times."""
    numbers = [header for header in headers if pd.api.types.is_numeric_dtype(frame[header])]
    named = [header for header in numbers if set(words_of(header)) & _VALUES]
    others = named or [header for header in numbers if header not in stamp_headers(headers)]
    return others[0] if len(others) == 1 else None


def _names(frame: pd.DataFrame, headers: Sequence[str]) -> pd.Series | None:
    """Return the name of each row's number: of the one column, or the two, that tell axes."""
    texts = [
        header
        for header in headers
        if not pd.api.types.is_numeric_dtype(frame[header]) and _is_few(frame[header])
    ]
    for pair in (*((one,) for one in texts), *combinations(texts, 2)):
        cells = [frame[header].astype("string").fillna("") for header in pair]
        names = cells[0] if len(cells) == 1 else cells[0].str.cat(cells[1], sep=" ")
        if len(_readings(names)) >= _LEAST_AXES:
            return names
    return None


def _is_few(cells: pd.Series) -> bool:
    """Whether a column has few texts; a long one with many is seen at its beginning."""
    return cells.head(1000).nunique() <= MOST_NAMES and 1 < cells.nunique() <= MOST_NAMES


def _readings(names: pd.Series) -> _Names:
    """Return the names of axes of sensors of which three are told."""
    told = {str(name): meaning(str(name)) for name in names.unique()}
    found = {name: (one.kind, one.label) for name, one in told.items() if one is not None}
    counts = pd.Series(list(found.values())).value_counts()
    return {name: sensor for name, sensor in found.items() if counts[sensor] >= _LEAST_AXES}


def _together(
    numbers: pd.DataFrame, names: Sequence[str], known: _Names
) -> list[tuple[list[str], bool]]:
    """Return the names that are one table, and whether they have their stamps in common.

    All are where they have, else those of each kind.
    """
    if _share_stamps(numbers, names):
        return [(list(names), True)]
    kinds = dict.fromkeys(known[name][0] for name in names)
    found = [[name for name in names if known[name][0] == kind] for kind in kinds]
    return [(some, len(kinds) > 1 and _share_stamps(numbers, some)) for some in found]


def _share_stamps(numbers: pd.DataFrame, names: Sequence[str]) -> bool:
    if "stamp" not in numbers:
        return False
    stamps = [set(numbers["stamp"][numbers["name"] == name].dropna()) for name in names]
    common = set.intersection(*stamps)
    return len(common) >= _SHARED * max(map(len, stamps))


def _rows(numbers: pd.DataFrame, names: Sequence[str], *, share: bool) -> pd.DataFrame:
    """Return a row for each instant: its stamp, and a column for each name.

    Parameters
    ----------
    share : whether the numbers of an instant have one stamp; else a name that comes again begins
        another
    """
    is_stamped = "stamp" in numbers
    if share:
        again = numbers.groupby(["name", "stamp"]).cumcount()
        keyed = numbers.assign(again=again).set_index(["stamp", "again", "name"])
        wide = keyed["value"].unstack("name", sort=False).reset_index()
    else:
        keyed = numbers.assign(row=_rows_of(numbers["name"].to_numpy()))
        wide = keyed.set_index(["row", "name"])["value"].unstack("name", sort=False)
        if is_stamped:
            wide.insert(0, "stamp", keyed.groupby("row")["stamp"].first())
    return wide[[*(["stamp"] if is_stamped else []), *names]].reset_index(drop=True)


def _rows_of(names: NDArray[np.object_]) -> NDArray[np.int64]:
    """Return which row each number is of: a name that comes again begins another."""
    found, row, seen = np.empty(len(names), dtype=np.int64), 0, set[object]()
    for k, name in enumerate(names):
        if name in seen:
            row, seen = row + 1, set()
        seen.add(name)
        found[k] = row
    return found
