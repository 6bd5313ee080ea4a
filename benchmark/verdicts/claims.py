"""Claims as data: what is said, and the figure by which it is judged.

A claim is a row ``[[claim]]`` of a suite's TOML file, committed before the suite first ran.
"""

from __future__ import annotations

import datetime
from collections.abc import Mapping
from pathlib import Path
from typing import Literal, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from benchmark.tasks.results import RESULT_COLUMNS
from models.border import reading
from models.errors import InputError
from models.parsed import toml_data
from models.regular_files import read_text
from models.shown_text import short

Chosen = str | int | bool | tuple[str, ...] | tuple[int, ...]
Compare = Literal["ratio", "difference"]
PAIRED_BY = ("case", "sensors", "estimator", "quantity", "seed")
"""What a row and the row that it is set against have in common, unless `against` says otherwise."""

STATUS_IS = "status="
"""``status=mirror`` is 1 in the rows of that status and 0 in others."""


class Change(BaseModel):
    """A change of a criterion.

    Parameters
    ----------
    on : the day
    why : what was wrong with the criterion before, in words
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    on: datetime.date
    why: str = Field(min_length=1)


class Claim(BaseModel):
    """One claim and its criterion.

    The figure is the mean (or median) over cases and seeds of a column of the chosen rows,
    or how it compares with other rows that agree in `PAIRED_BY`. The claim holds
    where the whole interval of the figure lies within `at_least` and `at_most`.

    Parameters
    ----------
    id : unique, begins with its suite: ``pen-1-rates``
    source : who says it: ``[Pen] 1``; ``ours`` for questions of our own
    says : the claim, in our words
    criterion : the figure in words, with its unit
    of : column → value or list of values that choose rows; ``*`` in a text stands for any
        part of it
    value : the column that is judged, or ``status=…``. Only `OK` rows count, except for
        ``status=…`` and ``solved_fraction``
    against : as `of`, changes to it that choose the rows to compare with
    compare : figure = mean of `of` / mean of `against`, or mean of their differences
    statistic : mean or median over cases and seeds; worst: mean over cases of the largest seed
    every : columns for each of whose values the claim must hold by itself: ``case``, ``quantity``
    at_least, at_most : the criterion; one of them or both
    changed : every change of the criterion since it was first written, oldest first
    margin : part of its figure by which a single run may be off, in place of the interval that it
        does not have; 0: single runs are not judged
    not_judged : why no figure can decide the claim; empty for one that is judged
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    id: str
    source: str
    says: str
    criterion: str
    of: Mapping[str, Chosen]
    value: str = "rmse"
    against: Mapping[str, Chosen] | None = None
    compare: Compare = "ratio"
    statistic: Literal["mean", "median", "worst"] = "mean"
    every: tuple[Literal["case", "quantity", "sensors", "estimator"], ...] = ()
    at_least: float | None = None
    at_most: float | None = None
    changed: tuple[Change, ...] = ()
    margin: float = Field(default=0.0, ge=0.0, lt=1.0)
    not_judged: str = ""

    @model_validator(mode="after")
    def _can_be_judged(self) -> Self:
        if self.at_least is None and self.at_most is None:
            raise ValueError("neither at_least nor at_most is given, expected one of them")
        for column in (*self.of, *(self.against or {})):
            if column not in RESULT_COLUMNS:
                raise ValueError(f"column {column} is unknown")
        if self.statistic == "worst" and self.against is not None:
            raise ValueError("statistic worst compares nothing, expected no against")
        if self.value not in RESULT_COLUMNS and not self.value.startswith(STATUS_IS):
            raise ValueError(f"value {self.value} is no column")
        return self


class _ClaimFile(BaseModel):
    model_config = ConfigDict(extra="forbid")

    claim: tuple[Claim, ...] = Field(min_length=1)


def load_claims(path: Path) -> tuple[Claim, ...]:
    """Read the claims of a suite.

    Raises
    ------
    InputError
        If a key or value is wrong, or an id stands twice; the message names file and key.
    """
    where, expected = f"claims file {path}", "rows [[claim]] in TOML"
    with reading(where, expected):
        data = toml_data(read_text(path, where, expected, "toml_bytes"), where, expected=expected)
        try:
            claims = _ClaimFile.model_validate(data).claim
        except ValidationError as error:
            first = error.errors(include_url=False, include_context=False)[0]
            key = ".".join(str(part) for part in first["loc"])
            raise InputError(f"{where}: key {short(key)}: {short(first['msg'])}") from None
    ids = [claim.id for claim in claims]
    twice = sorted({name for name in ids if ids.count(name) > 1})
    if twice:
        raise InputError(f"claims file {path}: id {twice[0]} stands twice, expected it once")
    return claims
