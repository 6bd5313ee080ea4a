"""TOML and JSON as data: whole numbers that fit, and no more nesting than anybody writes.

`tomllib` and `json` answer some texts with a traceback, or with minutes of work: a number of
thousands of digits, a thousand brackets, a key of a thousand dots.
"""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from models.border import reading
from models.errors import InputError
from models.limits import check_most, most
from models.regular_files import open_regular
from models.shown_text import LONGEST_VALUE, one_line, value_text

WHOLE_END = 2**63
"""From here on TOML has no whole numbers, nor below its negative."""

# No alternative gives back what it has taken, and each takes something: time is linear.
_STRING = r"""(?:"(?:[^"\\\n]|\\.)*+"?|'[^'\n]*+'?)"""
_KEYS = re.compile(rf"#[^\n]*+|(?:[\w-]++|{_STRING})(?:[ \t]*+\.[ \t]*+(?:[\w-]++|{_STRING}))*+")
_MANY_DIGITS = re.compile(rb"\d{300}")
_STRING_OF_JSON = re.compile(rb'"(?:[^"\\]|\\.)*+"?', re.DOTALL)


def toml_data(text: str, where: str, *, expected: str = "TOML") -> dict[str, Any]:
    """Return what a text in TOML says.

    Raises
    ------
    InputError
        If it is no TOML, is nested beyond `models.limits.LIMITS`, or a whole number in it does
        not fit into 64 bits.
    """
    _check_dots(text, where)
    with reading(where, expected):
        try:
            data = tomllib.loads(text)
        except ValueError as error:  # its own, and that of a number with too many digits
            reason = one_line(str(error), LONGEST_VALUE)
            raise InputError(f"{where}: {reason}, expected {expected}") from None
        _check(data, where)
        return data


def json_data(data: bytes, where: str, *, expected: str = "JSON") -> Any:
    """Return what a text in JSON and UTF-8 says.

    Raises
    ------
    InputError
        If it is no JSON, or is nested beyond `models.limits.LIMITS`.
    """
    with reading(where, expected):
        check_most("nesting", _json_nesting(data), where)
        if found := _MANY_DIGITS.search(data):
            raise InputError(
                f"{where}: a number at byte {found.start()} has 300 digits or more, "
                f"expected {expected} with shorter ones"
            )
        try:
            return json.loads(data.decode("utf-8"))
        except ValueError as error:
            reason = one_line(str(error), LONGEST_VALUE)
            raise InputError(f"{where}: {reason}, expected {expected}") from None


def read_object(path: Path, expected: str) -> dict[str, Any]:
    """Return the object that a JSON file holds.

    Raises
    ------
    InputError
        As `models.regular_files.open_regular` and `json_data`, or if it holds something else.
    """
    with open_regular(path, str(path), expected, "json_bytes") as file:
        found = json_data(file.read(), str(path))
    if not isinstance(found, dict):
        raise InputError(f"{path} holds no object, expected {expected}")
    return found


def check_entries(
    data: Mapping[str, Any], kinds: Mapping[str, tuple[type, type | None]], where: str
) -> None:
    """Raise `InputError` unless those entries of an object that are there are what they should be.

    Parameters
    ----------
    kinds : key → type of its entry, and that of the entries or keys within it, if any
    """
    kind: Any
    for key, (kind, of) in kinds.items():
        entry = data.get(key, kind())
        if not isinstance(entry, kind) or (of and not all(isinstance(one, of) for one in entry)):
            words = kind.__name__ + (f" of {of.__name__}" if of else "")
            raise InputError(f"{where}: key {key}: {value_text(entry)}, expected {words}")


def _check_dots(text: str, where: str) -> None:
    # tomllib takes time as the square of a key's dots.
    deepest = most("nesting")
    for found in _KEYS.finditer(text):
        key = found[0]
        if key.count(".") >= deepest and key[0] != "#":
            parts = re.sub(_STRING, "", key).count(".") + 1
            check_most("nesting", parts, f"{where}: key {value_text(key)}")


def _check(data: Mapping[str, Any], where: str) -> None:
    """Raise `InputError` for nesting beyond the limit, or a whole number beyond 64 bits."""
    deepest = most("nesting")
    waiting: list[tuple[int, str, Any]] = [(1, key, value) for key, value in data.items()]
    while waiting:
        depth, key, value = waiting.pop()
        if isinstance(value, int) and not -WHOLE_END <= value < WHOLE_END:
            raise InputError(
                f"{where}: key {key}: a whole number of {value.bit_length()} bits, "
                "expected one that fits into 64"
            )
        if isinstance(value, dict | list):
            if depth >= deepest:
                check_most("nesting", deepest + 1, f"{where}: key {key}")
            if isinstance(value, dict):
                waiting += [(depth + 1, f"{key}.{name}", entry) for name, entry in value.items()]
            else:
                waiting += [(depth + 1, key, entry) for entry in value]


def _json_nesting(data: bytes) -> int:
    """Return how many brackets are open at once at most."""
    import numpy as np  # what completes a word on the command line needs TOML only

    # [ and { differ by one bit, as ] and } do.
    marks = np.frombuffer(_STRING_OF_JSON.sub(b"", data), dtype=np.uint8) | np.uint8(0x20)
    steps = (marks == ord("{")).astype(np.int64) - (marks == ord("}"))
    return int(np.cumsum(steps).max(initial=0))
