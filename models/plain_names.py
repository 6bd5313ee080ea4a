"""Names of quantities: what may be one, and what a dash or a blank in one is read as.

A sensor's name becomes part of a function's name in C, of a header and of states; so it is made of
letters, digits and single underscores.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Container, Mapping, Sequence
from typing import Any

from models.errors import InputError
from models.shown_text import value_text

LONGEST_NAME = 64
RESERVED = ("time", "true")
"""What columns of a table begin with that are of no sensor."""
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9]*(?:_[A-Za-z0-9]+)*")


def plain_name(name: str) -> str:
    """Return a name with underscores for its dashes and blanks: ``imu accel`` → ``imu_accel``."""
    return re.sub(r"[-\s]+", "_", name.strip())


def check_name(name: object, where: str) -> None:
    """Raise `InputError` unless a name can be a sensor's."""
    if name in RESERVED:
        raise InputError(f"{where}: name {name} is of a column of its own, expected another one")
    if not (isinstance(name, str) and len(name) <= LONGEST_NAME and _NAME.fullmatch(name)):
        raise InputError(
            f"{where}: name {value_text(name)}, expected a letter, then letters, digits and single "
            f"underscores, {LONGEST_NAME} characters at most"
        )


def check_text(text: object, where: str) -> None:
    """Raise `InputError` unless a text is one printable line that is not empty or overlong.

    Names of states, inputs and axes may be in any script; tables and exports spell them out.
    """
    if not (isinstance(text, str) and text.strip() and len(text) <= 200 and text.isprintable()):
        raise InputError(
            f"{where}: {value_text(text)}, expected a printable text in one line, "
            "200 characters at most"
        )


def with_plain_names(table: Mapping[str, Any], where: str, kind: str) -> dict[str, Any]:
    """Return a table of a file with plain names as its keys; warns once where one is another.

    Parameters
    ----------
    where : the file and the table's key
    kind : of what is named: ``sensor``

    Raises
    ------
    InputError
        If a name cannot be one, or two become the same.
    """
    plain = {name: plain_name(name) for name in table}
    for name, read_as in plain.items():
        check_name(read_as, f"{where}: {kind} {value_text(name)}")
    if len(set(plain.values())) < len(plain):
        twice = next(name for name in plain.values() if list(plain.values()).count(name) > 1)
        raise InputError(f"{where}: {kind} {twice} stands there twice, expected it once")
    say_read_as(plain, where, kind)
    return {plain[name]: entry for name, entry in table.items()}


def plain_headers(headers: Sequence[str], known: Container[str], where: str) -> list[str]:
    """Return the headers of a table, an unknown one in its plain form where that is known."""
    read_as = {
        header: plain_name(header)
        if header not in known and plain_name(header) in known
        else header
        for header in headers
    }
    say_read_as(read_as, where, "column")
    return [read_as[header] for header in headers]


def say_read_as(read_as: Mapping[str, str], where: str, kind: str) -> None:
    """Warn of the first name that is read as another, and of how many there are."""
    changed = [(name, other) for name, other in read_as.items() if name != other]
    if changed:
        name, other = changed[0]
        more = f" (and {len(changed) - 1} more)" if len(changed) > 1 else ""
        warnings.warn(
            f"{where}: {kind} {value_text(name)} is read as {other}{more}",
            UserWarning,
            stacklevel=2,
        )
