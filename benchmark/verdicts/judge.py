"""What the results say of a claim: its figure, the interval of it, and a verdict."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from benchmark.tasks.task import OK
from benchmark.verdicts.bootstrap import STATISTICS, Interval, Strata, interval
from benchmark.verdicts.claims import PAIRED_BY, STATUS_IS, Chosen, Claim
from models.arrays import Array

if TYPE_CHECKING:
    import pandas as pd

HOLDS, FAILS, UNDECIDED, NO_DATA = "holds", "does not hold", "undecided", "no data"
NOT_JUDGED = "not judged"
"""Of a claim that no figure can decide (it says why), and of single runs: they have no interval."""
VERDICTS = (HOLDS, FAILS, UNDECIDED, NOT_JUDGED, NO_DATA)

COUNTS_ALWAYS = ("solved_fraction",)
"""Columns that runs of any status have to say something about."""

VALUE, OTHER = "value", "other value"


@dataclass(frozen=True)
class Part:
    """A claim judged on one of the values of `Claim.every`."""

    name: str
    figure: float
    low: float
    high: float
    verdict: str


@dataclass(frozen=True)
class Judgement:
    """A claim with its figure over everything, and part by part.

    Parameters
    ----------
    claim : what was claimed
    figure, low, high : over all cases and seeds, and its 95 % interval; NaN without data, and
        where parts are quantities: different units have no mean
    pairs : number of runs (or pairs of them) that count
    parts : one for each value of `Claim.every`
    verdict : one of `VERDICTS`; where there are parts it holds if every part holds
    """

    claim: Claim
    figure: float
    low: float
    high: float
    pairs: int
    parts: tuple[Part, ...]
    verdict: str

    @property
    def holding(self) -> str:
        """``9 of 10``: in how many of the parts that are judged it holds; empty without parts."""
        if not self.parts:
            return ""
        judged = [part.verdict for part in self.parts if part.verdict != NOT_JUDGED]
        return f"{judged.count(HOLDS)} of {len(judged)}"


def judge(claims: Sequence[Claim], rows: pd.DataFrame) -> list[Judgement]:
    """Judge claims by the rows of ``results.parquet``."""
    return [_judged(claim, rows) for claim in claims]


def _judged(claim: Claim, rows: pd.DataFrame) -> Judgement:
    table, nan = paired_values(claim, rows), float("nan")
    if not len(table):
        return Judgement(claim, nan, nan, nan, 0, (), NO_DATA)
    mixed = "quantity" in claim.every
    found = Interval(nan, nan, nan) if mixed else _interval(claim, claim.id, table)
    if claim.not_judged or not claim.every:
        said = NOT_JUDGED if claim.not_judged else _verdict_of(claim, found, table)
        return Judgement(claim, *_three(found), len(table), (), said)
    parts = []
    for key, part in table.groupby(list(claim.every), sort=False):
        name = ", ".join(str(value) for value in key)
        of_part = _interval(claim, f"{claim.id} {name}", part)
        parts.append(Part(name, *_three(of_part), _verdict_of(claim, of_part, part)))
    return Judgement(claim, *_three(found), len(table), tuple(parts), _all_of(parts))


CELL = ["case", "sensors", "estimator", "quantity"]
"""What runs that differ by their seed alone have in common."""


def _verdict_of(claim: Claim, found: Interval, table: pd.DataFrame) -> str:
    """Return the verdict: of an interval where some cell has more than one run, or of a margin."""
    if table.duplicated(CELL).any():
        return verdict(claim, found)
    if claim.margin == 0:
        return NOT_JUDGED
    away = claim.margin * abs(found.figure)
    return verdict(claim, Interval(found.figure, found.figure - away, found.figure + away))


def verdict(claim: Claim, found: Interval) -> str:
    """Return whether the whole interval meets the criterion, misses it, or neither."""
    least = -np.inf if claim.at_least is None else claim.at_least
    most = np.inf if claim.at_most is None else claim.at_most
    if least <= found.low and found.high <= most:
        return HOLDS
    if found.high < least or found.low > most:
        return FAILS
    return UNDECIDED


def paired_values(claim: Claim, rows: pd.DataFrame) -> pd.DataFrame:
    """Return what a claim judges, by cell and seed: `VALUE`, and `OTHER` where it compares."""
    table = _values(claim, rows, claim.of, VALUE)
    columns = [*CELL, "seed"]
    if claim.against is not None:
        other = _values(claim, rows, {**claim.of, **claim.against}, OTHER)
        by = [column for column in PAIRED_BY if column not in claim.against]
        table = table.merge(other[[*by, OTHER]], on=by, validate="many_to_one")
    return table.sort_values(columns, kind="stable").reset_index(drop=True)


def _values(
    claim: Claim, rows: pd.DataFrame, chosen: Mapping[str, Chosen], name: str
) -> pd.DataFrame:
    for column, value in chosen.items():
        rows = rows[_chosen(rows[column], value if isinstance(value, tuple) else (value,))]
    by_status = claim.value.startswith(STATUS_IS)
    if by_status or claim.value in COUNTS_ALWAYS:
        # A run counts once, whatever quantities it has; one that broke off has none.
        rows = rows.drop_duplicates(["case", "sensors", "estimator", "seed"])
        rows = rows.assign(quantity="")
    else:
        rows = rows[rows["status"] == OK]
    if by_status:
        values = (rows["status"] == claim.value.removeprefix(STATUS_IS)).astype(float)
    else:
        values = rows[claim.value].astype(float)
    kept = rows[[*CELL, "seed"]].assign(**{name: values})
    return kept[kept[name].notna()]


def _chosen(column: pd.Series, values: tuple[str | int, ...]) -> pd.Series:
    """Return which entries are one of the values, or fit one of them that has a ``*``."""
    fits = {
        entry
        for entry in column.unique()
        for value in values
        if entry == value or (isinstance(value, str) and fnmatchcase(str(entry), value))
    }
    return column.isin(fits)


def _interval(claim: Claim, name: str, table: pd.DataFrame) -> Interval:
    cells = table.groupby(CELL, sort=False).ngroup()
    strata = Strata(np.asarray(cells, dtype=np.int64))
    value = np.asarray(table[VALUE], dtype=float)
    if claim.statistic == "worst":
        return interval(name, strata, lambda index: strata.worst(value[index]), len(table))
    other = np.asarray(table[OTHER], dtype=float) if claim.against is not None else None
    return interval(name, strata, lambda index: _figure(claim, value, other, index), len(table))


def _figure(claim: Claim, value: Array, other: Array | None, index: NDArray[np.int64]) -> Array:
    statistic = STATISTICS[claim.statistic]
    if other is None:
        return statistic(value[index])
    if claim.compare == "difference":
        return statistic(value[index] - other[index])
    return np.asarray(statistic(value[index]) / statistic(other[index]))


def _three(found: Interval) -> tuple[float, float, float]:
    return found.figure, found.low, found.high


def _all_of(parts: Sequence[Part]) -> str:
    verdicts = {part.verdict for part in parts} - {NOT_JUDGED}
    if FAILS in verdicts:
        return FAILS
    if not verdicts:
        return NOT_JUDGED
    return HOLDS if verdicts == {HOLDS} else UNDECIDED
