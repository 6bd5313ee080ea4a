"""Columns by name: those that somebody asks for, and those that a recording of the pen has."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from models.errors import InputError
from models.names import did_you_mean
from models.shown_text import short
from recordings.foreign.header_units import split_header
from recordings.foreign.source_table import SourceTable
from recordings.formats.columns import TRUTH_PREFIX, Column, expected_for


def check_canonical(
    table: SourceTable, canonical: Mapping[str, str], known: Mapping[str, Column], where: str
) -> None:
    """Raise `InputError` for two columns of one quantity, or a truth that is none.

    Parameters
    ----------
    canonical : of `canonical_headers`
    known : header → meaning, of `recordings.formats.columns.recording_columns`
    """
    found: dict[str, str] = {}
    for header, name in canonical.items():
        other = found.setdefault(known[name].quantity, header)
        if other != header:
            raise InputError(
                f"{where}: columns {short(other)} and {short(header)} both give "
                f"{known[name].quantity}, expected one"
            )
    if any(quantity.startswith(TRUTH_PREFIX) for quantity in found):
        for header in map(str, table.frame.columns):
            if header.startswith(TRUTH_PREFIX) and header not in canonical:
                raise InputError(
                    f"{where}: unknown column {short(header)}, "
                    f"expected {expected_for(header, known)}"
                )


def columns_asked(
    tables: Sequence[SourceTable],
    columns: Mapping[str, Sequence[str]],
    *,
    must_be: bool,
    what: str = "recording",
) -> list[dict[str, tuple[str, ...]]]:
    """Return, for each table, sensor → those columns of it that somebody names.

    Parameters
    ----------
    what : they are tables of, for messages

    Raises
    ------
    InputError
        If `must_be` and no table has a column.
    """
    found: list[dict[str, tuple[str, ...]]] = [{} for _ in tables]
    for sensor, names in columns.items():
        resolved = [[_resolved(table, name) for name in names] for table in tables]
        at = next((i for i, headers in enumerate(resolved) if all(headers)), None)
        if at is not None:
            found[at][sensor] = tuple(str(header) for header in resolved[at])
        elif must_be:
            best = max(resolved, key=lambda headers: sum(h is not None for h in headers))
            name = names[best.index(None)]
            known = [str(header) for table in tables for header in table.frame.columns]
            shown = ", ".join(map(short, known[:40]))
            raise InputError(
                f"{what} {tables[0].name}: no column {short(name)} for {short(sensor)}, "
                f"expected one of {shown}{did_you_mean(name, known)}"
            )
    return found


def _resolved(table: SourceTable, name: str) -> str | None:
    """Return the column of a name: as it is written, else whatever its capitals and unit.

    In front of a name a minus stays, of a column that reads the other way round.
    """
    headers = [str(header) for header in table.frame.columns]
    if name in headers:
        return name
    for spelt in (str.casefold, _without_unit):
        alike = [header for header in headers if spelt(header.strip()) == spelt(name)]
        if len(alike) == 1:
            return alike[0]
    turned = _resolved(table, name[1:].strip()) if name.startswith("-") else None
    return None if turned is None else f"-{turned}"


def _without_unit(name: str) -> str:
    return split_header(name)[0].casefold().replace("_", " ")
