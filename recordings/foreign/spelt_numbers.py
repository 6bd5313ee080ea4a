"""Numbers as people and programs spell them: ``1.5D-03`` of Fortran, ``1,234.5``, ``−0.3``."""

from __future__ import annotations

import re
from collections.abc import Mapping
from types import MappingProxyType

import pandas as pd

MINUS = "\N{MINUS SIGN}"
# Nothing gives back what it has taken: time is linear in a cell without an end.
_SIGN, _EXPONENT = f"[+{MINUS}-]?", f"(?:[ed][+{MINUS}-]?\\d+)?"
_SPACES = "'\N{RIGHT SINGLE QUOTATION MARK} \N{NO-BREAK SPACE}\N{NARROW NO-BREAK SPACE}"
POINT = re.compile(
    rf"{_SIGN}(?:\d{{1,3}}(?:,\d{{3}}){{2,}}(?:\.\d*)?|\d{{1,3}},\d{{3}}\.\d*"
    rf"|\d{{1,3}}(?:[{_SPACES}]\d{{3}})+(?:\.\d*)?|\d++\.?+\d*+|\.\d++){_EXPONENT}",
    re.IGNORECASE,
)
"""A number with a decimal point, or with none; thousands apart."""
COMMA = re.compile(
    rf"{_SIGN}(?:\d{{1,3}}(?:[.{_SPACES}]\d{{3}})+,\d*|\d+,\d*|,\d+){_EXPONENT}", re.IGNORECASE
)
"""A number with a decimal comma."""
_BETWEEN_THOUSANDS: Mapping[str, re.Pattern[str]] = MappingProxyType(
    {
        decimal: re.compile(rf"(?<=\d)[{mark}{_SPACES}](?=\d{{3}}(?!\d))")
        for decimal, mark in ((".", ","), (",", "."))
    }
)
_MARKS = re.compile(rf"[,{MINUS}]|[\d.][dD.{_SPACES}]|^\s|\s$")
"""What stands in every cell that `_plain` changes."""
_LOOKED_AT = 1000
_LONGEST = 300
"""Characters of a cell that may be a number, where one of them is too large for a float."""


def respelt(frame: pd.DataFrame, decimal: str) -> pd.DataFrame:
    """Return a table with the numbers in columns of texts spelt as everybody reads them.

    A column is respelt where that makes numbers of most of the cells that are none.
    """
    found = {}
    for name in frame.columns:
        cells = frame[name]
        if not (cells.dtype == object or pd.api.types.is_string_dtype(cells)):
            continue
        is_text = (_numbers(cells).isna() & cells.notna()).to_numpy()
        texts = cells[is_text]
        if not any(map(_MARKS.search, map(str, texts.iloc[:_LOOKED_AT]))):
            continue
        texts = texts.astype("string")
        sample = _plain(texts.iloc[:_LOOKED_AT], decimal)
        if _numbers(sample).notna().mean() > 0.5:
            changed = cells.astype(object)
            changed[is_text] = _plain(texts, decimal).astype(object)
            numbers = _numbers(changed)
            whole = (numbers.notna() == cells.notna()).all()
            found[name] = numbers if whole else changed
    return frame.assign(**found) if found else frame


def _numbers(cells: pd.Series) -> pd.Series:
    """Return cells as numbers, NaN where they are none: digits beyond a float's range are none."""
    try:
        return pd.to_numeric(cells, errors="coerce")
    except OverflowError:
        short = cells.where(cells.astype("string").str.len() <= _LONGEST)
        return pd.to_numeric(short, errors="coerce")


def _plain(texts: pd.Series, decimal: str) -> pd.Series:
    plain = texts.str.strip().str.replace(MINUS, "-", regex=False)
    plain = plain.str.replace(_BETWEEN_THOUSANDS[decimal], "", regex=True)
    if decimal != ".":
        plain = plain.str.replace(decimal, ".", regex=False)
    return plain.str.replace(r"(?<=[\d.])[dD](?=[+-]?\d+$)", "e", regex=True)
