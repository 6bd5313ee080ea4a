"""How much a reader takes: one table, which every reader asks.

A file beyond a limit is refused in a sentence that names the limit. Each has an environment
variable that sets another one: ``PEN_MHE_MOST_COLUMNS=100000``.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from models.errors import InputError
from models.shown_text import value_text


@dataclass(frozen=True)
class Limit:
    """The most of something: how many by default, and of what."""

    default: int
    of: str


LIMITS: Mapping[str, Limit] = MappingProxyType(
    {
        "toml_bytes": Limit(200_000, "bytes of a TOML file"),
        "json_bytes": Limit(200_000_000, "bytes of a JSON file"),
        "line_bytes": Limit(100_000_000, "bytes of a line of a journal"),
        "table_bytes": Limit(16_000_000_000, "bytes of a CSV or Parquet file"),
        "unpacked_bytes": Limit(2_000_000_000, "bytes of a table that was packed, unpacked"),
        "members": Limit(1_000, "files of a folder or an archive"),
        "array_bytes": Limit(4_000_000_000, "bytes of an array within a .npz file"),
        "columns": Limit(2_000, "columns of a table"),
        "rows": Limit(100_000_000, "rows of a table"),
        "values": Limit(1_000_000_000, "values of a table, rows times columns"),
        "cell_bytes": Limit(200, "bytes of a cell of a CSV, or of a column's name"),
        "nesting": Limit(32, "tables or lists within each other, in TOML and JSON"),
        "smoothed_rows": Limit(100_000, "instants to smooth, which keeps the whole run"),
        "waiting_rows": Limit(1_000_000, "instants whose readings have not arrived yet"),
        "pixels": Limit(50_000_000, "pixels of a scan"),
        "ink_pixels": Limit(4_000_000, "pixels of a scan that are dark"),
    }
)
"""Name of a limit → its default and what it is of."""


def variable(name: str) -> str:
    """Return the environment variable that sets a limit: ``PEN_MHE_MOST_COLUMNS``."""
    return f"PEN_MHE_MOST_{name.upper()}"


def most(name: str) -> int:
    """Return a limit of `LIMITS`, as the environment sets it.

    Raises
    ------
    InputError
        If the environment sets something else than a positive whole number.
    """
    text = os.environ.get(variable(name))
    if text is None:
        return LIMITS[name].default
    if not (text.isascii() and text.isdecimal() and len(text) < 20 and int(text) > 0):
        raise InputError(
            f"environment variable {variable(name)} is {value_text(text)}, "
            "expected a positive whole number"
        )
    return int(text)


def check_most(name: str, found: int, where: str) -> None:
    """Raise `InputError` where there is more than a limit allows.

    Parameters
    ----------
    found : how many there are, or at least
    where : file, and place in it
    """
    if found > most(name):
        raise InputError(
            f"{where}: {found} {LIMITS[name].of}, expected at most {most(name)} "
            f"({variable(name)} sets another limit)"
        )
