"""Cells that are stamps: numbers, dates by ISO 8601 and other customs, times of a day."""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from recordings.formats.columns import loose_numbers

Stamped = NDArray[np.float64] | NDArray[np.int64]
_SPAN = r"\d{1,2}:\d{2}(:\d{2}(\.\d*)?)?|[+-]?\d+(\.\d*)?\s*(s|sec|seconds|ms|us|ns)"
"""A time of a day, or one with its unit."""
_MILLIS_BY_COLON = re.compile(r"(?<=\d:\d{2}:\d{2}):(?=\d{3,9}\D*$)")


def stamped_cells(cells: pd.Series) -> tuple[Stamped | None, bool]:
    """Return stamps as numbers, and whether they were dates; those in ns then."""
    if cells.dtype.kind == "M":
        return _nanoseconds(pd.to_datetime(cells, utc=True)), True
    if cells.dtype.kind in "iu":
        return cells.to_numpy(dtype=np.int64), False
    numbers = loose_numbers(cells)
    if np.isfinite(numbers).mean() > 0.5:
        return np.where(np.isfinite(numbers), numbers, np.nan), False
    if cells.dtype.kind not in "OTU" and not pd.api.types.is_string_dtype(cells):
        return None, False
    texts = cells.astype("string").str.strip().str.replace(",", ".", regex=False)
    first = texts.dropna().head(20)
    if not len(first):
        return None, False
    if first.str.contains(_MILLIS_BY_COLON).all():
        texts = texts.str.replace(_MILLIS_BY_COLON, ".", regex=True)
        first = texts.dropna().head(20)
    if first.str.fullmatch(_SPAN).all():
        spans = pd.to_timedelta(texts, errors="coerce")
        return np.where(spans.isna(), np.nan, spans.dt.total_seconds() * 1e9), True
    day_first = bool(first.str.match(r"\d{1,2}\.\d{1,2}\.\d{4}").all())
    for options in ({"format": "ISO8601"}, {"format": "mixed", "dayfirst": day_first}):
        if options["format"] == "mixed" and _parsed(first, options).isna().mean() > 0.5:
            return None, False
        dates = _parsed(texts, options)
        if dates.notna().mean() > 0.5:
            return _nanoseconds(dates), True
    return None, False


def _parsed(texts: pd.Series, options: Mapping[str, object]) -> pd.Series:
    try:
        return pd.Series(pd.to_datetime(texts, errors="coerce", utc=True, **options))  # type: ignore[call-overload]
    except (ValueError, OverflowError, TypeError):
        return pd.Series(pd.NaT, index=texts.index)


def _nanoseconds(dates: pd.Series) -> Stamped | None:
    """Return dates as nanoseconds from 1970; None where they are too far from it."""
    missing = dates.isna().to_numpy()
    try:
        counted = dates.dt.tz_convert(None).astype("datetime64[ns]").to_numpy().astype(np.int64)
    except ValueError:
        return None
    return np.where(missing, np.nan, counted) if missing.any() else counted
